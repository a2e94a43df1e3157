//! refraction: the scene behind glass, displaced and blurred.
//!
//! In: `composited`, without the light that is seen displaced, and `bends` and `behinds` of the whole
//! picture, by `shade`'s `composite`. `bloom`'s `down` makes the smaller levels of `behinds`. `apply` ->
//! `radiance`, `pixels`.
use super::kernel;
use gobo::gpu::KernelDesc;

/// Adds the light that is seen displaced through glass.
pub const APPLY: KernelDesc = kernel("refraction_apply", "refraction/refraction.wgsl");
