//! Reading of `NanoVDB` files (Museth 2021, "`NanoVDB`: A GPU-Friendly and Portable VDB Data Structure"),
//! layouts of version 32: segments of grids, or grids alone.
use super::{
    Vdb, VdbGrid,
    input::{Input, VolumeFault},
    nano_tree::{NanoType, tree},
    shown,
    values::{blosc, inflate},
};
use crate::limits::has_memory;
use glam::{DAffine3, DMat3, DVec3};
use std::borrow::Cow;

/// First bytes of all files, then the byte of single grids and that of segments.
const MAGIC: [u8; 7] = *b"NanoVDB";
const GRID_ALONE: u8 = b'1';
/// Size of a grid's head \[bytes\].
pub(super) const GRID: usize = 672;
const VERSION: u32 = 32;
const HELP: &str = "write it with NanoVDB 32, as OpenVDB 11 to 13 do";

/// Compression of a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Codec {
    Plain,
    Zip,
    Blosc,
}

/// Head of a grid.
#[derive(Clone, Debug)]
pub(super) struct NanoHead {
    pub(super) name: String,
    kind: NanoType,
    codec: Codec,
    /// Offset of its first byte, and its size in the file and unpacked \[bytes\].
    start: usize,
    stored: usize,
    length: usize,
}

/// Whether the first bytes are those of a `NanoVDB` file.
pub(super) fn is(head: &[u8]) -> bool {
    head.starts_with(&MAGIC)
}

/// Heads of the readable grids, and the unreadable ones, a sentence each.
pub(super) fn heads(bytes: &[u8]) -> Result<(Vec<NanoHead>, Vec<String>), VolumeFault> {
    let (mut heads, mut unread, mut at) = (Vec::new(), Vec::new(), 0);
    while at < bytes.len() {
        let mut input = Input::new(bytes, at)?;
        let magic = input.take(8, "the head of the file")?;
        if !magic.starts_with(&MAGIC) {
            let message = format!("at byte {at} no grid of NanoVDB starts");
            return Err(VolumeFault::damaged(message));
        }
        let start = heads.len() + unread.len();
        at = match magic[7] {
            GRID_ALONE => alone(bytes, at, &mut heads, &mut unread)?,
            _ => segment(bytes, at, &mut heads, &mut unread)?,
        };
        if heads.len() + unread.len() == start {
            return Err(VolumeFault::damaged("a segment has no grids"));
        }
    }
    Ok((heads, unread))
}

fn check(version: u32) -> Result<(), VolumeFault> {
    let major = version >> 21;
    if major == VERSION {
        return Ok(());
    }
    Err(VolumeFault::new(format!("version {major} of NanoVDB's layout"), HELP))
}

/// Adds a grid or, if it cannot be read, the reason.
fn add(
    heads: &mut Vec<NanoHead>,
    unread: &mut Vec<String>,
    head: (&str, u32),
    of: impl FnOnce(NanoType) -> NanoHead,
) {
    let (name, number) = head;
    match NanoType::of(number) {
        Some(kind) => heads.push(of(kind)),
        None => unread.push(format!("grid {} is not read: its type is {number}", shown(name))),
    }
}

/// A grid outside segments; returns the offset of the next one.
fn alone(
    bytes: &[u8],
    at: usize,
    heads: &mut Vec<NanoHead>,
    unread: &mut Vec<String>,
) -> Result<usize, VolumeFault> {
    const WHAT: &str = "the head of a grid";
    let head = Input::new(bytes, at)?.take(GRID, WHAT)?;
    let own = |place: usize| Input::new(head, place);
    check(own(16)?.u32(WHAT)?)?;
    let length = own(32)?.i64(WHAT)?;
    let number = own(636)?.u32(WHAT)?;
    let name = text(&head[40..296]);
    let length = usize::try_from(length).ok().filter(|&length| length >= GRID);
    let end = length.and_then(|length| at.checked_add(length)).filter(|&end| end <= bytes.len());
    let (Some(length), Some(end)) = (length, end) else {
        return Err(VolumeFault::damaged(format!(
            "the grid {} ends outside of the file",
            shown(&name)
        )));
    };
    add(heads, unread, (&name.clone(), number), |kind| NanoHead {
        name,
        kind,
        codec: Codec::Plain,
        start: at,
        stored: length,
        length,
    });
    Ok(end)
}

