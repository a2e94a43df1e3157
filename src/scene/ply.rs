//! PLY: the rows after the header.
use super::{
    SceneError,
    error::quoted,
    particles::{BLANK, Columns, NAMES, Rows, Storage},
    ply_header::{self, Element, Encoding, Header, Kind, Scalar},
};
use std::path::Path;

/// Reads the rows of the element `vertex`.
pub(super) fn read(path: &Path, bytes: &[u8], rows: &mut Rows<'_>) -> Result<(), SceneError> {
    let header = ply_header::parse(bytes)
        .map_err(|(message, help)| SceneError::invalid(path, message, help))?;
    refuse_splats(path, &header)?;
    let (encoding, line) = (header.encoding, header.lines);
    let mut body = Body { path, encoding, rest: &bytes[header.length..], line };
    let mut has_vertices = false;
    for element in &header.elements {
        body.check_count(element)?;
        if element.name == "vertex" {
            has_vertices = true;
            body.read_vertices(element, rows)?;
        } else {
            body.skip(element)?;
            if element.count > 0 {
                let name = quoted(&element.name);
                rows.note(path, &format!("{} rows of {name} are not read", element.count));
            }
        }
    }
    if !has_vertices {
        let message = "there is no element `vertex` in the PLY header";
        return Err(SceneError::invalid(path, message, "name the particles' element `vertex`"));
    }
    let left = body.rest.trim_ascii().len();
    if left > 0 {
        let bytes = if left == 1 { "1 byte" } else { &format!("{left} bytes") };
        rows.note(path, &format!("{bytes} after the last row are not read"));
    }
    Ok(())
}

/// Number of particles that a header promises, given the first bytes of a file and its length; `None` if the
/// file is too short for them.
pub(super) fn announced((head, length): (Vec<u8>, u64)) -> Option<u64> {
    let header = ply_header::parse(&head).ok()?;
    let vertices = header.elements.iter().find(|element| element.name == "vertex")?;
    let most = most_rows(vertices, header.encoding, length.saturating_sub(header.length as u64));
    let count = vertices.count as u64;
    (count <= most).then_some(count)
}

/// Most rows of an element in so many bytes.
fn most_rows(element: &Element, encoding: Encoding, bytes: u64) -> u64 {
    // The last line of an ascii file may lack its line end.
    (bytes + 1) / least_size(element, encoding).max(1)
}

/// Least size of a row [bytes].
fn least_size(element: &Element, encoding: Encoding) -> u64 {
    let least = match encoding {
        Encoding::Ascii => element.properties.len(),
        _ => element.properties.iter().map(|property| property.kind.least_size()).sum(),
    };
    least as u64
}

/// Columns of anisotropic Gaussians in files of 3D Gaussian splatting and its relatives. Read as discs they
/// would be wrong.
const SPLATS: [&str; 6] =
    ["scale_0", "rot_0", "f_dc_0", "packed_position", "packed_rotation", "packed_scale"];

fn refuse_splats(path: &Path, header: &Header) -> Result<(), SceneError> {
    let mut properties = header.elements.iter().flat_map(|element| &element.properties);
    let Some(found) = properties.find(|property| SPLATS.contains(&property.name.as_str())) else {
        return Ok(());
    };
    let message = format!("holds anisotropic Gaussians (splats): it has a column `{}`", found.name);
    let help = "gobo has no such casters: write particles with x, y, z, radius and alpha instead";
    Err(SceneError::invalid(path, message, help))
}

/// The part of the file after the header.
struct Body<'a> {
    path: &'a Path,
    encoding: Encoding,
    rest: &'a [u8],
    /// Number of the last line read, ascii only.
    line: usize,
}

/// Reason why a value cannot be read.
enum Problem {
    Ends,
    Wrong(String),
}

impl<'a> Body<'a> {
    fn invalid(&self, message: impl AsRef<str>) -> SceneError {
        let help = "the file is damaged or its header is wrong: write it again";
        SceneError::invalid(self.path, message, help)
    }

    /// Checks that a header promises no more than the file can hold.
    fn check_count(&self, element: &Element) -> Result<(), SceneError> {
        let most = most_rows(element, self.encoding, self.rest.len() as u64);
        let is_empty = least_size(element, self.encoding) == 0;
        if element.count as u64 <= most || is_empty && self.encoding != Encoding::Ascii {
            return Ok(());
        }
        Err(self.invalid(format!(
            "the header promises {} rows of {}, but the file is long enough for {most} at most",
            element.count,
            quoted(&element.name)
        )))
    }

    fn fault(&self, problem: Problem, element: &Element, row: usize) -> SceneError {
        let (name, count) = (quoted(&element.name), element.count);
        self.invalid(match problem {
            Problem::Ends => format!("the file ends in row {} of {count} of {name}", row + 1),
            Problem::Wrong(what) if self.encoding == Encoding::Ascii => {
                format!("line {}: {what}", self.line)
            }
            Problem::Wrong(what) => format!("row {} of {name}: {what}", row + 1),
        })
    }

