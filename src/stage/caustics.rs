//! caustics: light that glass and lit surfaces throw, after the maps.
//!
//! In: the maps of a light, and the faces of glass. `depths` and `owners` find the nearest faces through
//! which light enters and leaves bodies, texel by texel; `throw` refracts the rays of each texel and adds
//! their light where they land. Out: `caustics`.
//!
//! In: the maps, and opaque faces. `solid depths` and `solid owners` find the nearest of these at points of a
//! map; `bounce` makes each a source of the light that arrives there. Out: `bounces`.
use crate::gpu::{Choice, Constant, KernelDesc};

/// Workgroup size of kernels over faces.
pub const FACE_LANES: u32 = 64;
/// Workgroup size of the kernel over texels.
pub const TEXEL_LANES: u32 = 64;

const OF_FACES: KernelDesc = KernelDesc::new("glass_faces", "caustics/glass_faces.wgsl");
const LANES: Constant = ("WORKGROUP_SIZE", FACE_LANES as f64);
const DEPTH: Constant = ("FINDS_OWNERS", 0.0);
const OWNER: Constant = ("FINDS_OWNERS", 1.0);
// Kernels of any light ask its first view.
const ASKS_VIEWS: Constant = ("KNOWS_VIEWS", 0.0);
const KNOWS_VIEWS: Constant = ("KNOWS_VIEWS", 1.0);
const OF_ONE: Constant = ("OF_CUBE", 0.0);
const OF_CUBE: Constant = ("OF_CUBE", 1.0);
const TEXEL_WORKGROUP: Constant = ("WORKGROUP_SIZE", TEXEL_LANES as f64);
const GLASS: Constant = ("ARE_SOLID", 0.0);
const SOLID: Constant = ("ARE_SOLID", 1.0);

/// Depths of the nearest faces.
pub const DEPTHS: KernelDesc = KernelDesc {
    name: "glass_depths",
    constants: &[LANES, ASKS_VIEWS, OF_ONE, DEPTH, GLASS],
    ..OF_FACES
};
/// Indices of these faces.
pub const OWNERS: KernelDesc = KernelDesc {
    name: "glass_owners",
    constants: &[LANES, ASKS_VIEWS, OF_ONE, OWNER, GLASS],
    ..OF_FACES
};
const OF_TEXELS: KernelDesc = KernelDesc::new("throw_light", "caustics/throw_light.wgsl");
/// Adds the light where it lands, of a light with one view.
pub const THROW: KernelDesc =
    KernelDesc { constants: &[TEXEL_WORKGROUP, KNOWS_VIEWS, OF_ONE], ..OF_TEXELS };
/// Adds the light where it lands, of a light with the views of a cube.
pub const THROW_IN_CUBE: KernelDesc = KernelDesc {
    name: "throw_cube_light",
    constants: &[TEXEL_WORKGROUP, KNOWS_VIEWS, OF_CUBE],
    ..OF_TEXELS
};

/// Depths of the nearest solid faces.
pub const SOLID_DEPTHS: KernelDesc = KernelDesc {
    name: "solid_depths",
    constants: &[LANES, ASKS_VIEWS, OF_ONE, DEPTH, SOLID],
    ..OF_FACES
};
/// Indices of these faces.
pub const SOLID_OWNERS: KernelDesc = KernelDesc {
    name: "solid_owners",
    constants: &[LANES, ASKS_VIEWS, OF_ONE, OWNER, SOLID],
    ..OF_FACES
};
/// Makes points of a map send on the light that arrives there.
pub const BOUNCE: KernelDesc = KernelDesc {
    constants: &[TEXEL_WORKGROUP, ASKS_VIEWS, OF_ONE],
    ..KernelDesc::new("bounce_light", "caustics/bounce_light.wgsl")
};

/// Look-up without thrown light.
pub const STRAIGHT: Choice = Choice::new("thrown", "shade/none.wgsl");
/// Look-up of light that glass throws.
pub const THROWN: Choice = Choice::new("thrown", "shade/thrown.wgsl");

crate::records::gpu_struct! {
    /// WGSL: `wgsl/records/glass.wgsl`.
    #[derive(Eq)]
    pub struct CausticParams {
        /// First texel of the shadow's maps among those of `caustics`.
        pub first: u32,
        /// First texel of the view's map among those of its shadow.
        pub base: u32,
        /// Index of the view among those of its shadow.
        pub number: u32,
        pub face_count: u32,
        /// Rays along the edge of a texel.
        pub rays: u32,
        /// Workgroups that share a large face.
        pub slices: u32,
    }
}
