//! NRRD of teem, with its data inside or in another file: <https://teem.sourceforge.net/nrrd/format.html>.
use super::{
    array::{Axis, Layout, Number},
    file::{DenseFile, beside, bytes_beside},
    packed::{Packing, unpacked},
    space::{BodyAxes, Place},
    text,
    voxels::Dense,
};
use crate::{error::quoted, units::unit_named, vdb::VolumeFault};
use glam::DVec3;
use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

const MAGIC: &[u8] = b"NRRD000";

pub(super) fn is(head: &[u8]) -> bool {
    head.starts_with(MAGIC)
}

pub(super) fn named(head: &[u8], path: &Path) -> Option<PathBuf> {
    let (fields, _) = fields(head);
    beside(path, fields.get("data file")?).ok()
}

/// Fields by their names in lower case, and the offset of the data.
fn fields(bytes: &[u8]) -> (HashMap<String, &str>, usize) {
    let (mut fields, mut at) = (HashMap::new(), 0);
    while let Some((line, next)) = text::line(bytes, at) {
        at = next;
        if line.is_empty() {
            break;
        }
        // Pairs with `:=` are the user's own.
        let field = line.split_once(':').filter(|(_, value)| !value.starts_with('='));
        if let Some((key, value)) = field.filter(|_| !line.starts_with('#')) {
            let key = match &*key.trim().to_ascii_lowercase() {
                "datafile" => "data file".to_owned(),
                "lineskip" => "line skip".to_owned(),
                "byteskip" => "byte skip".to_owned(),
                key => key.to_owned(),
            };
            fields.insert(key, value.trim());
        }
    }
    (fields, at)
}

pub(super) fn read(file: &mut DenseFile<'_>) -> Result<Dense, VolumeFault> {
    file.has_one_array()?;
    let (fields, start) = fields(&file.bytes);
    let field = |key: &str| fields.get(key).copied();
    let need = |key: &str| {
        let message = format!("the header has no field `{key}`");
        field(key).ok_or_else(|| VolumeFault::damaged(message))
    };
    let number = number(need("type")?)?;
    let sizes = text::counts("sizes", need("sizes")?)?;
    let dimension = text::counts("dimension", need("dimension")?)?;
    if dimension != [sizes.len() as u64] {
        let message = format!("dimension {dimension:?}, but {} sizes", sizes.len());
        return Err(VolumeFault::damaged(message));
    }
    let axes = Axes::read(&sizes, &fields)?;
    let encoding = need("encoding")?.to_ascii_lowercase();
    let is_text = matches!(&*encoding, "txt" | "text" | "ascii");
    let is_big = match field("endian").map(str::to_ascii_lowercase).as_deref() {
        Some("big") => true,
        Some("little") => false,
        None if number.bytes() == 1 || is_text => false,
        _ => {
            return Err(VolumeFault::new(
                "the header does not say the endian",
                "add `endian: little` or `big`",
            ));
        }
    };
    let number = if is_text { Number::F64 } else { number };
    let layout = Layout::new(number, is_big && !is_text, &axes.axes)?;
    let own = file.bytes.get(start..).unwrap_or_default();
    let beside = field("data file").map(|name| {
        let is_many = name.starts_with("LIST") || name.contains('%');
        let many = || VolumeFault::new("its data are in several files", "write them into one file");
        (!is_many).then(|| bytes_beside(file.path, name)).ok_or_else(many)?
    });
    let mut data = beside.transpose()?.unwrap_or_else(|| own.to_vec());
    let skip = |key: &str| text::numbers(key, field(key).unwrap_or("0"));
    for _ in 0..skip("line skip")?.first().map_or(0, |&lines| lines.clamp(0.0, 1e6) as usize) {
        let Some((_, next)) = text::line(&data, 0) else { break };
        data.drain(..next);
    }
    let skip = skip("byte skip")?.first().copied().unwrap_or(0.0);
    let need = layout.bytes();
    let is_raw = encoding == "raw";
    if is_raw && skip == -1.0 {
        data.drain(..data.len().saturating_sub(need));
    }
    let skipped = skip.max(0.0) as usize;
    let data = match &*encoding {
        "raw" => {
            data.drain(..skipped.min(data.len()));
            data
        }
        "gz" | "gzip" => {
            let mut unpacked = unpacked(Packing::Gzip, &data, need.saturating_add(skipped))?;
            unpacked.drain(..skipped.min(unpacked.len()));
            unpacked
        }
        _ if is_text => text::doubles(&data, need / number.bytes())?,
        other => {
            let message = format!("its encoding is {}", quoted(other));
            return Err(VolumeFault::new(message, "write it as raw, gzip or ascii"));
        }
    };
    Dense::new(data, layout, axes.place)
}

