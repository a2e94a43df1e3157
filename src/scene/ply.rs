//! PLY: the header by `ply-rs-bw`, the rows here, because that crate's ascii grammar knows neither
//! `nan` nor `.5`, and lists and foreign elements need skipping only.
use super::{
    SceneError,
    particles::{BLANK, NAMES, Rows, Storage},
};
use ply_rs_bw::{
    parser::{Parser, Reader},
    ply::{DefaultElement, ElementDef, Encoding, PropertyType, ScalarType},
};
use std::path::Path;

/// Reads the rows of the element `vertex`.
pub(super) fn read(path: &Path, bytes: &[u8], rows: &mut Rows<'_>) -> Result<(), SceneError> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<DefaultElement>::new().read_header(&mut reader).map_err(|error| {
        let message = format!("PLY header: {}", one_line(&error.to_string()));
        SceneError::invalid(path, message, "write a PLY 1.0 header from `ply` to `end_header`")
    })?;
    let body = reader.into_inner();
    let text = String::from_utf8_lossy(&bytes[..bytes.len() - body.len()]);
    let property_count: usize = header.elements.values().map(|e| e.properties.len()).sum();
    for (word, count) in [("element", header.elements.len()), ("property", property_count)] {
        if text.lines().filter(|line| line.split_whitespace().next() == Some(word)).count() != count
        {
            let message = format!("PLY header: two lines declare the same {word}");
            return Err(SceneError::invalid(path, message, "rename or remove one of them"));
        }
    }
    let mut body = Body { path, encoding: header.encoding, rest: body, line: text.lines().count() };
    for element in header.elements.values() {
        body.check_count(element)?;
        if element.name == "vertex" {
            return body.read_vertices(element, rows);
        }
        body.skip(element)?;
    }
    Err(SceneError::invalid(
        path,
        "PLY header: there is no element `vertex`",
        "name the particles' element `vertex`",
    ))
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// What follows the header.
struct Body<'a> {
    path: &'a Path,
    encoding: Encoding,
    rest: &'a [u8],
    /// Of the last line read, ascii only.
    line: usize,
}

impl<'a> Body<'a> {
    fn invalid(&self, message: impl Into<String>) -> SceneError {
        let help = "the file is damaged or its header is wrong: write it again";
        SceneError::invalid(self.path, message, help)
    }

    /// A header may promise no more than the file can hold.
    fn check_count(&self, element: &ElementDef) -> Result<(), SceneError> {
        let least: usize = match self.encoding {
            Encoding::Ascii => element.properties.len(),
            _ => element.properties.values().map(|p| least_size(&p.data_type)).sum(),
        };
        // The last line of an ascii file may lack its end.
        let room = (self.rest.len() + 1) / least.max(1);
        if element.count <= room || least == 0 && self.encoding != Encoding::Ascii {
            return Ok(());
        }
        Err(self.invalid(format!(
            "the header promises {} rows of `{}`, but the file has room for {room} at most",
            element.count, element.name
        )))
    }

    fn truncated(&self, element: &ElementDef, row: usize) -> SceneError {
        let (name, count) = (&element.name, element.count);
        self.invalid(format!("the file ends in row {} of {count} of `{name}`", row + 1))
    }

    fn skip(&mut self, element: &ElementDef) -> Result<(), SceneError> {
        if element.properties.is_empty() {
            return Ok(());
        }
        for row in 0..element.count {
            if self.encoding == Encoding::Ascii {
                self.next_line().ok_or_else(|| self.truncated(element, row))?;
                continue;
            }
            for property in element.properties.values() {
                self.binary_value(&property.data_type)
                    .ok_or_else(|| self.truncated(element, row))?;
            }
        }
        Ok(())
    }

