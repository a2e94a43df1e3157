//! Readers of the maps: light at points, WGSL for shaders of the host, and other layouts.
mod bounce;
mod caustics;
pub(super) mod converted;
pub(super) mod host_shader;
mod level_store;
pub(super) mod levels;
pub(super) mod light_points;
pub(super) mod light_shelf;
pub(crate) mod light_source;
pub(super) mod splat_points;
