//! Shadow maps from casters and views.
//!
//! The library is a guest in its host's renderer: [`Shadows::prepare`] uploads and allocates, and makes the
//! commands of a frame; [`Prepared::record`] only records them; nothing here submits or waits.
//!
//! `cull` and `casters` hold casters, `views` the maps they are rendered into. `batch` makes the commands
//! from casters to maps, `smoothing` those after all batches, `look_ups` and `masks` those that read the
//! maps. `prepare` puts a frame together, `shadows` and `prepared` are the host's handles.
pub mod batch;
mod caster_loader;
mod casters;
mod config;
mod count;
pub mod cull;
mod emitted;
mod frame_mark;
mod host_grids;
mod host_inputs;
mod look_ups;
pub mod masks;
mod pair_capacity;
mod prepare;
mod prepared;
#[expect(clippy::module_inception, reason = "it declares `Shadows`")]
mod shadows;
mod simulation;
mod smoothing;
mod statistics;
mod thrown;
mod views;
mod warm_up;

pub use batch::list::ListCounters;
pub use casters::EmittedSlots;
pub use casters::{
    CasterSet, SMALL_SIDE, Span, TriangleExtent,
    group::{Extent, Group},
};
pub use config::{Config, Toggles};
pub use host_grids::{GridLoader, HostGrid};
pub use host_inputs::{CasterCount, CasterLoader, HostCasters, HostDepth, HostInputs};
pub use look_ups::levels::AreaLevels;
use look_ups::light_shelf::LightShelf;
pub use look_ups::light_source::light_texture;
pub use look_ups::{
    converted::{ConvertedMaps, FilterFormat, MapLayout},
    host_shader::{LightBindings, look_up_text},
    light_points::{LightPoints, PointBuffers},
    splat_points::{SPLAT_POINT_WGSL, SplatLight},
};
pub use masks::{LightMasks, MaskSlot, MaskView, ShadowFunction};
pub use pair_capacity::PairCapacity;
pub use pair_capacity::roomy;
pub use prepared::Prepared;
pub use shadows::Shadows;
pub use shadows::check;
pub use simulation::{EMITTED_WGSL, Simulation};
pub use thrown::Caustics;
pub use views::maps::Maps;
