//! Coloured translucent shadows by compute shaders alone.
//!
//! Casters (particles, glass, puffs) filter the light of many lights. Every shadow texel knows the
//! opaque depth, the product of the filters and the nearest translucent depth. The pipeline is a
//! list of stages; each is a kernel in `wgsl/`, its host side in [`stage`] and its plain twin in
//! [`reference`].
pub mod error;
pub mod gpu;
pub mod model;
#[cfg(feature = "picture")]
pub mod picture;
pub mod records;
pub mod reference;
#[cfg(feature = "picture")]
pub mod render;
#[cfg(feature = "scene")]
pub mod scene;
pub mod shadows;
pub mod stage;
pub mod view;

pub use glam;
pub use wgpu;
