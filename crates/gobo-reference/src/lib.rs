//! Reference implementation: a plain CPU reference of each stage.
#![warn(missing_docs)]

pub mod accumulate;
pub mod air;
mod area;
pub mod bin;
pub mod bloom;
pub mod blur;
pub mod bounce;
pub mod brick;
pub mod brick_light;
pub mod capsule;
pub mod caster_hit;
pub mod caustics;
pub mod cluster;
pub mod coplanar;
pub mod curve;
pub mod dither;
mod effort;
pub mod fresnel;
pub mod gaussian;
mod glass_face;
pub mod hit;
pub mod import;
mod kinds;
mod light_points;
mod light_views;
pub mod maps;
pub mod mask;
pub mod occlude;
pub mod occlusion;
pub mod order;
pub mod outline;
pub mod project;
mod puff;
pub mod receive;
pub mod records;
pub mod refraction;
pub mod resolve;
mod shade;
pub mod shading;
pub mod soften;
mod sort;
pub mod sums;
pub mod texture;
mod threads;
pub mod tile;

pub use area::Fit;
pub use effort::Effort;
pub use light_points::light_points;
pub use maps::render_maps;
pub use mask::Masks;
pub use receive::{MapTexel, light_by_channel, receive, receive_curve};
pub use shade::{
    FAINT, MeanPicture, Surface, picture_masks, render_picture, render_samples, surfaces,
};
pub use sort::{Pair, sort};
pub use sums::add_sums;
