//! refraction: what is behind glass, seen aside and blurred.
//!
//! In: `composited`, without what is seen elsewhere, `bends` and `behinds` of the whole picture, by `shade`'s
//! `composite`. `bloom`'s `down` makes the smaller levels of `behinds`. `apply` -> `radiance`, `pixels`.
use super::kernel;
use gobo::gpu::KernelDesc;

/// Adds what is seen aside through glass.
pub const APPLY: KernelDesc = kernel("refraction_apply", "refraction/refraction_apply.wgsl");
