//! Small changes of a file, several at a time.
use gobo_scene::generate::Chance;
use sha2::{Digest as _, Sha256};

/// Words that are likely to break readers.
const WORDS: [&[u8]; 18] = [
    b"0",
    b"-1",
    b"nan",
    b"inf",
    b"1e38",
    b"-1e-45",
    b"4294967295",
    b"4294967296",
    b"18446744073709551615",
    b"99999999",
    b"\"\"",
    b"[]",
    b"{}",
    b"..",
    b"\n\n",
    b"\0",
    b"\xff\xfe",
    b"true",
];
/// Limits of 32-bit numbers.
const ENDS: [u32; 8] =
    [0, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 0x7f80_0000, 0x7fc0_0000, 0xff7f_ffff];
const MAX_CHANGES: u64 = 6;
/// Largest size of a file [bytes].
const MAX_LENGTH: usize = 1 << 20;

/// One of the seeds with one to six changes.
pub(super) fn mutated(seeds: &[Vec<u8>], chance: &mut Chance) -> Vec<u8> {
    let mut bytes = seeds[below(chance, seeds.len())].clone();
    for _ in 0..=chance.bits() % MAX_CHANGES {
        change(&mut bytes, seeds, chance);
    }
    bytes
}

/// Ends a part with the digest of the bytes before, which a change has invalidated.
pub(super) fn seal(part: &mut Vec<u8>) {
    const DIGEST: usize = 32;
    part.truncate(part.len().saturating_sub(DIGEST));
    part.extend(Sha256::digest(&*part));
}

fn below(chance: &mut Chance, end: usize) -> usize {
    (chance.bits() % end.max(1) as u64) as usize
}

fn change(bytes: &mut Vec<u8>, seeds: &[Vec<u8>], chance: &mut Chance) {
    let at = below(chance, bytes.len() + 1);
    // Most runs are short.
    let long = 1 << below(chance, 9);
    let end = (at + 1 + below(chance, long)).min(bytes.len()).max(at);
    match chance.bits() % 9 {
        0 if at < bytes.len() => bytes[at] ^= 1 << (chance.bits() % 8),
        1 if at < bytes.len() => bytes[at] = chance.bits() as u8,
        2 => bytes.truncate(at),
        3 => drop(bytes.drain(at..end)),
        4 if bytes.len() < MAX_LENGTH => {
            let run = bytes[at..end].to_vec();
            bytes.splice(at..at, run);
        }
        5 => {
            let other = &seeds[below(chance, seeds.len())];
            let from = below(chance, other.len());
            let to = (from + 64).min(other.len());
            bytes.splice(at..end, other[from..to].iter().copied());
        }
        6 => number(bytes, at, WORDS[below(chance, WORDS.len())]),
        7 if at + 4 <= bytes.len() => {
            let value = ENDS[below(chance, ENDS.len())];
            bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        }
        _ => {
            let word = WORDS[below(chance, WORDS.len())];
            bytes.splice(at..at, word.iter().copied());
        }
    }
}

/// Replaces the next number in the text by a word.
fn number(bytes: &mut Vec<u8>, at: usize, word: &[u8]) {
    let is_part = |&byte: &u8| byte.is_ascii_digit() || b".-+e".contains(&byte);
    let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|skip| at + skip) else {
        return;
    };
    let end =
        bytes[start..].iter().position(|byte| !is_part(byte)).map_or(bytes.len(), |n| start + n);
    bytes.splice(start..end, word.iter().copied());
}
