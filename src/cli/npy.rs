//! `NumPy`'s array file, format 1.0: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.

/// Encodes little-endian `f32`s in C order.
pub(crate) fn encode(shape: &[usize], values: impl ExactSizeIterator<Item = f32>) -> Vec<u8> {
    debug_assert_eq!(shape.iter().product::<usize>(), values.len());
    let lengths: String = shape.iter().map(|length| format!("{length}, ")).collect();
    let shape = if shape.len() == 1 { lengths.trim_end() } else { lengths.trim_end_matches(", ") };
    let mut header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({shape}), }}");
    // Magic, version and length are 10 bytes; the data starts at a multiple of 64, after a newline.
    let padding = 63 - (10 + header.len()) % 64;
    header.extend(std::iter::repeat_n(' ', padding));
    header.push('\n');

    let mut bytes = Vec::with_capacity(10 + header.len() + values.len() * 4);
    bytes.extend_from_slice(b"\x93NUMPY\x01\x00");
    bytes.extend_from_slice(&(header.len() as u16).to_le_bytes());
    bytes.extend_from_slice(header.as_bytes());
    bytes.extend(values.flat_map(f32::to_le_bytes));
    bytes
}

/// Decodes shape and values of an array of little-endian `f32`s in C order.
pub(crate) fn decode(bytes: &[u8]) -> Result<(Vec<usize>, Vec<f32>), String> {
    let cut = || "it ends too early: write it again".to_owned();
    let rest =
        bytes.strip_prefix(b"\x93NUMPY").ok_or("it is no NumPy array: write it with numpy.save")?;
    let (version, rest) = rest.split_at_checked(2).ok_or_else(cut)?;
    // The header's length has two bytes in version 1.0, four in later ones.
    let wide = if version[0] == 1 { 2 } else { 4 };
    let (length, rest) = rest.split_at_checked(wide).ok_or_else(cut)?;
    let length = length.iter().rev().fold(0, |sum, &byte| sum * 256 + usize::from(byte));
    let (header, data) = rest.split_at_checked(length).ok_or_else(cut)?;
    let header = str::from_utf8(header).map_err(|_| "its header is no text".to_owned())?;
    let value = |key: &str| {
        let rest = header.split_once(&format!("'{key}':"))?.1.trim_start();
        let end = if rest.starts_with('(') { rest.find(')')? + 1 } else { rest.find([',', '}'])? };
        Some(rest[..end].trim())
    };
    let value = |key| value(key).ok_or_else(|| format!("its header has no {key}"));
    let kind = value("descr")?.trim_matches('\'');
    if kind != "<f4" {
        return Err(format!("its numbers are {kind}, not 32-bit floats: use .astype('<f4')"));
    }
    if value("fortran_order")? != "False" {
        return Err("its columns come first: use numpy.ascontiguousarray".to_owned());
    }
    let shape = value("shape")?.trim_matches(['(', ')']).split(',').map(str::trim);
    let shape: Vec<usize> = shape
        .filter(|length| !length.is_empty())
        .map(|length| length.parse().map_err(|_| format!("{length:?} is no length of a shape")))
        .collect::<Result<_, _>>()?;
    let count = shape.iter().try_fold(4_usize, |product, &length| product.checked_mul(length));
    if count != Some(data.len()) {
        return Err(format!("its shape {shape:?} is not that of {} bytes", data.len()));
    }
    let values =
        data.chunks_exact(4).map(|word| f32::from_le_bytes([word[0], word[1], word[2], word[3]]));
    Ok((shape, values.collect()))
}

#[cfg(test)]
mod tests {
    use super::{decode, encode};

    #[test]
    fn arrays_come_back() {
        for shape in [&[2, 3][..], &[6], &[1, 1, 6]] {
            let values: Vec<f32> = (0..6_u8).map(|i| f32::from(i) - 2.5).collect();
            let bytes = encode(shape, values.iter().copied());
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
