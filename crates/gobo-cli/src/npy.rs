//! `NumPy`'s array file, formats 1.0 to 3.0:
//! <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.
use std::io::{self, Read, Write};

/// The problem and the remedy.
pub(crate) type NpyFault = (String, &'static str);

/// Longest header that is read [bytes]; `NumPy` itself reads 10,000.
const MAX_HEADER: usize = 1 << 16;
const WRITE_AGAIN: &str = "write it again with numpy.save";

/// Writes little-endian `f32`s in C order.
pub(crate) fn write(
    out: &mut dyn Write,
    shape: &[usize],
    values: impl ExactSizeIterator<Item = f32>,
) -> io::Result<()> {
    const PIECE: usize = 1 << 16;
    debug_assert_eq!(shape.iter().product::<usize>(), values.len());
    let mut bytes = header(shape);
    for value in values {
        bytes.extend_from_slice(&value.to_le_bytes());
        if bytes.len() >= PIECE {
            out.write_all(&bytes)?;
            bytes.clear();
        }
    }
    out.write_all(&bytes)
}

/// Encodes little-endian `f32`s in C order.
#[cfg(test)]
pub(crate) fn encode(shape: &[usize], values: impl ExactSizeIterator<Item = f32>) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(&mut bytes, shape, values).expect("memory takes all");
    bytes
}

/// Magic and header of an array; its values follow.
pub(super) fn header(shape: &[usize]) -> Vec<u8> {
    let lengths: String = shape.iter().map(|length| format!("{length}, ")).collect();
    let shape = if shape.len() == 1 { lengths.trim_end() } else { lengths.trim_end_matches(", ") };
    let mut header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({shape}), }}");
    // Magic, version and length are 10 bytes; the data starts at a multiple of 64, after a newline.
    let padding = 63 - (10 + header.len()) % 64;
    header.extend(std::iter::repeat_n(' ', padding));
    header.push('\n');

    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend_from_slice(&(header.len() as u16).to_le_bytes());
    bytes.extend_from_slice(header.as_bytes());
    bytes
}

/// Writer of an array, value by value.
#[derive(Debug)]
pub(crate) struct Writer<W: Write>(io::BufWriter<W>);

impl<W: Write> Writer<W> {
    pub(crate) fn new(out: W, shape: &[usize]) -> io::Result<Self> {
        let mut out = io::BufWriter::new(out);
        out.write_all(&header(shape))?;
        Ok(Self(out))
    }

    /// Writes the next values.
    pub(crate) fn add(&mut self, values: &[f32]) -> io::Result<()> {
        values.iter().try_for_each(|value| self.0.write_all(&value.to_le_bytes()))
    }

