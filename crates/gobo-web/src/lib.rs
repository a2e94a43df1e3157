//! Scenes in a browser: gobo's shadow maps, and the page's own small renderer. The same code runs natively,
//! where a test compares the pictures.
mod bricks;
mod device;
mod drawing;
mod frame;
mod glass;
mod knobs;
mod looks;
mod passes;
mod picture;
mod show;
mod sprites;
mod triangles;
#[cfg(target_arch = "wasm32")]
mod web;

pub use glass::stained_glass;
pub use knobs::Knobs;
pub use picture::picture;
pub use show::{Show, ShowError};
