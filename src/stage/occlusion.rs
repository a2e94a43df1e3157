//! occlusion: ambient light that what is seen around a surface keeps from it.
//!
//! In: `composited` and `ambients` of the whole picture, by `shade`'s `composite`. `search` -> `occlusions`: at half the
//! size, the share of the ambient light that arrives. `apply` -> `radiance`, `pixels`.
use crate::gpu::{KernelDesc, Tier};

const fn of(name: &'static str, root: &'static str) -> KernelDesc {
    KernelDesc { name, entry: name, root, with: &[], constants: &[], tiers: &[Tier::Core] }
}

pub const SEARCH: KernelDesc = of("occlusion_search", "occlusion/occlusion_search.wgsl");
pub const APPLY: KernelDesc = of("occlusion_apply", "occlusion/occlusion_apply.wgsl");
