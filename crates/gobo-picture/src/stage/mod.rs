//! The stages of a picture, as kernels. Their files are in the `wgsl/` of this crate, the files they import
//! in the library's.
pub mod air;
pub mod bloom;
pub mod cluster;
pub mod light_points;
pub mod mask;
pub mod occlusion;
pub mod refraction;
pub mod shade;

use gobo::{
    gpu::{KernelDesc, Library, LinkError, Tier},
    stage,
};
use std::sync::LazyLock;

static LIBRARY: LazyLock<Result<Library, LinkError>> =
    LazyLock::new(|| Library::embedded()?.with(include!(concat!(env!("OUT_DIR"), "/wgsl.rs"))));

/// The library's files and those of this crate.
///
/// # Errors
/// The file and line of a fault.
pub fn library() -> Result<&'static Library, LinkError> {
    LIBRARY.as_ref().map_err(Clone::clone)
}

/// A kernel of this crate.
const fn kernel(name: &'static str, root: &'static str) -> KernelDesc {
    KernelDesc { library, ..KernelDesc::new(name, root) }
}

/// Every kernel of pictures.
pub const KERNELS: &[&KernelDesc] = &[
    &mask::SURFACES,
    &mask::HALF_SURFACES,
    &air::REACH,
    &air::SCATTER,
    &air::AREA_SCATTER,
    &air::SUM,
    &cluster::COUNT,
    &cluster::SCAN,
    &cluster::EMIT,
    &shade::CLIP,
    &shade::SEEN,
    &shade::LAYERED,
    &shade::LAYERS,
    &shade::SURFACES,
    &shade::CATCHING_SURFACES,
    &shade::KEEP,
    &shade::PANES,
    &shade::CASTERS,
    &shade::BRICKS,
    &shade::COMPOSITE,
    &shade::COMPOSITE_AMBIENT,
    &shade::COMPOSITE_BEHIND,
    &shade::COMPOSITE_BEHIND_AMBIENT,
    &light_points::LIGHT_POINTS,
    &light_points::AREA_LIGHT_POINTS,
    &light_points::MASKED_LIGHT_POINTS,
    &light_points::AREA_MASKED_LIGHT_POINTS,
    &light_points::THROWN_LIGHT_POINTS,
    &light_points::THROWN_AREA_LIGHT_POINTS,
    &light_points::THROWN_MASKED_LIGHT_POINTS,
    &light_points::THROWN_AREA_MASKED_LIGHT_POINTS,
    &occlusion::SEARCH,
    &occlusion::APPLY,
    &refraction::APPLY,
    &bloom::DOWN,
    &bloom::UP,
    &bloom::APPLY,
];

/// Every kernel of the library and of pictures.
pub fn kernels() -> &'static [&'static KernelDesc] {
    static ALL: LazyLock<Vec<&KernelDesc>> = LazyLock::new(|| [stage::KERNELS, KERNELS].concat());
    &ALL
}

/// Every kernel of the library and of pictures, on each of its tiers, core first.
pub fn variants() -> impl Iterator<Item = (&'static KernelDesc, Tier)> {
    stage::on_tiers(kernels())
}
