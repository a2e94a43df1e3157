//! mask: the share of each light that reaches each pixel of the picture.
//!
//! In: visible surfaces (a picture's come from `gobo-picture`), the shadow maps, the lights of the camera's
//! clusters. `surfaces` keeps depths and normals; for masks of half the size, also one of each 2 x 2 pixels.
//! `look_up` reads the maps, `blur` and `enlarge` filter across the pixels of one surface. Out:
//! `light_masks`, which `light_points` reads.
use super::{
    features::{Features, Flags},
    levels::{OF_AREA, OF_POINT},
};
use crate::gpu::{Choice, KernelDesc};

/// Edge of a workgroup \[pixels\].
pub const GROUP_SIZE: u32 = 8;

/// Number of masks that one invocation computes, of `count`.
pub fn masks_at_once(count: u32) -> u32 {
    count.next_power_of_two().min(4)
}

/// Surfaces of all pixels.
pub const KEEP_WHOLE: Choice = Choice::new("keep", "mask/keep_whole.wgsl");
/// Surfaces of all pixels, and one of each 2 x 2.
pub const KEEP_HALF: Choice = Choice::new("keep", "mask/keep_half.wgsl");

/// Surfaces of a host's depths, for masks of the picture's size.
pub const HOST_SURFACES: KernelDesc = KernelDesc {
    with: &[KEEP_WHOLE],
    ..KernelDesc::new("mask_host_surfaces", "mask/mask_host_surfaces.wgsl")
};
/// Surfaces of a host's depths, for masks of half the picture's size.
pub const HALF_HOST_SURFACES: KernelDesc =
    KernelDesc { name: "half_mask_host_surfaces", with: &[KEEP_HALF], ..HOST_SURFACES };

/// Name of the import that a host's shadow function implements.
pub const JOINED: &str = "joined";
const NOT_JOINED: Choice = Choice::new(JOINED, "shade/none.wgsl");

/// Reads the maps.
pub const LOOK_UP: KernelDesc = KernelDesc {
    with: &[OF_POINT, NOT_JOINED],
    ..KernelDesc::new("mask_look_up", "mask/mask_look_up.wgsl")
};
/// [`LOOK_UP`] with area lights.
pub const AREA_LOOK_UP: KernelDesc =
    KernelDesc { name: "area_mask_look_up", with: &[OF_AREA, NOT_JOINED], ..LOOK_UP };
/// The kernel that looks up masks.
pub fn look_up(features: Features) -> &'static KernelDesc {
    if features.has(Flags::HAS_AREAS) { &AREA_LOOK_UP } else { &LOOK_UP }
}

/// Filters across the pixels of a surface.
pub const BLUR: KernelDesc = KernelDesc::new("mask_blur", "mask/mask_filters.wgsl");
/// Makes masks of the picture's size from masks of half its size.
pub const ENLARGE: KernelDesc = KernelDesc::new("mask_enlarge", "mask/mask_filters.wgsl");
