//! CPU reference of `wgsl/sort/sort_*.wgsl`: a stable sort of pairs by some bits of their key.
use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// A texel of a pair texture.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Pair {
    /// By which pairs are sorted.
    pub key: u32,
    /// Index that goes with the key.
    pub value: u32,
}

/// Sorts by `bits` of the keys; pairs that agree in these stay in order.
pub fn sort(pairs: &mut [Pair], bits: Range<u32>) {
    if bits.start >= bits.end.min(32) {
        return;
    }
    let mask = u32::MAX >> (32 - (bits.end.min(32) - bits.start));
    pairs.sort_by_key(|pair| pair.key >> bits.start & mask);
}
