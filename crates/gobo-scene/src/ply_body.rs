//! The rows of a PLY file, after its header.
use super::{
    error::{Fault, quoted},
    ply_header::{Element, PlyEncoding, PlyHeader, PropertyKind, Scalar},
};
use rayon::prelude::*;

/// Rows that a core reads at a time, and number of such blocks in memory.
const BLOCK: usize = 1 << 14;
const WAVE: usize = 64;

const DAMAGED: &str = "the file is damaged or its header is wrong: write it again";

/// Columns that are taken from the rows of an element.
#[derive(Clone, Debug)]
pub(super) struct ElementTable {
    /// Column of each property in a row; `None` if it is not read.
    pub(super) columns: Vec<Option<usize>>,
    /// Numbers per row.
    pub(super) width: usize,
}

/// Upper bound of an element's rows in `bytes`.
pub(super) fn most_rows(element: &Element, encoding: PlyEncoding, bytes: u64) -> u64 {
    // The last line of an ascii file may lack its line end.
    (bytes + 1) / least_size(element, encoding).max(1)
}

/// Least size of a row \[bytes\].
fn least_size(element: &Element, encoding: PlyEncoding) -> u64 {
    let least = match encoding {
        PlyEncoding::Ascii => element.properties.len(),
        _ => element.properties.iter().map(|property| property.kind.least_size()).sum(),
    };
    least as u64
}

/// Size of every row \[bytes\]; `None` if they differ.
fn row_size(element: &Element, encoding: PlyEncoding) -> Option<usize> {
    let size = |kind: PropertyKind| match kind {
        PropertyKind::One(scalar) => Some(scalar.size()),
        PropertyKind::List { .. } => None,
    };
    let is_text = encoding == PlyEncoding::Ascii;
    (!is_text).then(|| element.properties.iter().map(|property| size(property.kind)).sum())?
}

/// The part of the file after the header.
#[derive(Debug)]
pub(super) struct PlyBody<'a> {
    encoding: PlyEncoding,
    rest: &'a [u8],
    /// Number of the last line read, ascii only.
    line: usize,
}

/// Reason why a value cannot be read.
enum Problem {
    Ends,
    Wrong(String),
}

impl<'a> PlyBody<'a> {
    /// The bytes after the header.
    pub(super) fn new(header: &PlyHeader, bytes: &'a [u8]) -> Self {
        let (encoding, line) = (header.encoding, header.lines);
        Self { encoding, rest: &bytes[header.length..], line }
    }

    /// Checks that a header announces no more than the file can hold.
    pub(super) fn check_count(&self, element: &Element) -> Result<(), Fault> {
        let most = most_rows(element, self.encoding, self.rest.len() as u64);
        let is_empty = least_size(element, self.encoding) == 0;
        if element.count as u64 <= most || is_empty && self.encoding != PlyEncoding::Ascii {
            return Ok(());
        }
        let message = format!(
            "the header promises {} rows of {}, but the file is long enough for {most} at most",
            element.count,
            quoted(&element.name)
        );
        Err((message, DAMAGED))
    }

    fn fault(&self, problem: Problem, element: &Element, row: usize) -> Fault {
        let (name, count) = (quoted(&element.name), element.count);
        let message = match problem {
            Problem::Ends => format!("the file ends in row {} of {count} of {name}", row + 1),
            Problem::Wrong(what) if self.encoding == PlyEncoding::Ascii => {
                format!("line {}: {what}", self.line)
            }
            Problem::Wrong(what) => format!("row {} of {name}: {what}", row + 1),
        };
        (message, DAMAGED)
    }

