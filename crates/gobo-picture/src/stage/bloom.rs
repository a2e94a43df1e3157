//! bloom: a share of the picture's light spreads around, as in a lens.
//!
//! In: `composited`. `down` makes levels, each half as large; `up` adds to each its share of the coarser
//! ones; `apply` -> `radiance`, `pixels`.
use super::kernel;
use gobo::gpu::KernelDesc;

/// Edge of a workgroup of passes over the whole picture \[texels\].
pub const GROUP_SIZE: u32 = 8;

/// The next smaller level.
pub const DOWN: KernelDesc = kernel("bloom_down", "bloom/bloom.wgsl");
/// Adds the share of the next smaller level.
pub const UP: KernelDesc = kernel("bloom_up", "bloom/bloom.wgsl");
/// Adds the light of the levels to the picture.
pub const APPLY: KernelDesc = kernel("bloom_apply", "bloom/bloom.wgsl");
