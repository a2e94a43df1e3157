//! The reference: each stage again, plainly, on the CPU.
pub mod accumulate;
pub mod air;
pub mod bin;
pub mod caster_hit;
pub mod cluster;
pub mod colored;
pub mod curve;
pub mod dither;
pub mod filter;
pub mod hit;
pub mod maps;
pub mod occlude;
pub mod project;
pub mod receive;
pub mod resolve;
mod shade;
pub mod shading;
mod sort;
pub mod texture;
mod threads;
pub mod tile;

pub use maps::render_maps;
pub use receive::{MapTexel, light_by_channel, receive, receive_curve};
pub use shade::{FAINT, render_picture};
pub use sort::{Pair, sort};
