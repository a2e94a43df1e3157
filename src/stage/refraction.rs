//! refraction: what is behind glass, seen aside and blurred.
//!
//! In: `composited`, without what is seen elsewhere, `bends` and `behinds` of the whole picture, by `shade`'s
//! `composite`. `bloom`'s `down` makes the smaller levels of `behinds`. `apply` -> `radiance`, `pixels`.
use crate::gpu::{KernelDesc, Tier};

pub const APPLY: KernelDesc = KernelDesc {
    name: "refraction_apply",
    entry: "refraction_apply",
    root: "refraction/refraction_apply.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};
