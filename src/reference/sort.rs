//! Twin of `wgsl/sort_*.wgsl`: a stable sort of pairs by some bits of their key.
use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// A texel of a pair texture.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Pair {
    pub key: u32,
    pub value: u32,
}

const DIGIT_BITS: u32 = 8;
/// Of a whole key.
const DIGIT_COUNT: usize = 4;

/// Least significant digit first. All digits are counted in one go, and a digit that all keys share
/// is skipped. `scratch` is grown to the length of `pairs`; its content is lost.
pub fn sort(pairs: &mut Vec<Pair>, scratch: &mut Vec<Pair>, bits: Range<u32>) {
    if bits.start >= bits.end.min(32) {
        return;
    }
    // The bits in question, moved to the bottom.
    let mask = u32::MAX >> (32 - (bits.end.min(32) - bits.start));
    let digit_of =
        |pair: Pair, digit: usize| (pair.key >> bits.start & mask).to_le_bytes()[digit] as usize;
    let mut histograms = [[0_u32; 1 << DIGIT_BITS]; DIGIT_COUNT];
    for &pair in &*pairs {
        for (digit, histogram) in histograms.iter_mut().enumerate() {
            histogram[digit_of(pair, digit)] += 1;
        }
    }
    scratch.resize(pairs.len(), Pair::default());
    for (digit, histogram) in histograms.iter_mut().enumerate() {
        if histogram.iter().any(|&count| count as usize == pairs.len()) {
            continue;
        }
        let mut place = 0;
        for count in histogram.iter_mut() {
            place += std::mem::replace(count, place);
        }
        for &pair in &*pairs {
            let place = &mut histogram[digit_of(pair, digit)];
            scratch[*place as usize] = pair;
            *place += 1;
        }
        std::mem::swap(pairs, scratch);
    }
}