    /// Reads a row of an element, value by value: `put` gets the property's index and its value, 0 for a
    /// list.
    fn row(&mut self, element: &Element, mut put: impl FnMut(usize, f64)) -> Result<(), Problem> {
        if self.encoding != PlyEncoding::Ascii {
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

    pub(super) fn skip(&mut self, element: &Element) -> Result<(), Fault> {
        if element.properties.is_empty() {
            return Ok(());
        }
        for row in 0..element.count {
            self.row(element, |_, _| {}).map_err(|problem| self.fault(problem, element, row))?;
        }
        Ok(())
    }

    /// Passes the items of list `which` in each row of an element to `take`.
    pub(super) fn lists(
        &mut self,
        element: &Element,
        which: usize,
        mut take: impl FnMut(&[f64]) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let mut items = Vec::new();
        for row in 0..element.count {
            items.clear();
            self.list(element, which, &mut items)
                .map_err(|problem| self.fault(problem, element, row))?;
            take(&items)?;
        }
        Ok(())
    }

    /// Reads a row, keeping only the items of a list.
    fn list(
        &mut self,
        element: &Element,
        which: usize,
        items: &mut Vec<f64>,
    ) -> Result<(), Problem> {
        if self.encoding == PlyEncoding::Ascii {
            let line = self.next_line().ok_or(Problem::Ends)?;
            let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
            for (i, property) in element.properties.iter().enumerate() {
                let PropertyKind::List { item, .. } = property.kind else {
                    ascii_value(&mut words, property.kind).map_err(Problem::Wrong)?;
                    continue;
                };
                if i != which {
                    ascii_value(&mut words, property.kind).map_err(Problem::Wrong)?;
                    continue;
                }
                let length =
                    ascii_value(&mut words, PropertyKind::One(item)).map_err(Problem::Wrong)?;
                for _ in 0..length as usize {
                    let value = ascii_value(&mut words, PropertyKind::One(item));
                    items.push(value.map_err(Problem::Wrong)?);
                }
            }
            return Ok(());
        }
        for (i, property) in element.properties.iter().enumerate() {
            let PropertyKind::List { length, item } = property.kind else {
                self.binary_value(property.kind)?;
                continue;
            };
            if i != which {
                self.binary_value(property.kind)?;
                continue;
            }
            let length = self.binary_scalar(length).ok_or(Problem::Ends)?;
            if length < 0.0 {
                return Err(Problem::Wrong(format!("a list of {length} items")));
            }
            let size = (length as usize).checked_mul(item.size()).ok_or(Problem::Ends)?;
            if size > self.rest.len() {
                return Err(Problem::Ends);
            }
            for _ in 0..length as usize {
                items.push(self.binary_scalar(item).ok_or(Problem::Ends)?);
            }
        }
        Ok(())
    }

    /// Passes each row of an element to `read`, as its number and its numbers in `table`'s columns, and each
    /// result to `take`, in order. Rows of one size are read on all cores.
    pub(super) fn rows<T: Send>(
        &mut self,
        element: &Element,
        table: &ElementTable,
        read: impl Fn(usize, &[f64]) -> T + Sync,
        mut take: impl FnMut(T) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let count = element.count;
        let size = row_size(element, self.encoding).filter(|&size| size > 0);
        let Some(all) = size.and_then(|size| self.rest.get(..size.checked_mul(count)?)) else {
            let mut row = vec![0.0; table.width];
            for i in 0..count {
                self.numbers(element, table, &mut row)
                    .map_err(|problem| self.fault(problem, element, i))?;
                take(read(i, &row))?;
            }
            return Ok(());
        };
        let size = size.unwrap_or(1);
        let block = |(number, bytes): (usize, &[u8])| {
            let mut body = PlyBody { encoding: self.encoding, rest: bytes, line: 0 };
            let mut row = vec![0.0; table.width];
            let mut row_of = |i: usize| {
                body.numbers(element, table, &mut row).map(|()| read(number * BLOCK + i, &row))
            };
            (0..bytes.len() / size).map(&mut row_of).collect::<Result<Vec<T>, Problem>>()
        };
        let blocks: Vec<(usize, &[u8])> = all.chunks(size * BLOCK).enumerate().collect();
        for wave in blocks.chunks(WAVE) {
            let found: Vec<_> = wave.par_iter().copied().map(block).collect();
            for (&(number, _), rows) in wave.iter().zip(found) {
                let rows = rows.map_err(|problem| self.fault(problem, element, number * BLOCK))?;
                rows.into_iter().try_for_each(&mut take)?;
            }
        }
        self.rest = &self.rest[all.len()..];
        Ok(())
    }

    /// Reads a row's numbers at a table's columns.
    fn numbers(
        &mut self,
        element: &Element,
        table: &ElementTable,
        row: &mut [f64],
    ) -> Result<(), Problem> {
        self.row(element, |column, value| {
            if let Some(column) = table.columns[column] {
                row[column] = value;
            }
        })
    }

    /// A note about bytes after the last row.
    pub(super) fn left_over(&self) -> Option<String> {
        let left = self.rest.trim_ascii().len();
        let bytes = if left == 1 { "1 byte" } else { &format!("{left} bytes") };
        (left > 0).then(|| format!("{bytes} after the last row are not read"))
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
    fn binary_value(&mut self, kind: PropertyKind) -> Result<f64, Problem> {
        match kind {
            PropertyKind::One(scalar) => self.binary_scalar(scalar).ok_or(Problem::Ends),
            PropertyKind::List { length, item } => {
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
                Some(if self.encoding == PlyEncoding::LittleEndian {
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

/// The next ascii value; 0 for a list, which is skipped.
fn ascii_value<'w>(
    words: &mut impl Iterator<Item = &'w [u8]>,
    kind: PropertyKind,
) -> Result<f64, String> {
    let word = words.next().ok_or("the row has too few numbers")?;
    let text = String::from_utf8_lossy(word);
    if matches!(kind, PropertyKind::One(_)) {
        return text.parse().map_err(|_| format!("{} is not a number", quoted(&text)));
    }
    let length: usize =
        text.parse().map_err(|_| format!("{} is no length of a list", quoted(&text)))?;
    for _ in 0..length {
        words.next().ok_or("a list has fewer items than it promises")?;
    }
    Ok(0.0)
}
