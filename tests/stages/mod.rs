//! Tests of single stages.
mod bin;
mod blur;
mod cluster;
mod cull;
mod cull_bound;
mod dither;
mod filter;
mod host_shader;
mod light_points;
mod look_up;
mod occlude;
mod project;
mod soft;
mod soften_curves;
mod sort;
