//! mask: the visible surfaces of a picture, from which the masks of [`mask`](gobo::stage::mask) are made.
use super::shade::of_pixels;
use gobo::{
    gpu::KernelDesc,
    stage::mask::{KEEP_HALF, KEEP_WHOLE},
};

/// Visible surfaces, for masks of the picture's size.
pub const SURFACES: KernelDesc =
    KernelDesc { with: &[KEEP_WHOLE], ..of_pixels("mask_surfaces_of", "mask/mask_surfaces.wgsl") };
/// Visible surfaces, for masks of half the picture's size.
pub const HALF_SURFACES: KernelDesc =
    KernelDesc { name: "half_mask_surfaces_of", with: &[KEEP_HALF], ..SURFACES };
/// The kernel that stores the visible surfaces of a picture; `half`: for masks of half its size.
pub fn surfaces(half: bool) -> &'static KernelDesc {
    if half { &HALF_SURFACES } else { &SURFACES }
}
