//! VTK's `ImageData` in XML: <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.
use super::{
    array::{Axis, Layout, Number},
    file::DenseFile,
    packed::{self, Packing, unpacked},
    space::Place,
    text,
    voxels::Dense,
};
use crate::{error::quoted, plain::nearest, vdb::VolumeFault};
use base64::{Engine as _, engine::general_purpose::STANDARD};
use glam::{DMat3, DVec3};
use roxmltree::{Document, Node, ParsingOptions};

/// Most XML nodes that are read.
const MOST_NODES: u32 = 100_000;
const APPENDED: &[u8] = b"<AppendedData";

pub(super) fn is(head: &[u8]) -> bool {
    let text = &head[..head.len().min(4096)];
    let has = |word: &[u8]| find(text, word, 0).is_some();
    text.trim_ascii_start().starts_with(b"<") && has(b"<VTKFile") && has(b"ImageData")
}

fn find(bytes: &[u8], word: &[u8], from: usize) -> Option<usize> {
    bytes.get(from..)?.windows(word.len()).position(|window| window == word).map(|at| at + from)
}

fn wrong(message: impl Into<String>) -> VolumeFault {
    VolumeFault::new(message, "write the file again as .vti, in one piece")
}

pub(super) fn read(file: &mut DenseFile<'_>) -> Result<Dense, VolumeFault> {
    // Appended data need not be text.
    let appended = find(&file.bytes, APPENDED, 0);
    let end = appended.and_then(|at| find(&file.bytes, b">", at)).map(|at| at + 1);
    let data = end.and_then(|end| find(&file.bytes, b"_", end)).map(|at| &file.bytes[at + 1..]);
    let head = &file.bytes[..end.unwrap_or(file.bytes.len())];
    let head = std::str::from_utf8(head).map_err(|_| wrong("its text is not UTF-8"))?;
    let closed = end.map(|_| format!("{head}</AppendedData></VTKFile>"));
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(closed.as_deref().unwrap_or(head), options)
        .map_err(|error| wrong(format!("its XML: {error}")))?;
    let root = document.root_element();
    let child = |node: Node<'_, '_>, name: &str| -> Option<roxmltree::NodeId> {
        node.children().find(|child| child.has_tag_name(name)).map(|child| child.id())
    };
    let missing = |name: &str| wrong(format!("its XML has no {name}"));
    let of = |node: Node<'_, '_>, name: &str| {
        let id = child(node, name).ok_or_else(|| missing(name))?;
        document.get_node(id).ok_or_else(|| missing(name))
    };
    let image = of(root, "ImageData")?;
    let piece = of(image, "Piece")?;
    if image.children().filter(|child| child.has_tag_name("Piece")).count() > 1 {
        return Err(wrong("it is in several pieces"));
    }
    let (array, is_cells) = array(piece, file.array)?;
    let extent = piece.attribute("Extent").or(image.attribute("WholeExtent"));
    let extent = text::numbers("Extent", extent.ok_or_else(|| missing("Extent"))?)?;
    let &[x0, x1, y0, y1, z0, z1] = &extent[..] else {
        return Err(wrong("its Extent is not of six numbers"));
    };
    let (first, last) = (DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1));
    let size = last - first + if is_cells { 0.0 } else { 1.0 };
    if !(size.cmpge(DVec3::ONE).all() && size.max_element() < 1e9) {
        return Err(wrong(format!("its Extent is of {size} voxels")));
    }
    let number = number(array.attribute("type").unwrap_or_default())?;
    let is_text = array.attribute("format") == Some("ascii");
    let number = if is_text { Number::F64 } else { number };
    let channels = array.attribute("NumberOfComponents").unwrap_or("1");
    let channels = channels.parse().map_err(|_| wrong("NumberOfComponents is no number"))?;
    let is_big = !is_text && root.attribute("byte_order") == Some("BigEndian");
    let mut axes = vec![(channels, Axis::Channel)];
    axes.extend(size.to_array().map(|length| length as u64).into_iter().zip(Axis::SPACE));
    let layout = Layout::new(number, is_big, &axes)?;
    let stream = Stream {
        is_big: root.attribute("byte_order") == Some("BigEndian"),
        is_wide: root.attribute("header_type") == Some("UInt64"),
        compressor: root.attribute("compressor"),
        need: layout.bytes(),
    };
    let inline = || array.text().unwrap_or_default().trim_ascii().as_bytes();
    let bytes = match array.attribute("format") {
        Some("ascii") => text::doubles(inline(), stream.need / number.bytes())?,
        Some("binary") => stream.read(inline(), true)?,
        Some("appended") => {
            let offset: usize = array
                .attribute("offset")
                .and_then(|offset| offset.parse().ok())
                .ok_or_else(|| wrong("an array without an offset"))?;
            let data = data.and_then(|data| data.get(offset..));
            let data = data.ok_or_else(|| VolumeFault::damaged("its appended data are cut off"))?;
            let node = of(root, "AppendedData")?;
            stream.read(data, node.attribute("encoding") == Some("base64"))?
        }
        other => {
            return Err(wrong(format!("data of the format {}", quoted(other.unwrap_or_default()))));
        }
    };
    let vector = |key: &str, usual: f64| {
        let numbers = text::numbers(key, image.attribute(key).unwrap_or_default())?;
        Ok(text::three(&numbers, usual))
    };
    let (origin, spacing) = (vector("Origin", 0.0)?, vector("Spacing", 1.0)?);
    let rows = text::numbers("Direction", image.attribute("Direction").unwrap_or_default())?;
    let rows: Option<[f64; 9]> = rows.try_into().ok();
    // The file stores the matrix by rows, glam by columns.
    let turn = rows.map_or(DMat3::IDENTITY, |rows| DMat3::from_cols_array(&rows).transpose());
    let start = first + if is_cells { 0.5 } else { 0.0 };
    let axes = std::array::from_fn(|i| turn.col(i) * spacing[i]);
    Dense::new(bytes, layout, Place::new(axes, origin + turn * (start * spacing)))
}

