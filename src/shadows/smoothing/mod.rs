//! What follows all batches: softening of dithered maps, blur, and smaller levels.
pub(super) mod blur;
pub(super) mod filter_mips;
pub(super) mod soften;
