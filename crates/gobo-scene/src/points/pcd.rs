//! PCD 0.7 (Point Cloud Library): rows of numbers as text or binary, or columns compressed by LZF.
use super::{
    DAMAGED, Fault, Point, Points, Room, linear, lzf,
    pcd_header::{self, PcdEncoding, PcdField, PcdHeader},
    unread,
};
use crate::error::quoted;
use glam::DVec3;

/// Columns that are read.
const NAMES: [&str; 8] = ["x", "y", "z", "rgb", "rgba", "intensity", "label", "classification"];
const COLOR: [usize; 2] = [3, 4];
const INTENSITY: usize = 5;

/// The columns that are read: each one's field, and its offset in a row \[bytes\].
struct PointColumns<'a> {
    of_names: [Option<(&'a PcdField, usize)>; NAMES.len()],
}

impl<'a> PointColumns<'a> {
    fn new(header: &'a PcdHeader) -> Result<Self, Fault> {
        let mut of_names = [None; NAMES.len()];
        let mut offset = 0;
        for field in &header.fields {
            if let Some(i) = NAMES.iter().position(|name| *name == field.name)
                && field.count == 1
            {
                of_names[i] = Some((field, offset));
            }
            offset += field.length();
        }
        if let Some(i) = (0..3).find(|i| of_names[*i].is_none()) {
            let message = format!("has no column {}", quoted(NAMES[i]));
            return Err((message, "points need x, y and z"));
        }
        Ok(Self { of_names })
    }

    /// The point of a row; `number`: the value of a field at an offset, and its bits.
    fn point<E>(
        &self,
        number: impl Fn(&PcdField, usize) -> Result<(f64, u64), E>,
    ) -> Result<Point, E> {
        let value =
            |i: usize| self.of_names[i].map(|(field, offset)| number(field, offset)).transpose();
        let part = |i: usize| Ok(value(i)?.map_or(0.0, |(value, _)| value));
        let color = match (value(COLOR[0])?, value(COLOR[1])?) {
            (Some((_, bits)), _) | (None, Some((_, bits))) => {
                Some(linear([16, 8, 0].map(|shift| (bits >> shift & 255) as f32 / 255.0)))
            }
            _ => None,
        };
        let intensity = value(INTENSITY)?.map(|(value, _)| value as f32);
        let position = DVec3::new(part(0)?, part(1)?, part(2)?);
        let intensity = intensity.map(|value| if value.is_finite() { value } else { 0.0 });
        Ok(Point { position, color, intensity, class: None })
    }
}

/// Number of points that a header announces; `None` if the file is too short for them.
pub(super) fn announced(head: &[u8], length: u64) -> Option<u64> {
    let header = pcd_header::parse(head).ok()?;
    (header.points <= most_points(&header, length)).then_some(header.points)
}

/// Upper bound of the points in a file of `length` bytes.
fn most_points(header: &PcdHeader, length: u64) -> u64 {
    let bytes = length.saturating_sub(header.length as u64);
    let row = header.row().max(1) as u64;
    match header.encoding {
        // A digit and a blank for each number.
        PcdEncoding::Ascii => (bytes + 1) / (2 * header.fields.len().max(1) as u64),
        PcdEncoding::Binary => bytes / row,
        PcdEncoding::Packed => bytes.saturating_mul(lzf::MOST) / row,
    }
}

/// Columns and encoding of a file.
pub(super) fn facts(head: &[u8]) -> Vec<(&'static str, String)> {
    let Ok(header) = pcd_header::parse(head) else { return Vec::new() };
    let names: Vec<String> = header.fields.iter().take(24).map(|f| quoted(&f.name)).collect();
    vec![
        ("points", header.points.to_string()),
        ("columns", names.join(" ")),
        ("encoding", format!("{:?}", header.encoding)),
    ]
}

pub(super) fn read(bytes: &[u8], room: Room) -> Result<Points, Fault> {
    let header = pcd_header::parse(bytes)?;
    let columns = PointColumns::new(&header)?;
    let (count, fits) = (header.points, most_points(&header, bytes.len() as u64));
    if count > fits {
        let message = format!(
            "the header promises {count} points, but the file is long enough for {fits} at most"
        );
        return Err((message, DAMAGED));
    }
    room.check(count)?;
    let mut points = Points::default();
    points.reserve(count as usize)?;
    let data = &bytes[header.length..];
    match header.encoding {
        PcdEncoding::Ascii => ascii(&header, &columns, data, &mut points)?,
        PcdEncoding::Binary => {
            let row = header.row();
            for row in data.chunks_exact(row).take(count as usize) {
                points.push(infallible(columns.point(|field, at| Ok(binary(field, &row[at..])))));
            }
        }
        PcdEncoding::Packed => packed(&header, &columns, data, &mut points)?,
    }
    let known = |field: &&PcdField| {
        !NAMES[..=INTENSITY].contains(&field.name.as_str()) && field.name != "_"
    };
    let names: Vec<&str> = header.fields.iter().filter(known).map(|f| f.name.as_str()).collect();
    points.notes.extend(unread(&names));
    if header.has_viewpoint {
        points.notes.push("its VIEWPOINT is not applied".to_owned());
    }
    Ok(points)
}

fn infallible(point: Result<Point, std::convert::Infallible>) -> Point {
    point.unwrap_or_default()
}

/// A little-endian number, and its bits.
fn binary(field: &PcdField, bytes: &[u8]) -> (f64, u64) {
    let bits = bytes[..field.size].iter().rev().fold(0, |bits, byte| bits << 8 | u64::from(*byte));
    let value = match (field.kind, field.size) {
        (b'F', 4) => f32::from_bits(bits as u32).into(),
        (b'F', _) => f64::from_bits(bits),
        (b'I', size) => {
            let unused = 64 - 8 * size as u32;
            ((bits << unused) as i64 >> unused) as f64
        }
        _ => bits as f64,
    };
    (value, bits)
}

fn ascii(
    header: &PcdHeader,
    columns: &PointColumns<'_>,
    data: &[u8],
    points: &mut Points,
) -> Result<(), Fault> {
    let mut words: Vec<&str> = Vec::new();
    let mut count = 0;
    for (i, line) in data.split(|&byte| byte == b'\n').enumerate() {
        if line.trim_ascii().is_empty() || count == header.points {
            continue;
        }
        count += 1;
        let at = header.lines + i + 1;
        let fault = |problem: String| (format!("line {at}: {problem}"), DAMAGED);
        let line = str::from_utf8(line).map_err(|_| fault("the text is not UTF-8".to_owned()))?;
        words.clear();
        words.extend(line.split_ascii_whitespace());
        let expected: usize = header.fields.iter().map(|field| field.count).sum();
        if words.len() != expected {
            return Err(fault(format!("{} numbers, not {expected}", words.len())));
        }
        let number = |field: &PcdField, _: usize| {
            let before = header.fields.iter().take_while(|other| other.name != field.name);
            let word = words[before.map(|field| field.count).sum::<usize>()];
            let value: f64 =
                word.parse().map_err(|_| format!("{} is not a number", quoted(word)))?;
            // Bytes of colours are written as the bits of a float or an integer.
            let bits = match field.kind {
                b'F' => u64::from((value as f32).to_bits()),
                _ => value as i64 as u64,
            };
            Ok((value, bits))
        };
        points.push(columns.point(number).map_err(fault)?);
    }
    if count < header.points {
        let message = format!("the file ends in point {} of {}", count + 1, header.points);
        return Err((message, DAMAGED));
    }
    Ok(())
}

/// Columns one after the other, compressed by LZF.
fn packed(
    header: &PcdHeader,
    columns: &PointColumns<'_>,
    data: &[u8],
    points: &mut Points,
) -> Result<(), Fault> {
    let ends = || ("the file ends in its compressed points".to_owned(), DAMAGED);
    let (sizes, rest) = data.split_at_checked(8).ok_or_else(ends)?;
    let size = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|i| sizes[at + i])) as usize;
    let stream = rest.get(..size(0)).ok_or_else(ends)?;
    let count = header.points as usize;
    let length = header.row().saturating_mul(count);
    if size(4) != length || length as u64 > stream.len() as u64 * lzf::MOST {
        let message = format!("its compressed points have {} bytes, not {length}", size(4));
        return Err((message, DAMAGED));
    }
    let damaged = || ("its compressed points cannot be read".to_owned(), DAMAGED);
    let plain = lzf::unpacked(stream, length).ok_or_else(damaged)?;
    for i in 0..count {
        // After all rows of the columns before.
        let number = |field: &PcdField, offset: usize| {
            Ok(binary(field, &plain[offset * count + i * field.size..]))
        };
        points.push(infallible(columns.point(number)));
    }
    Ok(())
}
