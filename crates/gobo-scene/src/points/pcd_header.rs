//! The header of a PCD file 0.7 (Point Cloud Library).
use super::{DAMAGED, Fault};
use crate::error::quoted;

/// Longest header \[bytes\].
pub(super) const LONGEST: u64 = 1 << 16;

const WRITE_AGAIN: &str = "write a PCD 0.7 header, from VERSION to DATA";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PcdEncoding {
    Ascii,
    Binary,
    Packed,
}

/// A column of numbers.
#[derive(Clone, Debug)]
pub(super) struct PcdField {
    pub(super) name: String,
    /// Size of a number \[bytes\]: 1, 2, 4 or 8.
    pub(super) size: usize,
    /// `I`, `U` or `F`.
    pub(super) kind: u8,
    /// Numbers per point.
    pub(super) count: usize,
}

impl PcdField {
    /// Size in a point \[bytes\].
    pub(super) fn length(&self) -> usize {
        self.size * self.count
    }
}

#[derive(Debug)]
pub(super) struct PcdHeader {
    pub(super) fields: Vec<PcdField>,
    pub(super) points: u64,
    pub(super) encoding: PcdEncoding,
    /// Whether the sensor is not at the origin.
    pub(super) has_viewpoint: bool,
    pub(super) lines: usize,
    /// Offset of the data \[bytes\].
    pub(super) length: usize,
}

impl PcdHeader {
    /// Size of a point \[bytes\].
    pub(super) fn row(&self) -> usize {
        self.fields.iter().map(PcdField::length).sum()
    }
}

/// Whether bytes begin a PCD file: its version or its columns follow the comments.
pub(super) fn is_pcd(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(&start[..start.len().min(4096)]);
    if text.starts_with("# .PCD") {
        return true;
    }
    let mut lines = text.lines().map(str::trim).filter(|line| !line.starts_with('#'));
    lines.next().is_some_and(|line| line.starts_with("VERSION ") || line.starts_with("VERSION\t"))
}

pub(super) fn parse(bytes: &[u8]) -> Result<PcdHeader, Fault> {
    let mut start = 0;
    let mut lines = 0;
    let (mut names, mut sizes, mut kinds, mut counts) = <[Vec<String>; 4]>::default().into();
    let (mut width, mut height, mut points) = (None, 1, None);
    let mut has_viewpoint = false;
    let encoding = loop {
        let rest = &bytes[start..bytes.len().min(LONGEST as usize)];
        let Some(end) = rest.iter().position(|&byte| byte == b'\n') else {
            return Err(("the PCD header has no DATA".to_owned(), WRITE_AGAIN));
        };
        (start, lines) = (start + end + 1, lines + 1);
        let line = String::from_utf8_lossy(&rest[..end]);
        let mut words = line.split_whitespace().map(str::to_owned);
        let Some(key) = words.next() else { continue };
        let fault = |problem: &str| {
            Err((format!("line {lines} of the PCD header: {problem}"), WRITE_AGAIN))
        };
        let words: Vec<String> = words.collect();
        let whole = || words.first().and_then(|word| word.parse::<u64>().ok());
        match key.as_str() {
            _ if key.starts_with('#') => {}
            "VERSION" => {}
            // Files of version 0.5 call them columns.
            "FIELDS" | "COLUMNS" => names = words,
            "SIZE" => sizes = words,
            "TYPE" => kinds = words,
            "COUNT" => counts = words,
            "WIDTH" => width = whole(),
            "HEIGHT" => height = whole().unwrap_or(0),
            "POINTS" => points = whole(),
            "VIEWPOINT" => {
                let pose = ["0", "0", "0", "1", "0", "0", "0"];
                let number = |word: &str| word.parse::<f64>().unwrap_or(f64::NAN);
                has_viewpoint = words.iter().zip(pose).any(|(a, b)| number(a) != number(b));
            }
            "DATA" => match words.first().map(String::as_str) {
                Some("ascii") => break PcdEncoding::Ascii,
                Some("binary") => break PcdEncoding::Binary,
                Some("binary_compressed") => break PcdEncoding::Packed,
                other => return fault(&format!("DATA {}", quoted(other.unwrap_or_default()))),
            },
            other => return fault(&format!("no known line: {}", quoted(other))),
        }
    };
    let fields = fields(&names, &sizes, &kinds, &counts)?;
    let all = width.and_then(|width| height.checked_mul(width));
    let Some(points) = points.or(all).filter(|points| all.is_none_or(|all| all == *points)) else {
        let message = "POINTS of the PCD header is not WIDTH times HEIGHT".to_owned();
        return Err((message, DAMAGED));
    };
    Ok(PcdHeader { fields, points, encoding, has_viewpoint, lines, length: start })
}

fn fields(
    names: &[String],
    sizes: &[String],
    kinds: &[String],
    counts: &[String],
) -> Result<Vec<PcdField>, Fault> {
    let bad = |problem: String| (format!("the PCD header: {problem}"), WRITE_AGAIN);
    if names.is_empty() || names.len() > 256 {
        return Err(bad(format!("{} FIELDS", names.len())));
    }
    let column = |i: usize, name: &String| {
        let size = sizes.get(i).map_or("4", String::as_str);
        let kind = kinds.get(i).map_or("F", String::as_str);
        let count = counts.get(i).map_or("1", String::as_str);
        let number = |word: &str, most: usize| word.parse().ok().filter(|n| *n <= most);
        let size = number(size, 8).filter(|size| [1, 2, 4, 8].contains(size));
        let (Some(size), Some(count)) = (size, number(count, 1 << 16)) else {
            return Err(bad(format!("the size of {} is wrong", quoted(name))));
        };
        let kind = match kind {
            "I" => b'I',
            "U" => b'U',
            "F" if size >= 4 => b'F',
            other => return Err(bad(format!("{} of type {}", quoted(name), quoted(other)))),
        };
        Ok(PcdField { name: name.clone(), size, kind, count })
    };
    names.iter().enumerate().map(|(i, name)| column(i, name)).collect()
}