fn number(name: &str) -> Result<Number, VolumeFault> {
    Ok(match name {
        "signed char" | "int8" | "int8_t" => Number::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Number::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => {
            Number::I16
        }
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Number::U16,
        "int" | "signed int" | "int32" | "int32_t" => Number::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Number::U32,
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => Number::I64,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => {
            Number::U64
        }
        "float" => Number::F32,
        "double" => Number::F64,
        other => {
            let message = format!("its numbers are of the type {}", quoted(other));
            return Err(VolumeFault::new(message, "write whole numbers, floats or doubles"));
        }
    })
}

/// The axes of an array, and its place.
struct Axes {
    /// Lengths and meanings, the fastest first.
    axes: Vec<(u64, Axis)>,
    place: Place,
}

impl Axes {
    fn read(sizes: &[u64], fields: &HashMap<String, &str>) -> Result<Self, VolumeFault> {
        let kinds: Vec<_> = fields.get("kinds").map_or(Vec::new(), |kinds| {
            kinds.split_ascii_whitespace().map(str::to_ascii_lowercase).collect()
        });
        let directions = fields.get("space directions").map(|text| vectors(text)).transpose()?;
        let spacings = match fields.get("spacings") {
            Some(text) => text::numbers("spacings", text)?,
            None => Vec::new(),
        };
        let is_color = |i: usize| {
            let is_named = kinds.get(i).is_some_and(|kind| {
                matches!(&**kind, "rgb-color" | "rgba-color" | "3-color" | "4-color" | "3-vector")
            });
            let is_elsewhere = directions.as_ref().is_some_and(|all| all.get(i) == Some(&None));
            is_named || is_elsewhere && matches!(sizes[i], 3 | 4)
        };
        let (mut axes, mut columns) = (Vec::new(), Vec::new());
        for (i, &length) in sizes.iter().enumerate() {
            let axis = match columns.len() {
                _ if is_color(i) => Axis::Channel,
                have @ 0..3 => {
                    let spacing = spacings.get(i).copied().filter(|spacing| spacing.is_finite());
                    let along = DVec3::AXES[have] * spacing.unwrap_or(1.0);
                    let given = directions.as_ref().and_then(|all| all.get(i).copied().flatten());
                    columns.push(given.unwrap_or(along));
                    Axis::SPACE[have]
                }
                _ => Axis::Other,
            };
            axes.push((length, axis));
        }
        while columns.len() < 3 {
            columns.push(DVec3::AXES[columns.len()]);
        }
        let origin = match fields.get("space origin") {
            Some(text) => vectors(text)?.first().copied().flatten().unwrap_or(DVec3::ZERO),
            None => DVec3::ZERO,
        };
        let mut place = Place::new([columns[0], columns[1], columns[2]], origin);
        let space = fields.get("space").map(|space| space.to_ascii_lowercase());
        place.body = match space.as_deref().map(|space| space.trim_end_matches("-time")) {
            Some("left-posterior-superior" | "lps" | "lpst") => Some(BodyAxes::LeftBack),
            Some("right-anterior-superior" | "ras" | "rast") => Some(BodyAxes::RightFront),
            Some("left-anterior-superior" | "las" | "last") => Some(BodyAxes::LeftFront),
            _ => None,
        };
        let units = fields.get("space units").or(fields.get("units"));
        place.unit = units.and_then(|units| {
            let mut words = units.split('"').filter(|word| !word.trim().is_empty());
            words.next().and_then(unit_named)
        });
        // Anatomical spaces are in millimetres, as all programs write them.
        place.unit = place.unit.or(place.body.map(|_| 1e-3));
        Ok(Self { axes, place })
    }
}

/// Vectors such as `(1,0,0) none (0,0,2)`.
fn vectors(text: &str) -> Result<Vec<Option<DVec3>>, VolumeFault> {
    let (mut vectors, mut rest) = (Vec::new(), text.trim_start());
    while !rest.is_empty() {
        if let Some(after) = rest.strip_prefix("none") {
            vectors.push(None);
            rest = after.trim_start();
            continue;
        }
        let inner = rest.strip_prefix('(').and_then(|rest| rest.split_once(')'));
        let Some((inner, after)) = inner else {
            return Err(VolumeFault::damaged(format!("{} is no vector", quoted(rest))));
        };
        let numbers = text::numbers("a vector", &inner.replace(',', " "))?;
        if numbers.len() > 3 {
            return Err(VolumeFault::new(
                "a space of more than three dimensions",
                "write one of three",
            ));
        }
        vectors.push(Some(text::three(&numbers, 0.0)));
        rest = after.trim_start();
    }
    Ok(vectors)
}
