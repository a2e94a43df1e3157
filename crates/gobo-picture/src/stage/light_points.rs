//! light points: the light that points of the picture send to the eye.
//!
//! In: `points`, their lists, the shadow maps. Out: `lit`. The entry point is that of the library's
//! [`light_points`](gobo::stage::light_points), which answers hosts by it.
use super::kernel;
use gobo::{
    gpu::{Choice, KernelDesc},
    stage::{
        caustics::{STRAIGHT, THROWN},
        features::{Features, Flags},
        levels::{OF_AREA, OF_POINT},
        light_points::{PointBatch, of_points},
    },
};

/// Texels of a point. WGSL: `crates/gobo-picture/wgsl/records/point.wgsl`.
pub const POINT_TEXELS: u32 = 4;
/// Lists of a band's points to light, in a buffer: for each list [`LIST_HEAD`] words, the workgroups of its
/// dispatch and its length; then the points. WGSL: `crates/gobo-picture/wgsl/records/point_list.wgsl`.
pub const SURFACE_LIST: u32 = 0;
/// List of the panes.
pub const PANE_LIST: u32 = 1;
/// Number of lists.
pub const LIST_COUNT: u32 = 2;
/// Words of a list's head.
pub const LIST_HEAD: u32 = 4;

const RADIANCE: Choice = Choice::new("light_output", "shade/point_light.wgsl");
const UNMASKED: Choice = Choice::new("mask", "shade/composite_none.wgsl");
const NO_BOUNCE: Choice = Choice::new("bounced", "shade/composite_none.wgsl");
const BOUNCED: Choice = Choice::new("bounced", "shade/bounced.wgsl");
const MASKED: Choice = Choice::new("mask", "shade/composite_kept.wgsl");

const fn lit(name: &'static str, with: &'static [Choice]) -> KernelDesc {
    let kernel = of_points(kernel("light_points", "shade/light_points.wgsl"));
    KernelDesc { name, with, ..kernel }
}

/// Light at the points that the picture shows.
pub const LIGHT_POINTS: KernelDesc =
    lit("light_points", &[RADIANCE, UNMASKED, OF_POINT, STRAIGHT, NO_BOUNCE]);
/// [`LIGHT_POINTS`] with area lights.
pub const AREA_LIGHT_POINTS: KernelDesc =
    lit("area_light_points", &[RADIANCE, UNMASKED, OF_AREA, STRAIGHT, NO_BOUNCE]);
/// [`LIGHT_POINTS`] with shadow masks.
pub const MASKED_LIGHT_POINTS: KernelDesc =
    lit("masked_light_points", &[RADIANCE, MASKED, OF_POINT, STRAIGHT, NO_BOUNCE]);
/// [`MASKED_LIGHT_POINTS`] with area lights.
pub const AREA_MASKED_LIGHT_POINTS: KernelDesc =
    lit("area_masked_light_points", &[RADIANCE, MASKED, OF_AREA, STRAIGHT, NO_BOUNCE]);
/// [`LIGHT_POINTS`] with light that glass throws.
pub const THROWN_LIGHT_POINTS: KernelDesc =
    lit("thrown_light_points", &[RADIANCE, UNMASKED, OF_POINT, THROWN, BOUNCED]);
/// [`AREA_LIGHT_POINTS`] with light that glass throws.
pub const THROWN_AREA_LIGHT_POINTS: KernelDesc =
    lit("thrown_area_light_points", &[RADIANCE, UNMASKED, OF_AREA, THROWN, BOUNCED]);
/// [`MASKED_LIGHT_POINTS`] with light that glass throws.
pub const THROWN_MASKED_LIGHT_POINTS: KernelDesc =
    lit("thrown_masked_light_points", &[RADIANCE, MASKED, OF_POINT, THROWN, BOUNCED]);
/// [`AREA_MASKED_LIGHT_POINTS`] with light that glass throws.
pub const THROWN_AREA_MASKED_LIGHT_POINTS: KernelDesc =
    lit("thrown_area_masked_light_points", &[RADIANCE, MASKED, OF_AREA, THROWN, BOUNCED]);

/// The kernel that evaluates the light of a picture's points.
pub fn light_points(features: Features) -> &'static KernelDesc {
    let flags = [Flags::HAS_AREAS, Flags::HAS_MASKS, Flags::HAS_CAUSTICS];
    match flags.map(|flag| features.has(flag)) {
        [false, false, false] => &LIGHT_POINTS,
        [false, true, false] => &MASKED_LIGHT_POINTS,
        [true, false, false] => &AREA_LIGHT_POINTS,
        [true, true, false] => &AREA_MASKED_LIGHT_POINTS,
        [false, false, true] => &THROWN_LIGHT_POINTS,
        [false, true, true] => &THROWN_MASKED_LIGHT_POINTS,
        [true, false, true] => &THROWN_AREA_LIGHT_POINTS,
        [true, true, true] => &THROWN_AREA_MASKED_LIGHT_POINTS,
    }
}

/// Points of a list of a band whose capacity is `pixel_count` pixels.
pub fn listed(list: u32, pixel_count: u32) -> PointBatch {
    PointBatch { list, ..PointBatch::of(LIST_COUNT * LIST_HEAD + list * pixel_count, 0) }
}

/// Offset of a list's workgroup counts \[bytes\].
pub const fn list_offset(list: u32) -> u64 {
    4 * (list * LIST_HEAD) as u64
}
