//! Text in files of arrays: header lines and numbers.
use crate::{error::quoted, vdb::VolumeFault};
use glam::DVec3;

/// The line at byte `at` without its end, and the offset of the next one; `None` at the end.
pub(super) fn line(bytes: &[u8], at: usize) -> Option<(&str, usize)> {
    let rest = bytes.get(at..).filter(|rest| !rest.is_empty())?;
    let length = rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
    let text = std::str::from_utf8(&rest[..length]).unwrap_or_default();
    Some((text.trim_end_matches('\r'), (at + length + 1).min(bytes.len())))
}

/// Numbers between blanks, all belonging to `key`.
pub(super) fn numbers(key: &str, text: &str) -> Result<Vec<f64>, VolumeFault> {
    let number = |word: &str| {
        word.parse::<f64>().map_err(|_| {
            VolumeFault::damaged(format!("{key} has {} where a number stands", quoted(word)))
        })
    };
    text.split_ascii_whitespace().map(number).collect()
}

/// Whole numbers between blanks, all belonging to `key`.
pub(super) fn counts(key: &str, text: &str) -> Result<Vec<u64>, VolumeFault> {
    let number = |word: &str| {
        word.parse::<u64>().map_err(|_| {
            VolumeFault::damaged(format!("{key} has {} where a whole number stands", quoted(word)))
        })
    };
    text.split_ascii_whitespace().map(number).collect()
}

/// The first three numbers; missing ones are `usual`.
pub(super) fn three(values: &[f64], usual: f64) -> DVec3 {
    let at = |i: usize| values.get(i).copied().unwrap_or(usual);
    DVec3::new(at(0), at(1), at(2))
}

/// The first `count` numbers of a text as bytes of little-endian `f64`s.
pub(super) fn doubles(bytes: &[u8], count: usize) -> Result<Vec<u8>, VolumeFault> {
    // Each number has a digit and, except the last, a blank.
    if count > bytes.len() / 2 + 1 {
        let message = format!("{count} numbers in {} bytes of text", bytes.len());
        return Err(VolumeFault::damaged(message));
    }
    let mut doubles = super::packed::room(count * 8)?;
    let words = bytes.split(|&byte| byte.is_ascii_whitespace() || byte == b',');
    for word in words.filter(|word| !word.is_empty()).take(count) {
        let word = String::from_utf8_lossy(word);
        let value: f64 = word.parse().map_err(|_| {
            VolumeFault::damaged(format!("{} stands where a voxel does", quoted(&word)))
        })?;
        doubles.extend(value.to_le_bytes());
    }
    Ok(doubles)
}
