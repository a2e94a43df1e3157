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
//! use gobo::{Bounds, Casters, Light, Material, Particle, Receiver, ShadowSettings, Shadows};
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
//! let settings = ShadowSettings { receiver: Receiver::Curve, nodes: 8, ..Default::default() };
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
//! What a texel holds and how a receiver reads it is in `docs/pipeline.md`.
//!
//! # Features
//! - `scene`: scene files, glTF, PLY and CSV (module `scene`).
//! - `picture`: the lit picture of a `Scene` (`Renderer`).
//! - `device`: opens adapters by itself (`Gpu`).
//! - `cli`: the program `gobo`, also as the function `program`; with the others, on by default.
//! - `view`: its window, `gobo view`.
//! - `internals`: the inside, for this repository's tests and program; without a promise.
#![cfg_attr(
    not(all(feature = "internals", feature = "picture")),
    allow(
        dead_code,
        unreachable_pub,
        unused_imports,
        reason = "some of the inside is for tests and the program"
    )
)]
#![cfg_attr(not(feature = "internals"), warn(missing_docs))]
// A browser's wgpu objects stay on their thread.
#![cfg_attr(target_arch = "wasm32", allow(clippy::arc_with_non_send_sync))]

/// Opens a span of `tracing` until the end of the block, at the level of debugging, for a subscriber that times it:
/// `device`, `read`, `generate`, `prepare`, `compile`, `kernels` and `read_back`.
macro_rules! phase {
    ($name:literal) => {
        #[cfg(feature = "device")]
        let _phase = tracing::debug_span!($name).entered();
    };
}

// The program names the library as other crates do.
#[cfg(feature = "cli")]
extern crate self as gobo;

#[cfg(feature = "cli")]
mod cli;
mod frame;
mod gpu;
pub mod model;
#[cfg(feature = "picture")]
mod picture;
mod records;
mod reference;
#[cfg(feature = "picture")]
pub mod render;
#[cfg(feature = "scene")]
pub mod scene;
mod shadows;
mod stage;
mod view;

/// What tests, benches and the program `gobo` use of the inside. Any version may change it.
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod internals {
    #[cfg(feature = "picture")]
    pub mod picture {
        pub use crate::picture::*;
    }
    #[cfg(feature = "cli")]
    pub mod cli {
        pub use crate::cli::Needs;
    }
    pub mod frame {
        pub use crate::frame::*;
    }
    pub mod gpu {
        pub use crate::gpu::*;
    }
    pub mod records {
        pub use crate::records::*;
    }
    pub mod reference {
        pub use crate::reference::*;
    }
    pub mod shadows {
        pub use crate::shadows::*;
    }
    pub mod stage {
        pub use crate::stage::*;
    }
    pub mod view {
        pub use crate::view::*;
    }
}

/// What hosts need beyond the root: devices, receivers in shaders of their own, masks, simulations.
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

#[cfg(feature = "cli")]
pub use cli::program;
pub use glam;
pub use gpu::{
    Gpu, KernelError, KernelJob, KernelTime, Memory, Support, Tier, Timeline, error::Error,
};
pub use model::{
    Bounds, Brick, Camera, Casters, Counters, Gaussian, Grid, Light, LightKind, Material, Particle,
    Receiver, Scene, ShadowSettings, Shape, Strand, StrandVertex, Texture, Transfer, Triangle,
    View,
};
#[cfg(feature = "picture")]
pub use render::{RenderOptions, Renderer};
pub use shadows::{
    CasterCount, CasterLoader, GridLoader, HostCasters, HostDepth, HostGrid, HostInputs, Maps,
    Prepared, Shadows,
};
pub use view::{HeldBounds, atlas::MapSlot, light_views};
pub use wgpu;
