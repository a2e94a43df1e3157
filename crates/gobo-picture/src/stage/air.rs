//! air: single scattering towards the eye through the shadow maps: shafts of light, coloured behind
//! coloured glass and white in front of it.
//!
//! In: the shadow maps. `scatter` -> `sources`: light that each slice of a column of 4x4 pixels scatters to
//! the eye. `sum` -> `air`: its sum from the eye on, and the transmittance up to there. Surfaces and layers
//! read it at their own depth (`shade`).
use super::kernel;
use gobo::{
    gpu::KernelDesc,
    stage::{
        features::{Features, Flags},
        levels::{IN_REGISTERS, IN_WORKGROUP, OF_AREA, OF_POINT},
    },
};

/// Edge of a workgroup \[columns\].
pub const GROUP_SIZE: u32 = 8;

/// Light that each slice of a column scatters to the eye.
pub const SCATTER: KernelDesc = KernelDesc {
    with: &[OF_POINT, IN_REGISTERS],
    ..kernel("air_scatter", "shade/air_scatter.wgsl")
};

/// [`SCATTER`] with area lights.
pub const AREA_SCATTER: KernelDesc =
    KernelDesc { name: "area_air_scatter", with: &[OF_AREA, IN_WORKGROUP], ..SCATTER };

/// The kernel that scatters the light of a scene.
pub fn scatter(features: Features) -> &'static KernelDesc {
    if features.has(Flags::HAS_AREAS) { &AREA_SCATTER } else { &SCATTER }
}

/// Its sum from the eye on.
pub const SUM: KernelDesc = kernel("air_sum", "shade/air_sum.wgsl");
