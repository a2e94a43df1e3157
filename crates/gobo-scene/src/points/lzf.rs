//! LZF (Lehmann), the compression of points in PCL.

/// Most bytes that a compressed byte stands for: three make 264.
pub(super) const MOST: u64 = 88;

/// Decompresses to exactly `length` bytes; `None` if the stream is invalid.
pub(super) fn unpacked(mut bytes: &[u8], length: usize) -> Option<Vec<u8>> {
    let mut plain = Vec::with_capacity(length);
    while let Some((&control, rest)) = bytes.split_first() {
        bytes = rest;
        if control < 32 {
            let (run, rest) = bytes.split_at_checked(usize::from(control) + 1)?;
            bytes = rest;
            if plain.len() + run.len() > length {
                return None;
            }
            plain.extend_from_slice(run);
            continue;
        }
        let mut run = usize::from(control >> 5);
        if run == 7 {
            let (&more, rest) = bytes.split_first()?;
            (run, bytes) = (run + usize::from(more), rest);
        }
        let (&low, rest) = bytes.split_first()?;
        bytes = rest;
        let back = usize::from(control & 31) << 8 | usize::from(low);
        let start = plain.len().checked_sub(back + 1)?;
        if plain.len() + run + 2 > length {
            return None;
        }
        // A run may overlap its own output.
        for i in start..start + run + 2 {
            plain.push(plain[i]);
        }
    }
    (plain.len() == length).then_some(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three literal bytes, three copied from three back, twelve from one back.
    const STREAM: [u8; 9] = [2, b'a', b'b', b'c', 0x20, 2, 0xe0, 3, 0];

    #[test]
    fn runs_are_copied_from_what_is_there() {
        assert_eq!(unpacked(&STREAM, 18).unwrap(), b"abcabccccccccccccc");
        for length in 0..STREAM.len() {
            assert_eq!(unpacked(&STREAM[..length], 18), None, "{length}");
        }
        for length in [0, 5, 17, 19] {
            assert_eq!(unpacked(&STREAM, length), None, "{length}");
        }
        // A copy from before the start.
        assert_eq!(unpacked(&[0, b'a', 0x20, 1], 4), None);
    }
}