/// The named array, or else the scalars, or else the first array, points before cells; and whether it is of
/// cells.
fn array<'a, 'input>(
    piece: Node<'a, 'input>,
    name: Option<&str>,
) -> Result<(Node<'a, 'input>, bool), VolumeFault> {
    let mut found = Vec::new();
    for (tag, is_cells) in [("PointData", false), ("CellData", true)] {
        for data in piece.children().filter(|child| child.has_tag_name(tag)) {
            let scalars = data.attribute("Scalars");
            for array in data.children().filter(|child| child.has_tag_name("DataArray")) {
                let own = array.attribute("Name").unwrap_or_default();
                let rank = (Some(own) != scalars, is_cells);
                found.push((rank, own, array, is_cells));
            }
        }
    }
    if let Some(asked) = name {
        let of_name = found.iter().find(|(_, own, ..)| *own == asked);
        return of_name.map(|&(_, _, array, is_cells)| (array, is_cells)).ok_or_else(|| {
            let near = nearest(asked, found.iter().map(|(_, own, ..)| *own)).unwrap_or_default();
            let message = format!("there is no array {}; {near}", quoted(asked));
            VolumeFault::new(message.trim_end_matches("; "), "name one of the file's arrays")
        });
    }
    let first = found.into_iter().min_by_key(|&(rank, ..)| rank);
    first
        .map(|(_, _, array, is_cells)| (array, is_cells))
        .ok_or_else(|| wrong("it has no array of points or cells"))
}

fn number(name: &str) -> Result<Number, VolumeFault> {
    Ok(match name {
        "Int8" => Number::I8,
        "UInt8" => Number::U8,
        "Int16" => Number::I16,
        "UInt16" => Number::U16,
        "Int32" => Number::I32,
        "UInt32" => Number::U32,
        "Int64" => Number::I64,
        "UInt64" => Number::U64,
        "Float32" => Number::F32,
        "Float64" => Number::F64,
        other => return Err(wrong(format!("its numbers are of the type {}", quoted(other)))),
    })
}

/// Encoding of an array's bytes.
struct Stream<'a> {
    is_big: bool,
    /// Whether lengths have 8 bytes.
    is_wide: bool,
    compressor: Option<&'a str>,
    /// Bytes of the array.
    need: usize,
}

