//! `NumPy`'s array file, format 1.0: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.

/// Little-endian `f32`s in C order.
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

#[cfg(test)]
mod tests {
    use super::encode;

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
