//! Maps and pictures beside those of another device.
use crate::Failure;
use serde_json::{Value, json};
use std::{
    fs,
    io::Cursor,
    path::{Path, PathBuf},
};

/// Most that light and the opacity of pixels may differ: a step of a half, and compilers that contract.
const LIGHT: f64 = 2e-3;
/// Most that a light depth may differ.
const DEPTH: f64 = 1e-5;
/// Most that a channel of a picture may differ, of 255.
const CHANNEL: f64 = 4.0;
/// Share of values that may differ by more: texels whose centre is on an edge, nodes of a curve that end elsewhere.
const SHARE: f64 = 1e-3;

/// Values of a file, and how much they may differ.
struct Values {
    shape: Vec<usize>,
    values: Vec<f64>,
    tolerance: f64,
}

/// Compares each `.npy` and `.png` below `expected` with the file of that name below `found`; false where one is missing or
/// differs.
pub fn run(expected: &Path, found: &Path, out: &Path) -> Result<bool, Failure> {
    let mut files = Vec::new();
    list(expected, &mut files)?;
    files.sort();
    let mut rows = Vec::new();
    for path in &files {
        let name = path.strip_prefix(expected)?;
        let (ours, theirs) = (read(path)?, read(&found.join(name)));
        let row = match theirs {
            Ok(theirs) if theirs.shape == ours.shape => differences(&ours, &theirs),
            Ok(theirs) => {
                json!({ "good": false, "wrong": format!("{:?} for {:?}", theirs.shape, ours.shape) })
            }
            Err(error) => json!({ "good": false, "wrong": error.to_string() }),
        };
        println!("{}: {row}", name.display());
        rows.push(json!({ "file": name.to_string_lossy(), "beside": row }));
    }
    if rows.is_empty() {
        return Err(format!("{}: no maps and no pictures", expected.display()).into());
    }
    let good = rows.iter().all(|row| row["beside"]["good"] == Value::Bool(true));
    fs::write(out, serde_json::to_string_pretty(&json!({ "good": good, "files": rows }))?)?;
    Ok(good)
}

fn list(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), Failure> {
    for entry in fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))? {
        let path = entry?.path();
        if path.is_dir() {
            list(&path, files)?;
        } else if path.extension().is_some_and(|end| end == "npy" || end == "png") {
            files.push(path);
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<Values, Failure> {
    let at = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let bytes = fs::read(path).map_err(|error| at(&error))?;
    let is_picture = path.extension().is_some_and(|end| end == "png");
    let values = if is_picture { picture(bytes) } else { array(&bytes, is_depth(path)) };
    Ok(values.map_err(|error| at(&error))?)
}

fn is_depth(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.ends_with(".nearest.npy") || name.ends_with(".opaque.npy")
}

fn picture(bytes: Vec<u8>) -> Result<Values, Failure> {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info()?;
    let mut pixels = vec![0; reader.output_buffer_size().ok_or("too large")?];
    let frame = reader.next_frame(&mut pixels)?;
    let values: Vec<f64> =
        pixels[..frame.buffer_size()].iter().map(|&byte| f64::from(byte)).collect();
    let (width, height) = (frame.width as usize, frame.height as usize);
    let shape = vec![height, width, values.len() / (width * height)];
    Ok(Values { shape, values, tolerance: CHANNEL })
}

/// An array of 32-bit numbers as `gobo render --maps` writes it.
fn array(bytes: &[u8], is_depth: bool) -> Result<Values, Failure> {
    let wrong = || Failure::from("is no array of 32-bit numbers in format 1.0 of NPY");
    let length = match bytes {
        [0x93, b'N', b'U', b'M', b'P', b'Y', 1, 0, low, high, ..] => {
            u16::from_le_bytes([*low, *high])
        }
        _ => return Err(wrong()),
    };
    let end = 10 + usize::from(length);
    let header = std::str::from_utf8(bytes.get(10..end).ok_or_else(wrong)?)?;
    if !header.contains("'<f4'") || header.contains("'fortran_order': True") {
        return Err(wrong());
    }
    let (_, shape) = header.split_once('(').ok_or_else(wrong)?;
    let (shape, _) = shape.split_once(')').ok_or_else(wrong)?;
    let numbers = shape.split(',').map(str::trim).filter(|number| !number.is_empty());
    let shape = numbers.map(str::parse).collect::<Result<Vec<usize>, _>>()?;
    let (floats, rest) = bytes[end..].as_chunks::<4>();
    if !rest.is_empty() || floats.len() != shape.iter().product::<usize>() {
        return Err("has not as many values as its shape".into());
    }
    let values = floats.iter().map(|&bytes| f64::from(f32::from_le_bytes(bytes))).collect();
    Ok(Values { shape, values, tolerance: if is_depth { DEPTH } else { LIGHT } })
}

fn differences(ours: &Values, theirs: &Values) -> Value {
    let (mut beyond, mut worst) = (0_usize, 0.0_f64);
    for (a, b) in ours.values.iter().zip(&theirs.values) {
        let difference = if a == b { 0.0 } else { (a - b).abs() };
        worst = if difference.is_nan() { f64::INFINITY } else { worst.max(difference) };
        // NaN is beyond, too.
        beyond += usize::from(!(difference <= ours.tolerance));
    }
    let share = beyond as f64 / ours.values.len().max(1) as f64;
    json!({
        "good": share <= SHARE,
        "values": ours.values.len(),
        "beyond": beyond,
        "tolerance": ours.tolerance,
        "worst": if worst.is_finite() { json!(worst) } else { json!("not a number") },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn npy(header: &str, values: &[f32]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.bytes());
        bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        bytes
    }

    #[test]
    fn a_few_values_may_differ() {
        let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2000, 1), }";
        let of = |count: usize, value: f32| {
            let mut values = vec![0.5; 2000];
            values[..count].fill(value);
            array(&npy(header, &values), false).unwrap()
        };
        let same = of(0, 0.0);
        for (count, value, good, beyond) in [
            (2, 0.6, true, 2),
            (3, 0.6, false, 3),
            (2000, 0.5015, true, 0),
            (3, f32::NAN, false, 3),
        ] {
            let row = differences(&same, &of(count, value));
            assert_eq!(row["good"], json!(good), "{count} x {value}");
            assert_eq!(row["beyond"], json!(beyond), "{count} x {value}");
        }
    }

    #[test]
    fn a_short_array_and_another_type_are_refused() {
        let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (3,), }";
        assert!(array(&npy(header, &[1.0; 2]), false).is_err());
        assert!(array(&npy(&header.replace("<f4", "<f8"), &[1.0; 3]), false).is_err());
        assert_eq!(array(&npy(header, &[1.0; 3]), true).unwrap().tolerance, DEPTH);
    }
}
