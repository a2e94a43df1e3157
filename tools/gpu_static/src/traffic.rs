//! Bytes that a lane reads and writes, and instructions of a visit, from a kernel's machine code (AMD's assembly, as RADV
//! prints it). Each access of the code counts once: those of a loop, of one turn; those of two branches, of both. What a
//! wave reads once for all lanes (scalar loads), and workgroup memory, do not count.
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Bytes of a lane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Traffic {
    /// From buffers and textures.
    pub read: u64,
    /// To buffers, atomics among them.
    pub to_buffers: u64,
    /// To storage textures, atomics among them: four a channel.
    pub to_textures: u64,
}

/// Of machine code.
pub fn traffic(assembly: &str) -> Traffic {
    let mut sum = Traffic::default();
    for line in assembly.lines() {
        let line = line.trim_start();
        let name = line.split_whitespace().next().unwrap_or_default();
        let is_image = name.starts_with("image_");
        let buffer = ["buffer_", "tbuffer_", "global_", "flat_"];
        if !is_image && !buffer.iter().any(|start| name.starts_with(start)) {
            continue;
        }
        let bytes = if is_image { channels(line) * 4 } else { width(name) };
        let is = |all: &[&str]| all.iter().any(|it| name.contains(it));
        if is(&["_store", "_atomic"]) {
            *(if is_image { &mut sum.to_textures } else { &mut sum.to_buffers }) += bytes;
        } else if is(&["_load", "_sample", "_gather4"]) {
            sum.read += bytes;
        }
    }
    sum
}

/// Instructions with which a wave visits a caster: those of the innermost loop that takes the next of a ballot's casters,
/// both sides of each branch. None where no loop does.
pub fn visit(assembly: &str) -> Option<u64> {
    let (mut labels, mut next) = (BTreeMap::new(), Vec::new());
    let (mut count, mut least) = (0, None);
    for line in assembly.lines() {
        let line = line.trim_start();
        let mut words = line.split_whitespace();
        let name = words.next().unwrap_or_default();
        if let Some(label) = name.strip_suffix(':') {
            labels.insert(label, count);
            continue;
        }
        if name.is_empty() || name.starts_with(';') {
            continue;
        }
        count += 1;
        // Its names until and since GFX11, where a shuffle is a loop over the lanes that are active, `exec`.
        let is_next = name.starts_with("s_ff1_") || name.starts_with("s_ctz_");
        if is_next && !line.contains(", exec") {
            next.push(count);
        }
        let is_branch = name.starts_with("s_branch") || name.starts_with("s_cbranch");
        let back = words.next().filter(|_| is_branch).and_then(|label| labels.get(label));
        if let Some(&start) = back.filter(|&&start| next.iter().any(|&at| at > start)) {
            let turn = count - start;
            least = Some(least.map_or(turn, |least: u64| least.min(turn)));
        }
    }
    least
}

/// Channels of an access of a texture: the bits of its mask.
fn channels(line: &str) -> u64 {
    let mask = line.split_once("dmask:").map_or("", |(_, rest)| rest);
    let mask = mask.split_whitespace().next().unwrap_or_default().trim_start_matches("0x");
    u64::from_str_radix(mask, 16).unwrap_or(1).count_ones().into()
}

/// Bytes of an access of a buffer, by its name: `buffer_load_dwordx4`, `global_load_b128`, `buffer_atomic_add`.
fn width(name: &str) -> u64 {
    let end = |ends: &[&str]| ends.iter().any(|it| name.ends_with(it));
    if end(&["dwordx4", "b128", "xyzw"]) {
        16
    } else if end(&["dwordx3", "b96", "xyz"]) {
        12
    } else if end(&["dwordx2", "b64", "_x2", "xy"]) {
        8
    } else if end(&["ubyte", "sbyte", "byte", "u8", "i8", "b8"]) {
        1
    } else if end(&["ushort", "sshort", "short", "u16", "i16", "b16"]) {
        2
    } else {
        4
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accesses_count_by_their_width() {
        let code = "s_buffer_load_dwordx4 s[0:3], s[4:7], 0x0\n\
            \tbuffer_load_dwordx4 v[0:3], v4, s[0:3], 0 offen ; e0001000\n\
            buffer_load_ubyte v0, v1, s[0:3], 0 offen\n\
            image_load v[0:1], v[2:3], s[0:7] dmask:0x3 dim:SQ_RSRC_IMG_2D_ARRAY unorm\n\
            image_store v[0:3], v[2:3], s[0:7] dmask:0xf dim:SQ_RSRC_IMG_2D_ARRAY unorm\n\
            image_atomic_umin v0, v[2:3], s[0:7] dmask:0x1 dim:SQ_RSRC_IMG_2D_ARRAY\n\
            buffer_store_dwordx2 v[0:1], v2, s[0:3], 0 offen\n\
            buffer_atomic_add v0, v2, s[0:3], 0 offen glc\n\
            ds_write_b64 v0, v[1:2]\nv_add_f32 v0, v1, v2\n";
        assert_eq!(traffic(code), Traffic { read: 25, to_buffers: 12, to_textures: 20 });
    }

    #[test]
    fn a_visit_is_the_innermost_loop_over_a_ballot() {
        // Tiles; batches of pairs, a lane each; casters of a ballot, with a branch; cells of a caster.
        let code = "BB0:\n\ts_load_dwordx4 s[0:3], s[2:3], 0x0\n\
            BB1:\n\
            \ts_mov_b32 s5, 0\n\
            BB2:\n\
            \tbuffer_load_dwordx4 v[0:3], v4, s[0:3], 0 offen ; e0001000\n\
            \tv_cmp_lt_f32 vcc_lo, v0, v1\n\
            BB3:\n\
            \ts_ff1_i32_b32 s6, vcc_lo\n\
            \tv_readlane_b32 s7, v0, s6\n\
            \ts_cbranch_scc1 BB5\n\
            BB4:\n\
            \tv_mul_f32 v5, v5, s7\n\
            \ts_cbranch_scc0 BB4\n\
            BB5:\n\
            \ts_cbranch_scc1 BB6\n\
            ; a comment\n\
            \n\
            \ts_branch BB3\n\
            BB6:\n\
            \ts_cbranch_scc0 BB2\n\
            \ts_cbranch_scc0 BB1\n\
            \ts_endpgm\n";
        assert_eq!(visit(code), Some(7));
        assert_eq!(visit(&code.replace("s_ff1_i32_b32", "s_ctz_i32_b32")), Some(7));
        assert_eq!(visit(&code.replace("s_branch BB3", "s_branch BB6")), Some(10));
        for other in [["s_ff1_i32_b32", "s_mov_b32"], ["s6, vcc_lo", "s6, exec_lo"]] {
            assert_eq!(visit(&code.replace(other[0], other[1])), None);
        }
        assert_eq!(visit(""), None);
    }
}
