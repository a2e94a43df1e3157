//! caustics: light that glass throws, after the maps.
//!
//! In: the maps of a light, and the faces of glass. `depths` and `owners` find the nearest faces through
//! which light enters and leaves bodies, texel by texel; `throw` refracts the rays of each texel and adds
//! their light where they land. Out: `caustics`.
use crate::gpu::{Choice, Constant, KernelDesc};

/// Workgroup size of kernels over the texels of faces.
pub const FACE_LANES: u32 = 256;
/// Workgroup size of the kernel over texels.
pub const TEXEL_LANES: u32 = 64;

const OF_FACES: KernelDesc = KernelDesc::new("glass_faces", "caustics/glass.wgsl");
const LANES: Constant = ("WORKGROUP_SIZE", FACE_LANES as f64);

/// Depths of the nearest faces.
pub const DEPTHS: KernelDesc =
    KernelDesc { name: "glass_depths", constants: &[LANES, ("FINDS_OWNERS", 0.0)], ..OF_FACES };
/// Indices of these faces.
pub const OWNERS: KernelDesc =
    KernelDesc { name: "glass_owners", constants: &[LANES, ("FINDS_OWNERS", 1.0)], ..OF_FACES };
/// Adds the light where it lands.
pub const THROW: KernelDesc = KernelDesc {
    constants: &[("WORKGROUP_SIZE", TEXEL_LANES as f64)],
    ..KernelDesc::new("throw_light", "caustics/throw_light.wgsl")
};

/// Look-up without thrown light.
pub const STRAIGHT: Choice = Choice::new("thrown", "shade/none.wgsl");
/// Look-up of light that glass throws.
pub const THROWN: Choice = Choice::new("thrown", "shade/read.wgsl");

crate::records::gpu_struct! {
    /// WGSL: `wgsl/caustics/glass.wgsl`.
    #[derive(Eq)]
    pub struct CausticParams {
        /// First texel of the view's map among those of `caustics`.
        pub first: u32,
        pub face_count: u32,
        /// Rays along the edge of a texel.
        pub rays: u32,
        /// Workgroups of a face.
        pub slices: u32,
    }
}
