//! The header of a PLY file (Turk 1994).
use super::error::{Fault, quoted};
use std::collections::HashSet;

/// Encoding of the numbers in the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlyEncoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    /// Size of a number \[bytes\].
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(super) fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    fn parse(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PropertyKind {
    One(Scalar),
    /// A list: its length, then its items.
    List {
        length: Scalar,
        item: Scalar,
    },
}

impl PropertyKind {
    /// Least size of the value in a row \[bytes\].
    pub(super) fn least_size(self) -> usize {
        match self {
            Self::One(scalar) | Self::List { length: scalar, .. } => scalar.size(),
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: PropertyKind,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) name: String,
    /// Number of rows.
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
}

#[derive(Clone, Debug)]
pub(super) struct PlyHeader {
    pub(super) encoding: PlyEncoding,
    pub(super) elements: Vec<Element>,
    pub(super) lines: usize,
    /// Offset of the body \[bytes\].
    pub(super) length: usize,
}

const WRITE_AGAIN: &str = "write a PLY 1.0 header, from `ply` to `end_header`";

pub(super) fn parse(bytes: &[u8]) -> Result<PlyHeader, Fault> {
    let mut lines = Lines::new(bytes);
    if lines.next() != Some("ply") {
        return Err((at(1, "this is no PLY file: it does not start with `ply`"), WRITE_AGAIN));
    }
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let (mut element_names, mut names) = (HashSet::new(), HashSet::new());
    loop {
        let Some(line) = lines.next() else {
            return Err(("the PLY header has no `end_header`".to_owned(), WRITE_AGAIN));
        };
        let fault = |problem: String, help| Err((at(lines.count, &problem), help));
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words[..] {
            [] | ["comment" | "obj_info", ..] => {}
            ["end_header"] => break,
            ["format", name, version] => {
                encoding = Some(match name {
                    "ascii" => PlyEncoding::Ascii,
                    "binary_little_endian" => PlyEncoding::LittleEndian,
                    "binary_big_endian" => PlyEncoding::BigEndian,
                    _ => {
                        let help = "formats are ascii, binary_little_endian and binary_big_endian";
                        return fault(format!("no known format: {}", quoted(name)), help);
                    }
                });
                if version != "1.0" {
                    let problem = format!("PLY version {}", quoted(version));
                    return fault(problem, "gobo reads PLY 1.0");
                }
            }
            ["element", name, count] => {
                let Ok(count) = count.parse() else {
                    let problem = format!("{} is no number of rows", quoted(count));
                    return fault(problem, "write `element NAME COUNT`");
                };
                if !element_names.insert(name) {
                    let problem = format!("a second element named {}", quoted(name));
                    return fault(problem, "rename or remove one of them");
                }
                names.clear();
                elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
            }
            ["property", ref kind @ .., name] => {
                let Some(element) = elements.last_mut() else {
                    return fault("a property before any element".to_owned(), WRITE_AGAIN);
                };
                let Some(kind) = parse_kind(kind) else {
                    let problem = format!("no known type of property: {}", quoted(line));
                    let help = "types are char, uchar, short, ushort, int, uint, float, double, and \
                                `list LENGTH ITEM` with a whole number for the length";
                    return fault(problem, help);
                };
                if !names.insert(name) {
                    let problem = format!("a second property named {}", quoted(name));
                    return fault(problem, "rename or remove one of them");
                }
                element.properties.push(Property { name: name.to_owned(), kind });
            }
            _ => return fault(format!("no known line: {}", quoted(line)), WRITE_AGAIN),
        }
    }
    let Some(encoding) = encoding else {
        return Err(("the PLY header has no `format`".to_owned(), WRITE_AGAIN));
    };
    Ok(PlyHeader { encoding, elements, lines: lines.count, length: lines.start })
}

fn at(line: usize, problem: &str) -> String {
    format!("line {line} of the PLY header: {problem}")
}

fn parse_kind(words: &[&str]) -> Option<PropertyKind> {
    match *words {
        [one] => Scalar::parse(one).map(PropertyKind::One),
        ["list", length, item] => {
            let length = Scalar::parse(length).filter(|length| length.is_whole())?;
            Some(PropertyKind::List { length, item: Scalar::parse(item)? })
        }
        _ => None,
    }
}

/// Lines with the same ending as the first one: a body may start with any byte.
struct Lines<'a> {
    bytes: &'a [u8],
    end: &'static [u8],
    /// Start of the next line \[bytes\].
    start: usize,
    count: usize,
}

impl<'a> Lines<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let end: &[u8] = match bytes.get(3..5) {
            Some([b'\r', b'\n']) => b"\r\n",
            Some([b'\r', _]) => b"\r",
            _ => b"\n",
        };
        Self { bytes, end, start: 0, count: 0 }
    }

    /// The next line; `None` without a further line ending. A line that is not UTF-8 is unknown.
    fn next(&mut self) -> Option<&'a str> {
        let rest = &self.bytes[self.start..];
        let length = rest.windows(self.end.len()).position(|window| window == self.end)?;
        self.start += length + self.end.len();
        self.count += 1;
        let line = &rest[..length];
        // A comment may be in an older encoding.
        let text = if line.starts_with(b"comment") { "comment" } else { "?" };
        Some(str::from_utf8(line).unwrap_or(text).trim_end())
    }
}