impl Stream<'_> {
    /// The array's bytes, which follow their lengths in the file.
    fn read(&self, data: &[u8], is_base64: bool) -> Result<Vec<u8>, VolumeFault> {
        let width = if self.is_wide { 8 } else { 4 };
        let Some(compressor) = self.compressor else {
            let whole = VtiBytes::new(data, is_base64).bytes(width + self.need)?;
            let length = self.length(&whole, 0)?;
            if length < self.need {
                let message = format!("an array of {length} bytes instead of {}", self.need);
                return Err(VolumeFault::damaged(message));
            }
            return Ok(whole.get(width..).unwrap_or_default().to_vec());
        };
        let part = VtiBytes::new(data, is_base64);
        let count = self.length(&part.bytes(3 * width)?, 0)?;
        let head = width.saturating_mul(count.saturating_add(3));
        if head > data.len() {
            return Err(VolumeFault::damaged(format!("an array of {count} blocks")));
        }
        let lengths = part.bytes(head)?;
        let (block, last) = (self.length(&lengths, 1)?, self.length(&lengths, 2)?);
        let mut packed = Vec::with_capacity(count);
        for i in 0..count {
            packed.push(self.length(&lengths, 3 + i)?);
        }
        let all = packed.iter().try_fold(0_usize, |sum, &length| sum.checked_add(length));
        let all = all.filter(|&all| all <= data.len());
        let all = all.ok_or_else(|| VolumeFault::damaged("its packed blocks are cut off"))?;
        let bytes = part.behind(head).bytes(all)?;
        let mut whole = packed::room(self.need.min(all.saturating_mul(1032)))?;
        let mut rest = &bytes[..];
        for (i, length) in packed.into_iter().enumerate() {
            let (own, behind) = rest.split_at_checked(length).unwrap_or((rest, &[]));
            let size = if i + 1 == count && last > 0 { last } else { block };
            whole.extend(match compressor {
                "vtkZLibDataCompressor" => unpacked(Packing::Zlib, own, size)?,
                "vtkLZ4DataCompressor" => lz4(own, size)?,
                other => {
                    let help = "write it with zlib, LZ4 or not packed at all";
                    return Err(VolumeFault::new(format!("packed by {}", quoted(other)), help));
                }
            });
            rest = behind;
            if whole.len() > self.need {
                break;
            }
        }
        Ok(whole)
    }

    /// The length at byte `place`.
    fn length(&self, bytes: &[u8], place: usize) -> Result<usize, VolumeFault> {
        let width = if self.is_wide { 8 } else { 4 };
        let own = bytes.get(place * width..(place + 1) * width);
        let own = own.ok_or_else(|| VolumeFault::damaged("the length of an array is cut off"))?;
        let digit = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        let length =
            if self.is_big { own.iter().fold(0, digit) } else { own.iter().rev().fold(0, digit) };
        Ok(usize::try_from(length).unwrap_or(usize::MAX))
    }
}

fn lz4(packed: &[u8], size: usize) -> Result<Vec<u8>, VolumeFault> {
    /// Most bytes that a byte of LZ4 unpacks to.
    const MOST_RATIO: usize = 255;
    if size > packed.len().saturating_mul(MOST_RATIO) {
        return Err(VolumeFault::damaged(format!("{size} bytes in {} packed ones", packed.len())));
    }
    let mut bytes = packed::room(size)?;
    bytes.resize(size, 0);
    let unpacked = lz4_flex::block::decompress_into(packed, &mut bytes)
        .map_err(|error| VolumeFault::damaged(format!("its voxels do not unpack: {error}")))?;
    bytes.truncate(unpacked);
    Ok(bytes)
}

/// Raw bytes, or base64 text.
#[derive(Clone, Copy)]
struct VtiBytes<'a> {
    data: &'a [u8],
    is_base64: bool,
}

impl<'a> VtiBytes<'a> {
    fn new(data: &'a [u8], is_base64: bool) -> Self {
        Self { data, is_base64 }
    }

    /// The first `length` bytes, or fewer if the data end.
    fn bytes(self, length: usize) -> Result<Vec<u8>, VolumeFault> {
        if !self.is_base64 {
            return Ok(self.data[..length.min(self.data.len())].to_vec());
        }
        let end = length.div_ceil(3).saturating_mul(4).min(self.data.len());
        let letters = &self.data[..end];
        let end = letters.iter().position(|&byte| byte == b'<' || byte.is_ascii_whitespace());
        let mut bytes = STANDARD
            .decode(&letters[..end.unwrap_or(letters.len())])
            .map_err(|error| VolumeFault::damaged(format!("its base64: {error}")))?;
        bytes.truncate(length);
        Ok(bytes)
    }

    /// Data after the first `length` bytes, which were encoded on their own.
    fn behind(self, length: usize) -> Self {
        let at = if self.is_base64 { length.div_ceil(3).saturating_mul(4) } else { length };
        Self { data: self.data.get(at..).unwrap_or_default(), ..self }
    }
}