    pub(crate) fn finish(mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// Reader of an array of little-endian `f32`s in C order, value by value.
#[derive(Debug)]
pub(crate) struct Reader<R> {
    pub(crate) shape: Vec<usize>,
    values: R,
}

impl<R: Read> Reader<R> {
    /// `length`: of the whole file [bytes].
    pub(crate) fn new(mut file: R, length: u64) -> Result<Self, NpyFault> {
        let mut head = [0; 8];
        let is_array = file.read_exact(&mut head).is_ok() && head.starts_with(b"\x93NUMPY");
        if !is_array {
            return Err(("it is no NumPy array".to_owned(), "write it with numpy.save"));
        }
        // The header's length has two bytes in version 1.0, four in later ones.
        let wide = match head[6] {
            1 => 2,
            2 | 3 => 4,
            version => {
                let message = format!("its format is {version}.{}", head[7]);
                return Err((message, "write it as format 1.0: numpy.lib.format.write_array"));
            }
        };
        let cut = |_| ("it ends too early".to_owned(), WRITE_AGAIN);
        let mut header_length = [0; 4];
        file.read_exact(&mut header_length[..wide]).map_err(cut)?;
        let header_length = u32::from_le_bytes(header_length) as usize;
        if header_length > MAX_HEADER {
            return Err((format!("its header has {header_length} bytes"), WRITE_AGAIN));
        }
        let mut header = vec![0; header_length];
        file.read_exact(&mut header).map_err(cut)?;
        let shape = shape(&header)?;
        let data = length.saturating_sub((8 + wide + header_length) as u64);
        let count = shape.iter().try_fold(4_usize, |product, &length| product.checked_mul(length));
        if count.and_then(|count| u64::try_from(count).ok()) != Some(data) {
            return Err((format!("its shape {shape:?} is not that of {data} bytes"), WRITE_AGAIN));
        }
        Ok(Self { shape, values: file })
    }

    /// The next values.
    pub(crate) fn next<const N: usize>(&mut self) -> Result<[f32; N], NpyFault> {
        let mut values = [0.0; N];
        for value in &mut values {
            let mut bytes = [0; 4];
            let failed = |error: io::Error| (error.to_string(), WRITE_AGAIN);
            self.values.read_exact(&mut bytes).map_err(failed)?;
            *value = f32::from_le_bytes(bytes);
        }
        Ok(values)
    }
}

/// Shape of an array of little-endian `f32`s in C order.
fn shape(header: &[u8]) -> Result<Vec<usize>, NpyFault> {
    let wrong = |message: &str| (message.to_owned(), WRITE_AGAIN);
    let header = str::from_utf8(header).map_err(|_| wrong("its header is no text"))?;
    let value = |key: &str| {
        let rest = header.split_once(&format!("'{key}':"))?.1.trim_start();
        let end = if rest.starts_with('(') { rest.find(')')? + 1 } else { rest.find([',', '}'])? };
        Some(rest[..end].trim())
    };
    let value = |key| value(key).ok_or_else(|| wrong(&format!("its header has no {key}")));
    let kind = value("descr")?.trim_matches('\'');
    if kind != "<f4" {
        let message = format!("its numbers are {kind}, not 32-bit floats");
        return Err((message, "use .astype('<f4')"));
    }
    if value("fortran_order")? != "False" {
        return Err(("its columns come first".to_owned(), "use numpy.ascontiguousarray"));
    }
    let shape = value("shape")?.trim_matches(['(', ')']).split(',').map(str::trim);
    shape
        .filter(|length| !length.is_empty())
        .map(|length| {
            let message = format!("{length:?} is no length of a shape");
            length.parse().map_err(|_| (message, WRITE_AGAIN))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{Reader, Writer, encode};

    /// Shape and values, or the problem with its remedy.
    fn decode(bytes: &[u8]) -> Result<(Vec<usize>, Vec<f32>), String> {
        let told = |(message, help): (String, &str)| format!("{message}: {help}");
        let mut reader = Reader::new(bytes, bytes.len() as u64).map_err(told)?;
        let count: usize = reader.shape.iter().product();
        let values: Result<Vec<f32>, _> = (0..count).map(|_| Ok(reader.next::<1>()?[0])).collect();
        Ok((reader.shape, values.map_err(told)?))
    }

    #[test]
    fn arrays_come_back() {
        for shape in [&[2, 3][..], &[6], &[1, 1, 6]] {
            let values: Vec<f32> = (0..6_u8).map(|i| f32::from(i) - 2.5).collect();
            let bytes = encode(shape, values.iter().copied());
            let mut written = Vec::new();
            let mut writer = Writer::new(&mut written, shape).unwrap();
            values.chunks(4).try_for_each(|some| writer.add(some)).unwrap();
            writer.finish().unwrap();
            assert_eq!(written, bytes);
            assert_eq!(decode(&bytes), Ok((shape.to_vec(), values)));
        }
        let empty = encode(&[0, 3], [].into_iter());
        assert_eq!(decode(&empty), Ok((vec![0, 3], vec![])));
        // Version 2.0 has a longer length.
        let mut long = b"\x93NUMPY\x02\x00\x46\x00\x00\x00".to_vec();
        long.extend(b"{'descr': '<f4', 'fortran_order': False, 'shape': (1, 3), }");
        long.resize(12 + 0x46, b' ');
        long.extend([0; 12]);
        assert_eq!(decode(&long), Ok((vec![1, 3], vec![0.0; 3])));
        for (byte, version) in [(6, 9), (6, 0), (11, 1)] {
            let mut wrong = long.clone();
            wrong[byte] = version;
            assert!(decode(&wrong).is_err(), "byte {byte} is {version}");
        }
    }

    #[test]
    fn what_is_no_array_is_refused_with_its_reason() {
        let good = encode(&[1, 3], [1.0, 2.0, 3.0].into_iter());
        let with = |from: &str, to: &str| {
            let text = String::from_utf8_lossy(&good[10..118]).replace(from, to);
            let header = format!("{text:<118}");
            let mut bytes = good[..10].to_vec();
            bytes.extend(&header.as_bytes()[..118]);
            bytes.extend(&good[128..]);
            decode(&bytes).unwrap_err()
        };
        assert!(with("<f4", "<f8").contains("astype"));
        assert!(with("False", "True").contains("ascontiguousarray"));
        assert!(with("'shape'", "'size'").contains("no shape"));
        assert!(with("(1, 3)", "(1, x)").contains("\"x\""));
        assert!(with("(1, 3)", "(2, 3)").contains("12 bytes"));
        assert!(with("(1, 3)", "(4611686018427387904, 12)").contains("not that of"));
        assert!(decode(b"ply\n").unwrap_err().contains("numpy.save"));
        for end in 6..128 {
            assert!(decode(&good[..end]).is_err(), "{end}");
        }
    }

    #[test]
    fn bytes_are_those_of_numpy() {
        // numpy.save of numpy.array([[1, 2], [3, 4], [5, 6]], '<f4')
        let mut expected = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
        expected.extend_from_slice(b"{'descr': '<f4', 'fortran_order': False, 'shape': (3, 2), }");
        expected.resize(127, b' ');
        expected.push(b'\n');
        for value in [1.0_f32, 2.0, 3.0, 4.0, 5.0, 6.0] {
            expected.extend(value.to_le_bytes());
        }
        assert_eq!(encode(&[3, 2], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].into_iter()), expected);
    }

    #[test]
    fn data_is_aligned_whatever_the_shape() {
        for shape in [&[1][..], &[1, 1, 3], &[100_000, 2], &[123_456_789, 0]] {
            let count = shape.iter().product();
            let bytes = encode(shape, vec![0.5; count].into_iter());
            assert_eq!((bytes.len() - 4 * count) % 64, 0, "{shape:?}");
        }
        let line = encode(&[2], [0.0; 2].into_iter());
        assert!(String::from_utf8_lossy(&line).contains("'shape': (2,), }"));
    }
}
