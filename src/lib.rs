//! Coloured translucent shadows by compute shaders alone.
//!
//! Casters (particles, glass, puffs) filter the light of many lights. Every texel of a shadow map holds the
//! opaque depth, the product of the filters and the nearest translucent depth, and optionally the
//! transmittance as a function of depth. There is no raster pass and no blending hardware.
//!
//! The library is a guest: a host brings device, queue and encoder. [`Shadows::prepare`] uploads
//! what has changed and allocates, [`Prepared::record`] only records, and nothing submits or waits
//! but [`Prepared::counters`]. World space is right-handed with y up, in metres; colours are linear.
//!
#![cfg_attr(feature = "device", doc = "```")]
#![cfg_attr(not(feature = "device"), doc = "```ignore")]
//! use gobo::glam::{Vec3, Vec4};
//! use gobo::{Bounds, Casters, Light, Material, Particle, ShadowSettings, Shadows};
//!
//! # let gpu = gobo::Gpu::headless()?;
//! # let (device, queue, adapter_info) = (&gpu.device, &gpu.queue, &gpu.adapter);
//! // Five panes of smoke above each other, under a lamp.
//! let materials = [Material { tint: Vec4::new(0.6, 0.7, 0.9, 0.4), ..Material::default() }];
//! let particles: Vec<_> = (0..5_u8)
//!     .map(|i| Particle { center: Vec3::Y * f32::from(i), radius: 0.5, ..Particle::default() })
//!     .collect();
//! let casters = Casters { particles: &particles, materials: &materials, ..Casters::default() };
//! let lamp = Light::spot(Vec3::Y * 8.0, Vec3::NEG_Y, 0.6);
//! let bounds = Bounds { min: Vec3::splat(-1.0), max: Vec3::new(1.0, 5.0, 1.0) };
//! let views = gobo::light_views(0, &lamp, 128, None, &bounds)?;
//!
//! let mut shadows = Shadows::new(device, queue, adapter_info)?;
//! let settings = ShadowSettings::default(); // curves of 8 nodes
//! let prepared = shadows.prepare(&casters, &views, &settings)?;
//! let mut encoder = device.create_command_encoder(&Default::default());
//! prepared.record(&mut encoder)?;
//! queue.submit([encoder.finish()]);
//!
//! let counters = prepared.counters()?;
//! assert_eq!(counters.visible, 5);
//! shadows.grow_from(&counters);
//! let maps = prepared.maps(); // textures, and the rectangle of each view in them
//! assert_eq!(maps.nodes, 8);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The contents of a texel, and how a receiver reads them, are in `docs/pipeline.md`.
//!
//! # Features
//! - `device`: opens adapters by itself (`Gpu`).
//! - `webgpu`: runs in browsers, on their WebGPU.
#![warn(missing_docs)]
// A browser's wgpu objects stay on their thread.
#![cfg_attr(target_arch = "wasm32", allow(clippy::arc_with_non_send_sync))]

/// Opens a span of `tracing` until the end of the block, at the level of debugging, for a subscriber that
/// times it: `device`, `generate`, `compile`, `kernels` and `read_back`.
macro_rules! phase {
    ($name:literal) => {
        let _phase = tracing::debug_span!($name).entered();
    };
}

pub mod frame;
pub mod gpu;
pub mod model;
pub mod records;
pub mod shadows;
pub mod stage;
pub mod view;

/// For hosts, beyond the root: devices, receivers in shaders of their own, masks, simulations.
pub mod host {
    pub use crate::{
        gpu::{Backend, Missing, Need, Profiler, Requirement, Selection, error::Input},
        shadows::{
            ConvertedMaps, EMITTED_WGSL, FilterFormat, LightBindings, LightMasks, LightPoints,
            MapLayout, MaskSlot, MaskView, PointBuffers, SPLAT_POINT_WGSL, ShadowFunction,
            Simulation, SplatLight,
        },
    };
}

use gpu::error;

pub use glam;
pub use gpu::{
    Gpu, KernelError, KernelJob, KernelTime, Memory, Support, Tier, Timeline, error::Error,
};
pub use model::{
    Bounds, Brick, Camera, Casters, Counters, CurveMemory, Gaussian, Grid, Light, LightKind,
    Material, Particle, Receiver, Scene, ShadowSettings, Shape, Strand, StrandVertex, Texture,
    Transfer, Triangle, View,
};
pub use shadows::{
    CasterCount, CasterLoader, GridLoader, HostCasters, HostDepth, HostGrid, HostInputs, Maps,
    Prepared, Shadows,
};
pub use view::{HeldBounds, atlas::MapSlot, light_views};
pub use wgpu;
