//! Coloured translucent shadows by compute shaders alone.
//!
//! Casters (particles, glass, puffs) filter the light of many lights. Every shadow texel knows the
//! opaque depth, the product of the filters and the nearest translucent depth. The pipeline is a
//! list of stages; each is a kernel in `wgsl/`, its host side in [`stage`] and its plain twin in
//! [`cpu`].
pub mod atlas;
pub mod caster;
pub mod counters;
pub mod cpu;
pub mod cull;
pub mod debug;
pub mod dither;
pub mod error;
pub mod footprint;
pub mod frame;
pub mod gpu;
pub mod light;
pub mod owner;
pub mod pipeline;
pub mod render;
pub mod scene;
pub mod settings;
pub mod stage;
pub mod view;
pub mod volume;

pub use glam;
pub use wgpu;
