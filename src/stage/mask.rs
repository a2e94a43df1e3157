//! mask: per pixel of the picture, the light that each light still sends there.
//!
//! In: what the camera sees, the shadow maps, the lights of its clusters. `surfaces` keeps depths and
//! normals of all bands, `shrink` one of each 2 x 2 pixels, `look_up` asks the maps, `blur` and `enlarge`
//! filter across pixels of one surface. Out: `light_masks`, which `light_points` reads.
use super::{
    levels::{OF_AREA, OF_POINT},
    shade::of_pixels,
};
use crate::gpu::{KernelDesc, Tier};

/// Edge of a workgroup [pixels].
pub const GROUP_SIZE: u32 = 8;

const fn of(name: &'static str, root: &'static str) -> KernelDesc {
    KernelDesc { name, entry: name, root, with: &[], constants: &[], tiers: &[Tier::Core] }
}

pub const SURFACES: KernelDesc = of_pixels("mask_surfaces_of", "mask/mask_surfaces.wgsl");
pub const SHRINK: KernelDesc = of("mask_shrink", "mask/mask_shrink.wgsl");
pub const LOOK_UP: KernelDesc =
    KernelDesc { with: &[OF_POINT], ..of("mask_look_up", "mask/mask_look_up.wgsl") };
/// Where some light has a size.
pub const AREA_LOOK_UP: KernelDesc =
    KernelDesc { name: "area_mask_look_up", with: &[OF_AREA], ..LOOK_UP };
pub const BLUR: KernelDesc = of("mask_blur", "mask/mask_blur.wgsl");
pub const ENLARGE: KernelDesc = of("mask_enlarge", "mask/mask_enlarge.wgsl");