    /// Reads a row of an element, value by value: `put` gets the property's index and its value, 0 for a
    /// list.
    fn row(&mut self, element: &Element, mut put: impl FnMut(usize, f64)) -> Result<(), Problem> {
        if self.encoding != Encoding::Ascii {
            for (i, property) in element.properties.iter().enumerate() {
                put(i, self.binary_value(property.kind)?);
            }
            return Ok(());
        }
        let line = self.next_line().ok_or(Problem::Ends)?;
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        for (i, property) in element.properties.iter().enumerate() {
            put(i, ascii_value(&mut words, property.kind).map_err(Problem::Wrong)?);
        }
        match words.count() {
            0 => Ok(()),
            more => Err(Problem::Wrong(format!("the row has {more} numbers too many"))),
        }
    }

    fn skip(&mut self, element: &Element) -> Result<(), SceneError> {
        if element.properties.is_empty() {
            return Ok(());
        }
        for row in 0..element.count {
            self.row(element, |_, _| {}).map_err(|problem| self.fault(problem, element, row))?;
        }
        Ok(())
    }

    fn read_vertices(&mut self, element: &Element, rows: &mut Rows<'_>) -> Result<(), SceneError> {
        let mut columns = Columns::default();
        let places: Vec<Option<usize>> = element
            .properties
            .iter()
            .map(|property| match property.kind {
                Kind::One(scalar) => columns.find(&property.name, storage_of(scalar)),
                Kind::List { .. } => columns.unread(&property.name),
            })
            .collect();
        rows.begin(self.path, &columns, element.count)?;
        for i in 0..element.count {
            let mut row = BLANK;
            let put = |column: usize, value| {
                if let Some(place) = places[column] {
                    row[place] = value;
                }
            };
            self.row(element, put).map_err(|problem| self.fault(problem, element, i))?;
            rows.push(&row);
        }
        Ok(())
    }

    /// The next line that is not blank.
    fn next_line(&mut self) -> Option<&'a [u8]> {
        while !self.rest.is_empty() {
            let is_end = |byte: &u8| matches!(byte, b'\n' | b'\r');
            let end = self.rest.iter().position(is_end).unwrap_or(self.rest.len());
            let (line, rest) = self.rest.split_at(end);
            let is_pair = rest.starts_with(b"\r\n");
            self.rest = rest.get(if is_pair { 2 } else { 1 }..).unwrap_or_default();
            self.line += 1;
            if !line.trim_ascii().is_empty() {
                return Some(line);
            }
        }
        None
    }

    /// The next binary value; 0 for a list, which is skipped.
    fn binary_value(&mut self, kind: Kind) -> Result<f64, Problem> {
        match kind {
            Kind::One(scalar) => self.binary_scalar(scalar).ok_or(Problem::Ends),
            Kind::List { length, item } => {
                let length = self.binary_scalar(length).ok_or(Problem::Ends)?;
                if length < 0.0 {
                    return Err(Problem::Wrong(format!("a list of {length} items")));
                }
                let size = (length as usize).checked_mul(item.size()).ok_or(Problem::Ends)?;
                self.rest = self.rest.get(size..).ok_or(Problem::Ends)?;
                Ok(0.0)
            }
        }
    }

    fn binary_scalar(&mut self, scalar: Scalar) -> Option<f64> {
        macro_rules! number {
            ($kind:ty) => {{
                let (head, rest) = self.rest.split_first_chunk()?;
                self.rest = rest;
                Some(if self.encoding == Encoding::LittleEndian {
                    <$kind>::from_le_bytes(*head).into()
                } else {
                    <$kind>::from_be_bytes(*head).into()
                })
            }};
        }
        match scalar {
            Scalar::I8 => number!(i8),
            Scalar::U8 => number!(u8),
            Scalar::I16 => number!(i16),
            Scalar::U16 => number!(u16),
            Scalar::I32 => number!(i32),
            Scalar::U32 => number!(u32),
            Scalar::F32 => number!(f32),
            Scalar::F64 => number!(f64),
        }
    }
}

/// Storage of a column: integer colours of any width are bytes.
fn storage_of(scalar: Scalar) -> impl Fn(usize) -> Storage {
    move |column| {
        let is_color = matches!(NAMES[column], "red" | "green" | "blue" | "alpha");
        if scalar.is_whole() && is_color { Storage::Byte } else { Storage::Plain }
    }
}

/// The next ascii value; 0 for a list, which is skipped.
fn ascii_value<'w>(words: &mut impl Iterator<Item = &'w [u8]>, kind: Kind) -> Result<f64, String> {
    let word = words.next().ok_or("the row has too few numbers")?;
    let text = String::from_utf8_lossy(word);
    if matches!(kind, Kind::One(_)) {
        return text.parse().map_err(|_| format!("{} is not a number", quoted(&text)));
    }
    let length: usize =
        text.parse().map_err(|_| format!("{} is no length of a list", quoted(&text)))?;
    for _ in 0..length {
        words.next().ok_or("a list has fewer items than it promises")?;
    }
    Ok(0.0)
}
