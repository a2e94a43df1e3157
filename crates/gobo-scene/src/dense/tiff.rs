//! Stacks of TIFF pages: TIFF 6.0, with `ImageJ`'s spacing in the first page's description.
use super::{
    array::{Axis, Layout, Number},
    file::DenseFile,
    packed::MOST_BYTES,
    space::Place,
    voxels::Dense,
};
use crate::{limits::has_memory, units::unit_named, vdb::VolumeFault};
use glam::DVec3;
use std::io::Cursor;
use tiff::{
    ColorType, TiffError,
    decoder::{Decoder, DecodingResult, Limits},
    tags::Tag,
};

pub(super) fn is(head: &[u8]) -> bool {
    [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|magic| head.starts_with(*magic))
}

type Pages<'a> = Decoder<Cursor<&'a [u8]>>;

fn wrong(error: &TiffError) -> VolumeFault {
    let help = "write pages of grey or rgb, plain or packed by deflate or LZW";
    VolumeFault::new(format!("a page: {error}"), help)
}

pub(super) fn read(file: &mut DenseFile<'_>) -> Result<Dense, VolumeFault> {
    file.has_one_array()?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MOST_BYTES;
    limits.intermediate_buffer_size = MOST_BYTES;
    let pages = Decoder::new(Cursor::new(&file.bytes[..])).map_err(|error| wrong(&error))?;
    let mut pages = pages.with_limits(limits);
    let spacing = Spacing::read(&mut pages);
    let (mut bytes, mut count, mut first) = (Vec::new(), 0, None);
    loop {
        let (size, kind) = (pages.dimensions(), pages.colortype());
        let (size, kind) = (size.map_err(|e| wrong(&e))?, kind.map_err(|e| wrong(&e))?);
        let (channels, bits) = match kind {
            ColorType::Gray(bits) => (1, bits),
            ColorType::RGB(bits) => (3, bits),
            ColorType::RGBA(bits) => (4, bits),
            other => {
                let help = "write pages of grey, rgb or rgba";
                return Err(VolumeFault::new(format!("pages of {other:?}"), help));
            }
        };
        let page = u64::from(size.0) * u64::from(size.1) * channels * u64::from(bits.div_ceil(8));
        if page.saturating_add(bytes.len() as u64) > MOST_BYTES as u64 || !has_memory(page) {
            let help = "use a smaller stack, or cut it into several files";
            return Err(VolumeFault::new(
                "its pages are more than 2 GiB, or than there is memory",
                help,
            ));
        }
        let numbers = pages.read_image().map_err(|error| wrong(&error))?;
        let number = append(&mut bytes, &numbers)?;
        let own = (size, channels, number);
        if *first.get_or_insert(own) != own {
            let help = "write pages of one size and type";
            return Err(VolumeFault::new(format!("page {} is unlike the first", count + 1), help));
        }
        count += 1;
        if !pages.more_images() {
            break;
        }
        pages.next_image().map_err(|error| wrong(&error))?;
    }
    let ((width, height), channels, number) = first.unwrap_or(((0, 0), 1, Number::U8));
    let axes = [
        (channels, Axis::Channel),
        (width.into(), Axis::X),
        (height.into(), Axis::Y),
        (count, Axis::Z),
    ];
    Dense::new(bytes, Layout::new(number, false, &axes)?, spacing.place())
}

/// Adds the numbers of a page, the lowest byte first.
fn append(bytes: &mut Vec<u8>, numbers: &DecodingResult) -> Result<Number, VolumeFault> {
    macro_rules! extend {
        ($values:expr, $number:ident) => {{
            bytes.extend($values.iter().flat_map(|value| value.to_le_bytes()));
            Number::$number
        }};
    }
    Ok(match numbers {
        DecodingResult::U8(values) => extend!(values, U8),
        DecodingResult::U16(values) => extend!(values, U16),
        DecodingResult::U32(values) => extend!(values, U32),
        DecodingResult::U64(values) => extend!(values, U64),
        DecodingResult::I8(values) => extend!(values, I8),
        DecodingResult::I16(values) => extend!(values, I16),
        DecodingResult::I32(values) => extend!(values, I32),
        DecodingResult::I64(values) => extend!(values, I64),
        DecodingResult::F16(values) => extend!(values, F16),
        DecodingResult::F32(values) => extend!(values, F32),
        DecodingResult::F64(values) => extend!(values, F64),
    })
}

/// Edges of a voxel, in a unit \[m\] if one is stated.
struct Spacing {
    edges: DVec3,
    unit: Option<f64>,
}

impl Spacing {
    fn read(pages: &mut Pages<'_>) -> Self {
        let text = pages.get_tag_ascii_string(Tag::ImageDescription).unwrap_or_default();
        let value =
            |key: &str| text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='));
        let mut spacing = Self { edges: DVec3::ONE, unit: None };
        if value("ImageJ").is_none() {
            return spacing;
        }
        spacing.unit = value("unit").and_then(unit_named);
        // Texels per unit.
        let mut edge = |tag| {
            let value = pages.find_tag(tag).ok().flatten()?;
            let resolution = match value {
                tiff::decoder::ifd::Value::Rational(above, below) => {
                    f64::from(above) / f64::from(below)
                }
                value => f64::from(value.into_f32().ok()?),
            };
            Some(1.0 / resolution).filter(|edge| edge.is_finite() && *edge > 0.0)
        };
        let between = value("spacing").and_then(|spacing| spacing.trim().parse::<f64>().ok());
        let between = between.map(f64::abs).filter(|edge| edge.is_finite() && *edge > 0.0);
        let edges = [edge(Tag::XResolution), edge(Tag::YResolution), between];
        spacing.edges = DVec3::from_array(edges.map(|edge| edge.unwrap_or(1.0)));
        spacing
    }

    /// Rows go down, and pages back.
    fn place(&self) -> Place {
        let DVec3 { x, y, z } = self.edges;
        let axes = [DVec3::X * x, DVec3::NEG_Y * y, DVec3::NEG_Z * z];
        Place { unit: self.unit, ..Place::new(axes, DVec3::ZERO) }
    }
}
