//! Bytes that a lane reads and writes, from a kernel's machine code (AMD's assembly, as RADV prints it). Each access
//! of the code counts once: those of a loop, of one turn; those of two branches, of both. What a wave reads once for all
//! lanes (scalar loads), and workgroup memory, do not count.
use serde::{Deserialize, Serialize};

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
}
