//! Parameters of the air for kernels.
use glam::{UVec2, Vec3};
use gobo::model::{Air, MAX_SAMPLES};

/// Edge of a column \[pixels\]. WGSL: `crates/gobo-picture/wgsl/records/picture.wgsl`.
pub const AIR_CELL: u32 = 4;

gobo::gpu_struct! {
    /// WGSL: `crates/gobo-picture/wgsl/records/picture.wgsl`.
    pub struct AirParams {
        /// Scattering coefficient [1/m].
        pub scattering: Vec3,
        pub anisotropy: f32,
        /// Extinction coefficient [1/m].
        pub extinction: Vec3,
        pub slices: u32,
        /// Ambient radiance that the air scatters: the scene's times the air's share.
        pub ambient: Vec3,
        /// Pictures, one through each sample of the pixels, which share the samples in a slice.
        pub pictures: u32,
    }
}

impl AirParams {
    /// `ambient`: the scene's ambient radiance; `pictures`: one through each sample of the pixels.
    pub fn new(air: &Air, ambient: Vec3, pictures: u32) -> Self {
        Self {
            scattering: air.scattering,
            anisotropy: air.anisotropy,
            extinction: air.extinction,
            slices: air.steps,
            ambient: ambient * air.ambient,
            pictures: pictures.clamp(1, MAX_SAMPLES),
        }
    }
}

/// Columns of air in a picture.
pub fn air_columns(size: UVec2) -> UVec2 {
    (size + AIR_CELL - 1) / AIR_CELL
}
