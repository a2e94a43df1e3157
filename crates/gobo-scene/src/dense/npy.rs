//! `NumPy`'s arrays, formats 1.0 to 3.0, alone and in an archive:
//! <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.
use super::{
    array::{Axis, Layout, Number},
    file::DenseFile,
    packed,
    space::Place,
    voxels::Dense,
};
use crate::{error::quoted, plain::nearest, vdb::VolumeFault};
use std::io::{Cursor, Read as _};

const MAGIC: &[u8] = b"\x93NUMPY";
/// First bytes of a file in a zip archive, then the offsets of the name's length and of the name.
const ENTRY: &[u8] = b"PK\x03\x04";
const NAME_LENGTH: usize = 26;
const NAME: usize = 30;
const ENDING: &str = ".npy";
const WRITE_AGAIN: &str = "write it again with numpy.save";

pub(super) fn is(head: &[u8]) -> bool {
    head.starts_with(MAGIC)
}

/// Whether the first file of an archive is an array.
pub(super) fn is_archive(head: &[u8]) -> bool {
    let Some(&[low, high]) = head.get(NAME_LENGTH..NAME_LENGTH + 2) else { return false };
    let length = usize::from(u16::from_le_bytes([low, high]));
    let name = head.get(NAME..NAME + length);
    head.starts_with(ENTRY) && name.is_some_and(|name| name.ends_with(ENDING.as_bytes()))
}

pub(super) fn read(file: &mut DenseFile<'_>) -> Result<Dense, VolumeFault> {
    file.has_one_array()?;
    let header = NpyHeader::read(&file.bytes)?;
    let mut bytes = std::mem::take(&mut file.bytes);
    bytes.drain(..header.length);
    Dense::new(bytes, header.layout()?, Place::default())
}

/// Reads the named array from an archive, or else `density`, or else the first one.
pub(super) fn read_archive(file: &mut DenseFile<'_>) -> Result<Dense, VolumeFault> {
    let of_zip = |error: zip::result::ZipError| {
        VolumeFault::new(format!("the archive: {error}"), "write it again with numpy.savez")
    };
    let mut archive = zip::ZipArchive::new(Cursor::new(&file.bytes)).map_err(of_zip)?;
    let names: Vec<String> = archive
        .file_names()
        .filter_map(|name| name.strip_suffix(ENDING))
        .map(str::to_owned)
        .collect();
    let wanted = file.array.unwrap_or("density");
    let place = names.iter().position(|name| name == wanted);
    if let (None, Some(asked)) = (place, file.array) {
        let near = nearest(asked, names.iter().map(String::as_str)).unwrap_or_default();
        let message = format!("there is no array {}; {near}", quoted(asked));
        return Err(VolumeFault::new(
            message.trim_end_matches("; "),
            "name one of the file's arrays",
        ));
    }
    let Some(name) = names.get(place.unwrap_or(0)) else {
        return Err(VolumeFault::new(
            "no array is in the archive",
            "write it again with numpy.savez",
        ));
    };
    let mut entry = archive.by_name(&format!("{name}{ENDING}")).map_err(of_zip)?;
    let unpacks = |error| VolumeFault::damaged(format!("its voxels do not unpack: {error}"));
    // The size that the archive states may be wrong.
    let mut head = Vec::new();
    entry.by_ref().take(MOST_HEADER as u64).read_to_end(&mut head).map_err(unpacks)?;
    let header = NpyHeader::read(&head)?;
    let layout = header.layout()?;
    let (have, need) = (file.bytes.len(), layout.bytes());
    if need > have.saturating_mul(1032) {
        return Err(VolumeFault::damaged(format!(
            "{need} bytes of voxels in an archive of {have}"
        )));
    }
    let mut bytes = packed::room(need)?;
    bytes.extend_from_slice(&head[header.length..]);
    let rest = need.saturating_sub(bytes.len());
    entry.take(rest as u64).read_to_end(&mut bytes).map_err(unpacks)?;
    let mut dense = Dense::new(bytes, layout, Place::default())?;
    if file.array.is_none() && place.is_none() && names.len() > 1 {
        dense.notes.push(format!("of its {} arrays, {} is shown", names.len(), quoted(name)));
    }
    Ok(dense)
}

