//! Shadow maps from casters and views.
//!
//! The library is a guest in its host's renderer: [`Shadows::prepare`] uploads and allocates,
//! [`Prepared::record`] only records into the host's encoder; nothing here submits or waits.
mod batch;
mod blur;
mod cache;
mod casters;
mod config;
pub(crate) mod context;
mod converted;
mod count;
pub mod cull;
#[cfg_attr(not(feature = "picture"), allow(dead_code, reason = "only pictures have emitters"))]
mod emitted;
mod filter_mips;
mod groups;
mod host;
mod host_casters;
mod host_depths;
mod host_inputs;
mod host_list;
mod host_prepared;
mod host_shader;
pub(crate) mod kernels;
pub(crate) mod levels;
mod light_points;
mod light_source;
pub(crate) mod list;
mod maps;
pub(crate) mod masks;
mod pair_capacity;
mod parts;
mod pipeline;
pub(crate) mod plan;
mod prepared;
mod read_back;
pub(crate) mod scratch;
mod simulation;
mod small;
mod soften;
mod statistics;
mod warm_up;

pub use casters::{CasterSet, Span};
pub use config::Config;
pub use converted::{ConvertedMaps, FilterFormat, MapLayout};
#[cfg(feature = "picture")]
pub(crate) use emitted::EmittedSlots;
pub use groups::{Extent, Group};
pub use host::Shadows;
#[cfg(feature = "picture")]
pub(crate) use host::check;
pub use host_inputs::{CasterCount, CasterLoader, HostCasters, HostDepth, HostInputs};
pub use host_prepared::Prepared;
pub use host_shader::{LightBindings, look_up_text};
pub(crate) use levels::AreaLevels;
pub use light_points::{LightPoints, PointBuffers};
#[cfg(feature = "picture")]
pub(crate) use light_source::light_texture;
pub use list::ListCounters;
pub use maps::Maps;
pub use masks::{LightMasks, MaskSlot, MaskView, ShadowFunction};
pub use pair_capacity::PairCapacity;
pub use pipeline::Pipeline;
pub use prepared::PreparedMaps;
pub use simulation::{EMITTED_WGSL, Simulation};
pub use small::{SMALL_SIDE, TriangleExtent};
