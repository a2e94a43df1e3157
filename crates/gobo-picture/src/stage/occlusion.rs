//! occlusion: ambient light that what is seen around a surface keeps from it.
//!
//! In: `composited` and `ambients` of the whole picture, by `shade`'s `composite`. `search` -> `occlusions`: at half the
//! size, the share of the ambient light that arrives. `apply` -> `radiance`, `pixels`.
use super::kernel;
use gobo::gpu::KernelDesc;

pub const SEARCH: KernelDesc = kernel("occlusion_search", "occlusion/occlusion_search.wgsl");
pub const APPLY: KernelDesc = kernel("occlusion_apply", "occlusion/occlusion_apply.wgsl");