/// Longest header that is read \[bytes\].
const MOST_HEADER: usize = 1 << 16;

struct NpyHeader {
    number: Number,
    is_big: bool,
    is_fortran: bool,
    shape: Vec<u64>,
    /// Length with the magic \[bytes\].
    length: usize,
}

impl NpyHeader {
    fn read(bytes: &[u8]) -> Result<Self, VolumeFault> {
        let fault = |message: &str| VolumeFault::new(message, WRITE_AGAIN);
        let cut = || fault("the header of the array is cut off");
        if !is(bytes) {
            return Err(fault("this is no array of NumPy"));
        }
        let number = |range: std::ops::Range<usize>| {
            let digits = bytes.get(range)?;
            Some(digits.iter().rev().fold(0, |sum, &digit| sum << 8 | usize::from(digit)))
        };
        let start = match bytes.get(6) {
            Some(1) => 10,
            Some(2 | 3) => 12,
            _ => return Err(fault("a version of NumPy's format that is not 1 to 3")),
        };
        let length = number(8..start).ok_or_else(cut)?;
        if length > MOST_HEADER - start {
            return Err(fault("the header of the array is longer than any"));
        }
        let text = bytes.get(start..start + length).ok_or_else(cut)?;
        let text = String::from_utf8_lossy(text);
        let value = |key: &str| {
            let (_, rest) = text.split_once(&format!("'{key}'"))?;
            Some(rest.trim_start().strip_prefix(':')?.trim_start())
        };
        let missing = || fault("the header of the array lacks `descr`, `fortran_order` or `shape`");
        let descr = value("descr").and_then(|rest| rest.strip_prefix('\''));
        let descr = descr.and_then(|rest| rest.split('\'').next()).ok_or_else(|| {
            VolumeFault::new("the array has records", "save an array of plain numbers")
        })?;
        let (order, kind) = descr.split_at_checked(1).ok_or_else(missing)?;
        let number = match kind {
            "i1" => Number::I8,
            "u1" | "b1" => Number::U8,
            "i2" => Number::I16,
            "u2" => Number::U16,
            "i4" => Number::I32,
            "u4" => Number::U32,
            "i8" => Number::I64,
            "u8" => Number::U64,
            "f2" => Number::F16,
            "f4" => Number::F32,
            "f8" => Number::F64,
            _ => {
                let message = format!("the array has numbers of the kind {}", quoted(descr));
                return Err(VolumeFault::new(message, "save it as astype(\"f4\")"));
            }
        };
        let shape = value("shape").and_then(|rest| rest.strip_prefix('('));
        let shape = shape.and_then(|rest| rest.split(')').next()).ok_or_else(missing)?;
        let lengths = shape.split(',').map(str::trim).filter(|length| !length.is_empty());
        let shape: Result<Vec<u64>, _> = lengths.map(str::parse).collect();
        Ok(Self {
            number,
            is_big: order == ">",
            is_fortran: value("fortran_order").ok_or_else(missing)?.starts_with("True"),
            shape: shape.map_err(|_| fault("the shape of the array is not of whole numbers"))?,
            length: start + length,
        })
    }

    /// The array's axes are z, y, x and perhaps channels.
    fn layout(&self) -> Result<Layout, VolumeFault> {
        const HELP: &str =
            "save an array of the shape (z, y, x), or (z, y, x, 3) or (z, y, x, 4) with colours";
        let axes: &[Axis] = match self.shape[..] {
            [_, _, _] => &[Axis::Z, Axis::Y, Axis::X],
            [_, _, _, 1 | 3 | 4] => &[Axis::Z, Axis::Y, Axis::X, Axis::Channel],
            _ => {
                let message = format!("the array has the shape {:?}", self.shape);
                return Err(VolumeFault::new(message, HELP));
            }
        };
        let mut axes: Vec<_> = self.shape.iter().copied().zip(axes.iter().copied()).collect();
        if !self.is_fortran {
            axes.reverse();
        }
        Layout::new(self.number, self.is_big, &axes)
    }
}
