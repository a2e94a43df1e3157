//! `MetaImage` of ITK, with its data inside or in another file:
//! <https://itk.org/Wiki/ITK/MetaIO/Documentation>.
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

/// Keys: each file has one of them in its first lines.
const FIRST: [&str; 3] = ["ObjectType", "NDims", "ObjectSubType"];

pub(super) fn is(head: &[u8]) -> bool {
    let Some((line, _)) = text::line(head, 0) else { return false };
    line.split_once('=').is_some_and(|(key, _)| FIRST.contains(&key.trim()))
}

pub(super) fn named(head: &[u8], path: &Path) -> Option<PathBuf> {
    let (keys, _) = keys(head);
    let name = keys.get("ElementDataFile").filter(|name| **name != LOCAL)?;
    beside(path, name).ok()
}

/// Name that means that the data follow the header.
const LOCAL: &str = "LOCAL";

/// Values by key, and the offset of the data.
fn keys(bytes: &[u8]) -> (HashMap<&str, &str>, usize) {
    let (mut keys, mut at) = (HashMap::new(), 0);
    while let Some((line, next)) = text::line(bytes, at) {
        at = next;
        if let Some((key, value)) = line.split_once('=') {
            keys.insert(key.trim(), value.trim());
            // This key ends each header.
            if key.trim() == "ElementDataFile" {
                break;
            }
        }
    }
    (keys, at)
}

pub(super) fn read(file: &mut DenseFile<'_>) -> Result<Dense, VolumeFault> {
    file.has_one_array()?;
    let (keys, start) = keys(&file.bytes);
    let key = |name: &str| keys.get(name).copied();
    let need = |name: &str| {
        key(name).ok_or_else(|| VolumeFault::damaged(format!("the header has no key `{name}`")))
    };
    let is_true = |name: &str| key(name).is_some_and(|value| value.eq_ignore_ascii_case("true"));
    let number = number(need("ElementType")?)?;
    let sizes = text::counts("DimSize", need("DimSize")?)?;
    let channels =
        text::counts("ElementNumberOfChannels", key("ElementNumberOfChannels").unwrap_or("1"))?;
    let mut axes = vec![(channels.first().copied().unwrap_or(1), Axis::Channel)];
    let space = Axis::SPACE.into_iter().chain(std::iter::repeat(Axis::Other));
    axes.extend(sizes.iter().copied().zip(space));
    let is_text = key("BinaryData").is_some_and(|value| value.eq_ignore_ascii_case("false"));
    let is_big = is_true("BinaryDataByteOrderMSB") || is_true("ElementByteOrderMSB");
    let number = if is_text { Number::F64 } else { number };
    let layout = Layout::new(number, is_big && !is_text, &axes)?;
    let need = layout.bytes();
    let mut data = match data_file(data_name(&keys)?)? {
        None => file.bytes.get(start..).unwrap_or_default().to_vec(),
        Some(name) => bytes_beside(file.path, name)?,
    };
    let is_packed = is_true("CompressedData");
    let skip = text::numbers("HeaderSize", key("HeaderSize").unwrap_or("0"))?;
    match skip.first() {
        Some(&-1.0) if !is_packed => drop(data.drain(..data.len().saturating_sub(need))),
        Some(&skip) if skip > 0.0 => drop(data.drain(..(skip as usize).min(data.len()))),
        _ => {}
    }
    let data = match (is_text, is_packed) {
        (true, _) => text::doubles(&data, need / number.bytes())?,
        (_, true) => unpacked(Packing::Zlib, &data, need)?,
        _ => data,
    };
    Dense::new(data, layout, place(&keys, sizes.len())?)
}

fn data_name<'a>(keys: &HashMap<&str, &'a str>) -> Result<&'a str, VolumeFault> {
    let missing = || VolumeFault::damaged("the header has no key `ElementDataFile`");
    keys.get("ElementDataFile").copied().ok_or_else(missing)
}

/// The name of the data's file; `None` if they follow the header.
fn data_file(name: &str) -> Result<Option<&str>, VolumeFault> {
    if name.starts_with("LIST") || name.contains('%') {
        return Err(VolumeFault::new("its data are in several files", "write them into one file"));
    }
    Ok((!name.eq_ignore_ascii_case(LOCAL)).then_some(name))
}

fn number(name: &str) -> Result<Number, VolumeFault> {
    let name = name.strip_suffix("_ARRAY").unwrap_or(name);
    Ok(match name {
        "MET_CHAR" => Number::I8,
        "MET_UCHAR" => Number::U8,
        "MET_SHORT" => Number::I16,
        "MET_USHORT" => Number::U16,
        "MET_INT" | "MET_LONG" => Number::I32,
        "MET_UINT" | "MET_ULONG" => Number::U32,
        "MET_LONG_LONG" => Number::I64,
        "MET_ULONG_LONG" => Number::U64,
        "MET_FLOAT" => Number::F32,
        "MET_DOUBLE" => Number::F64,
        other => {
            let message = format!("its numbers are of the type {}", quoted(other));
            return Err(VolumeFault::new(message, "write whole numbers, floats or doubles"));
        }
    })
}

/// `ITK` stores the direction of each axis in a row of the matrix.
fn place(keys: &HashMap<&str, &str>, dimension: usize) -> Result<Place, VolumeFault> {
    let numbers = |names: &[&'static str]| {
        let found = names.iter().find_map(|&name| Some((name, *keys.get(name)?)));
        found.map_or(Ok(Vec::new()), |(name, text)| text::numbers(name, text))
    };
    let spacing = text::three(&numbers(&["ElementSpacing", "ElementSize"])?, 1.0);
    let origin = text::three(&numbers(&["Offset", "Position", "Origin"])?, 0.0);
    let matrix = numbers(&["TransformMatrix", "Rotation", "Orientation"])?;
    let axes = std::array::from_fn(|i| {
        let row = matrix.get(i * dimension..(i + 1) * dimension).filter(|_| i < dimension);
        row.map_or(DVec3::AXES[i], |row| text::three(row, 0.0)) * spacing[i]
    });
    let mut place = Place::new(axes, origin);
    let is_body = keys.get("AnatomicalOrientation").is_some_and(|value| !value.contains('?'));
    place.body = is_body.then_some(BodyAxes::LeftBack);
    let unit = keys.get("DistanceUnits").and_then(|name| unit_named(name));
    place.unit = unit.or(is_body.then_some(1e-3));
    Ok(place)
}
