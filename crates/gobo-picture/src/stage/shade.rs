//! shade: the lit picture, a band of tiles at a time.
//!
//! In: the camera's lists, the shadow maps. Out: `pixels`. `seen` and `layers` walk the lists; `surfaces`,
//! `panes` and `casters` write their hits as `points`; [`light_points`](gobo::stage::light_points) evaluates
//! the light that these send to the eye; `composite` blends it.
use super::kernel;
use glam::UVec2;
use gobo::{
    gpu::{Choice, Constant, KernelDesc, Tier},
    stage::{
        light_points::{POINT_LANES, of_points},
        walk::{IN_ORDER, LANE_CASTER, WALK},
    },
};

/// Texels of a pixel's list of layers. WGSL: `crates/gobo-picture/wgsl/shade/layer.wgsl`.
pub const LAYER_TEXELS: u32 = 5;
/// Records of 16 bytes that a pixel carries from round to round. WGSL:
/// `crates/gobo-picture/wgsl/shade/shade_layers.wgsl`.
pub const CARRIED: u32 = 6;
/// Points of a pixel: the opaque surface, and two panes.
pub const PIXEL_POINTS: u32 = 3;
/// Workgroups of a list's dispatch in y, so that x stays below what devices allow.
pub const LIST_ROWS: u32 = 2;
/// Words of `layered_tiles` before the tiles: the workgroups of a dispatch over them. WGSL:
/// `crates/gobo-picture/wgsl/shade/layer.wgsl`.
pub const LAYERED_HEAD: u32 = 3;
/// Tiles of a band.
pub const BAND_TILES: u32 = 256;

/// The camera sees images filtered. WGSL: `wgsl/hit/triangle.wgsl`.
const FILTERS_IMAGES: Constant = ("FILTERS_IMAGES", 1.0);

/// Translucent layers in front of a pixel's opaque surface.
const LAYER_STATE: Choice = Choice::new("accumulator", "accumulator/layers.wgsl");
/// Nearest opaque caster of a pixel.
const SEEN_STATE: Choice = Choice::new("accumulator", "accumulator/seen.wgsl");

const AMBIENT_NONE: Choice = Choice::new("ambient", "shade/composite_none.wgsl");
const AMBIENT_KEPT: Choice = Choice::new("ambient", "shade/composite_kept.wgsl");
const STRAIGHT: Choice = Choice::new("refraction", "shade/composite_none.wgsl");
const REFRACTED: Choice = Choice::new("refraction", "shade/composite_kept.wgsl");
const NO_CATCHERS: Choice = Choice::new("catcher", "shade/composite_none.wgsl");
const CATCHERS: Choice = Choice::new("catcher", "shade/composite_kept.wgsl");

/// The opaque surface of each pixel.
pub const SEEN: KernelDesc = KernelDesc {
    with: &[IN_ORDER, SEEN_STATE, WALK, LANE_CASTER],
    constants: &[FILTERS_IMAGES],
    tiers: Tier::BY_SUBGROUPS,
    ..kernel("shade_seen", "shade/shade_seen.wgsl")
};

/// Translucent layers in front of each pixel's surface.
pub const LAYERS: KernelDesc = KernelDesc {
    with: &[IN_ORDER, LAYER_STATE, WALK, LANE_CASTER],
    constants: &[("SHADES_BRICKS", 1.0), FILTERS_IMAGES],
    tiers: Tier::BY_SUBGROUPS,
    ..kernel("shade_layers", "shade/shade_layers.wgsl")
};

/// A kernel over the pixels of a band, one invocation per pixel.
pub(super) const fn of_pixels(name: &'static str, root: &'static str) -> KernelDesc {
    KernelDesc { shared: &[IN_ORDER, SEEN_STATE], ..kernel(name, root) }
}

/// Points of opaque surfaces.
pub const SURFACES: KernelDesc =
    KernelDesc { with: &[NO_CATCHERS], ..of_pixels("shade_surfaces", "shade/shade_surfaces.wgsl") };
/// [`SURFACES`], some of which show the surroundings behind them.
pub const CATCHING_SURFACES: KernelDesc =
    KernelDesc { name: "shade_catching_surfaces", with: &[CATCHERS], ..SURFACES };
/// The kernel that makes points of visible opaque surfaces; `catches`: whether some are catchers.
pub fn surfaces(catches: bool) -> &'static KernelDesc {
    if catches { &CATCHING_SURFACES } else { &SURFACES }
}

/// Blends the picture.
pub const COMPOSITE: KernelDesc = KernelDesc {
    with: &[AMBIENT_NONE, STRAIGHT],
    ..of_pixels("shade_composite", "shade/shade_composite.wgsl")
};
/// [`COMPOSITE`], which keeps the ambient light for [`occlusion`](super::occlusion).
pub const COMPOSITE_AMBIENT: KernelDesc =
    KernelDesc { name: "shade_composite_ambient", with: &[AMBIENT_KEPT, STRAIGHT], ..COMPOSITE };
/// [`COMPOSITE`], which keeps the light behind glass for [`refraction`](super::refraction).
pub const COMPOSITE_BEHIND: KernelDesc =
    KernelDesc { name: "shade_composite_behind", with: &[AMBIENT_NONE, REFRACTED], ..COMPOSITE };
/// [`COMPOSITE`], which keeps both.
pub const COMPOSITE_BEHIND_AMBIENT: KernelDesc = KernelDesc {
    name: "shade_composite_behind_ambient",
    with: &[AMBIENT_KEPT, REFRACTED],
    ..COMPOSITE
};
/// The kernel that blends a picture, and keeps ambient light for [`occlusion`](super::occlusion) and light
/// behind glass for [`refraction`](super::refraction) where asked.
pub fn composite(keeps_ambient: bool, keeps_behind: bool) -> &'static KernelDesc {
    match [keeps_ambient, keeps_behind] {
        [false, false] => &COMPOSITE,
        [true, false] => &COMPOSITE_AMBIENT,
        [false, true] => &COMPOSITE_BEHIND,
        [true, true] => &COMPOSITE_BEHIND_AMBIENT,
    }
}

/// Keeps the light of surfaces for pictures through further samples of the pixels.
pub const KEEP: KernelDesc = of_pixels("shade_keep", "shade/shade_keep.wgsl");

/// Points of the two nearest panes.
pub const PANES: KernelDesc = KernelDesc {
    constants: &[("WORKGROUP_SIZE", POINT_LANES as f64), FILTERS_IMAGES],
    ..of_points(kernel("shade_panes", "shade/shade_panes.wgsl"))
};
/// One invocation per tile of a band.
pub const LAYERED: KernelDesc = of_points(kernel("shade_layered", "shade/layer.wgsl"));
/// Points of particles and Gaussians.
pub const CASTERS: KernelDesc = of_points(kernel("shade_casters", "shade/shade_casters.wgsl"));
/// Points of the lattices in bricks of voxels.
pub const BRICKS: KernelDesc = of_points(kernel("shade_bricks", "shade/shade_casters.wgsl"));

/// Tiles of each footprint that are in a part of the picture.
pub const CLIP: KernelDesc = of_points(kernel("shade_clip", "shade/shade_clip.wgsl"));

gobo::gpu_struct! {
    /// WGSL: `crates/gobo-picture/wgsl/shade/band.wgsl`.
    #[derive(Eq)]
    pub struct Band {
        /// First tile in the picture \[tiles\].
        pub origin: UVec2,
        /// Size of the band \[tiles\].
        pub size: UVec2,
        /// Rounds in which its tiles were walked before.
        pub round: u32,
        /// Pixel capacity of a band.
        pub pixel_count: u32,
    }
}
