//! The integer hash of kernels and their CPU references. WGSL: `wgsl/hit/hash.wgsl`.

/// Integer hash (Jarzynski and Olano 2020, pcg).
#[inline]
pub fn pcg(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}
