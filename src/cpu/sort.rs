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

const RADIX_BITS: u32 = 8;
const RADIX: usize = 1 << RADIX_BITS;

/// Least significant digit first, all digits counted in one go; a digit that all keys share is
/// skipped.
pub fn sort(pairs: &mut Vec<Pair>, bits: Range<u32>) {
    let shifts: Vec<u32> = bits.clone().step_by(RADIX_BITS as usize).collect();
    let digit_of = |pair: &Pair, shift: u32| {
        let width = RADIX_BITS.min(bits.end - shift);
        // `shift` may be 32 or more only where `bits` holds no bit of a key.
        pair.key.checked_shr(shift).unwrap_or(0) as usize & ((1 << width) - 1)
    };
    let mut histograms = vec![[0_u32; RADIX]; shifts.len()];
    for pair in &*pairs {
        for (histogram, &shift) in histograms.iter_mut().zip(&shifts) {
            histogram[digit_of(pair, shift)] += 1;
        }
    }
    let mut sorted = vec![Pair::zeroed(); pairs.len()];
    for (histogram, shift) in histograms.iter_mut().zip(shifts) {
        if histogram.iter().any(|&count| count as usize == pairs.len()) {
            continue;
        }
        let mut place = 0;
        for count in histogram.iter_mut() {
            place += std::mem::replace(count, place);
        }
        for pair in &*pairs {
            let place = &mut histogram[digit_of(pair, shift)];
            sorted[*place as usize] = *pair;
            *place += 1;
        }
        std::mem::swap(pairs, &mut sorted);
    }
}