    fn read_vertices(
        &mut self,
        element: &ElementDef,
        rows: &mut Rows<'_>,
    ) -> Result<(), SceneError> {
        let mut storage = [Storage::Absent; NAMES.len()];
        let columns: Vec<(Option<usize>, &PropertyType)> = element
            .properties
            .values()
            .map(|property| {
                let column = match &property.data_type {
                    PropertyType::List(..) => None,
                    PropertyType::Scalar(scalar) => {
                        let column = NAMES.iter().position(|name| *name == property.name);
                        if let Some(column) = column {
                            storage[column] = storage_of(scalar, column);
                        }
                        column
                    }
                };
                (column, &property.data_type)
            })
            .collect();
        rows.begin(self.path, storage, element.count)?;
        for i in 0..element.count {
            let mut row = BLANK;
            if self.encoding == Encoding::Ascii {
                let line = self.next_line().ok_or_else(|| self.truncated(element, i))?;
                let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
                for (column, data_type) in &columns {
                    let value = ascii_value(&mut words, data_type).map_err(|problem| {
                        self.invalid(format!("line {}: {problem}", self.line))
                    })?;
                    if let Some(column) = column {
                        row[*column] = value;
                    }
                }
            } else {
                for (column, data_type) in &columns {
                    let value =
                        self.binary_value(data_type).ok_or_else(|| self.truncated(element, i))?;
                    if let Some(column) = column {
                        row[*column] = value;
                    }
                }
            }
            rows.push(&row);
        }
        Ok(())
    }

    /// The next line with anything in it.
    fn next_line(&mut self) -> Option<&'a [u8]> {
        while !self.rest.is_empty() {
            let end = self.rest.iter().position(|b| *b == b'\n').unwrap_or(self.rest.len());
            let (line, rest) = self.rest.split_at(end);
            self.rest = rest.get(1..).unwrap_or_default();
            self.line += 1;
            if !line.trim_ascii().is_empty() {
                return Some(line);
            }
        }
        None
    }

    /// 0 for a list, which is skipped. `None` where the file ends.
    fn binary_value(&mut self, data_type: &PropertyType) -> Option<f64> {
        match data_type {
            PropertyType::Scalar(scalar) => self.binary_scalar(scalar),
            PropertyType::List(count, item) => {
                let length = self.binary_scalar(count)?;
                let size = (length as usize).checked_mul(size_of_scalar(item))?;
                self.rest = self.rest.get(size..)?;
                Some(0.0)
            }
        }
    }

    fn binary_scalar(&mut self, scalar: &ScalarType) -> Option<f64> {
        macro_rules! number {
            ($kind:ty) => {{
                let (head, rest) = self.rest.split_first_chunk()?;
                self.rest = rest;
                Some(if self.encoding == Encoding::BinaryLittleEndian {
                    <$kind>::from_le_bytes(*head).into()
                } else {
                    <$kind>::from_be_bytes(*head).into()
                })
            }};
        }
        match scalar {
            ScalarType::Char => number!(i8),
            ScalarType::UChar => number!(u8),
            ScalarType::Short => number!(i16),
            ScalarType::UShort => number!(u16),
            ScalarType::Int => number!(i32),
            ScalarType::UInt => number!(u32),
            ScalarType::Float => number!(f32),
            ScalarType::Double => number!(f64),
        }
    }
}

/// Integer colours of any width are bytes.
fn storage_of(scalar: &ScalarType, column: usize) -> Storage {
    let is_color = matches!(NAMES[column], "red" | "green" | "blue" | "alpha");
    match scalar {
        ScalarType::Float | ScalarType::Double => Storage::Plain,
        _ if is_color => Storage::Byte,
        _ => Storage::Plain,
    }
}

fn size_of_scalar(scalar: &ScalarType) -> usize {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// [bytes]
fn least_size(data_type: &PropertyType) -> usize {
    match data_type {
        PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => size_of_scalar(scalar),
    }
}

/// 0 for a list, which is skipped.
fn ascii_value<'w>(
    words: &mut impl Iterator<Item = &'w [u8]>,
    data_type: &PropertyType,
) -> Result<f64, String> {
    let word = words.next().ok_or("the row has too few numbers")?;
    let text = String::from_utf8_lossy(word);
    let value: f64 = text.parse().map_err(|_| format!("`{text}` is not a number"))?;
    if matches!(data_type, PropertyType::Scalar(_)) {
        return Ok(value);
    }
    for _ in 0..value as usize {
        words.next().ok_or("a list has fewer items than it promises")?;
    }
    Ok(0.0)
}
