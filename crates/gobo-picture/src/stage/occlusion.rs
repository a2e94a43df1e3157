//! occlusion: ambient light that the visible surfaces around a surface keep from it.
//!
//! In: `composited` and `ambients` of the whole picture, by `shade`'s `composite`. `search` -> `occlusions`:
//! at half the size, the share of the ambient light that arrives. `apply` -> `radiance`, `pixels`.
use super::kernel;
use gobo::gpu::KernelDesc;

/// Share of the ambient light that arrives, at half the size.
pub const SEARCH: KernelDesc = kernel("occlusion_search", "occlusion/occlusion.wgsl");
/// Takes the occluded share of the ambient light away.
pub const APPLY: KernelDesc = kernel("occlusion_apply", "occlusion/occlusion_apply.wgsl");