/// The grids of a segment; returns the offset of its end.
fn segment(
    bytes: &[u8],
    at: usize,
    heads: &mut Vec<NanoHead>,
    unread: &mut Vec<String>,
) -> Result<usize, VolumeFault> {
    const WHAT: &str = "the head of a segment";
    /// Size of the metadata of each grid \[bytes\].
    const ABOUT: usize = 176;
    let mut input = Input::new(bytes, at + 8)?;
    check(input.u32(WHAT)?)?;
    let counts = input.u32(WHAT)?;
    let mut found = Vec::new();
    for _ in 0..counts & 0xffff {
        let about = input.take(ABOUT, WHAT)?;
        let number = |place: usize| Input::new(about, place)?.u32(WHAT);
        let long = |place: usize| {
            let value = Input::new(about, place)?.i64(WHAT)?;
            Ok(usize::try_from(value).unwrap_or(usize::MAX))
        };
        let name = text(input.take(number(136)? as usize, "the name of a grid")?);
        let codec = match number(168)? & 0xffff {
            0 => Codec::Plain,
            1 => Codec::Zip,
            2 => Codec::Blosc,
            other => return Err(VolumeFault::damaged(format!("a grid is packed in way {other}"))),
        };
        found.push((name, number(32)?, codec, long(0)?, long(8)?));
    }
    let mut start = input.at();
    for (name, number, codec, length, stored) in found {
        Input::new(bytes, start)?.take(stored, &format!("the grid {}", shown(&name)))?;
        let own = start;
        start += stored;
        add(heads, unread, (&name.clone(), number), |kind| NanoHead {
            name,
            kind,
            codec,
            start: own,
            stored,
            length,
        });
    }
    Ok(start)
}

/// A text up to its terminating zero.
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

/// The bytes of a grid.
fn unpacked<'a>(bytes: &'a [u8], head: &NanoHead) -> Result<Cow<'a, [u8]>, VolumeFault> {
    /// Most bytes that a byte unpacks to, for deflate and for LZ4.
    const MOST_RATIO: usize = 1032;
    /// Largest block that Blosc compresses separately \[bytes\].
    const PART: usize = 1 << 30;
    let stored = &bytes[head.start..head.start + head.stored];
    if head.codec == Codec::Plain {
        return Ok(Cow::Borrowed(stored));
    }
    if head.length > head.stored.saturating_mul(MOST_RATIO) || !has_memory(head.length as u64) {
        let message = format!("{} bytes in {} packed ones", head.length, head.stored);
        return Err(VolumeFault::damaged(message));
    }
    let mut unpacked = vec![0; head.length];
    let mut input = Input::new(stored, 0)?;
    let part = |input: &mut Input<'_>| {
        let length = input.i64("the length of a packed grid")?;
        let at = input.at();
        input.take(usize::try_from(length).unwrap_or(usize::MAX), "a packed grid")?;
        Ok((at, input.at()))
    };
    if head.codec == Codec::Zip {
        let (start, end) = part(&mut input)?;
        inflate(&stored[start..end], &mut unpacked)?;
        return Ok(Cow::Owned(unpacked));
    }
    let mut shuffled = Vec::new();
    for out in unpacked.chunks_mut(PART) {
        let (start, end) = part(&mut input)?;
        blosc(&stored[start..end], out, &mut shuffled)?;
    }
    Ok(Cow::Owned(unpacked))
}

impl Vdb {
    /// Reads a grid of a `NanoVDB` file.
    pub(super) fn read_nano(
        &self,
        head: &NanoHead,
        has_values: bool,
    ) -> Result<VdbGrid, VolumeFault> {
        const LEVEL_SET: u32 = 1;
        const WHAT: &str = "the head of a grid";
        let grid = unpacked(&self.bytes, head)?;
        let number = |at: usize| Input::new(&grid, at)?.u32(WHAT);
        check(number(16)?)?;
        if NanoType::of(number(636)?) != Some(head.kind) {
            return Err(VolumeFault::damaged(
                "the type of the grid is not the one that the file says",
            ));
        }
        // Rows of a matrix in doubles, and the translation.
        let double = |at: usize| Input::new(&grid, at)?.f64(WHAT);
        let mut rows = [0.0; 9];
        for (i, row) in rows.iter_mut().enumerate() {
            *row = double(384 + 8 * i)?;
        }
        let world_from_index = DAffine3 {
            matrix3: DMat3::from_cols_array(&rows).transpose(),
            translation: DVec3::new(double(528)?, double(536)?, double(544)?),
        };
        super::check(&world_from_index)?;
        let class = if number(632)? == LEVEL_SET { "level set" } else { "" };
        let (tree, background) = tree(&grid, head.kind, has_values)?;
        Ok(VdbGrid { world_from_index, class: class.to_owned(), background, tree })
    }
}
