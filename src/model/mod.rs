//! Inputs of a host: casters, lights, cameras and settings. Nothing here depends on a GPU.
mod area;
pub mod black_body;
mod bounds;
mod camera;
mod caster;
mod class;
mod clip;
mod counters;
mod course;
pub mod dither;
pub mod emission;
pub mod emitter;
mod environment;
pub mod fluid;
mod fresnel;
mod gaussian;
mod grid;
mod hash;
mod image_sun;
mod light;
mod look;
mod look_up;
mod mask;
mod point;
mod scene;
mod settings;
mod strand;
mod vertex_color;
mod view;
pub mod volume;

pub use area::{MAX_SOURCE_SIZE, MAX_SUN_ANGLE, MAX_VIEWPOINTS, Source};
pub use black_body::black_body;
pub use bounds::Bounds;
pub use bounds::FARTHEST;
pub use camera::{Camera, InvalidCamera};
pub(crate) use caster::FAINTEST;
pub use caster::{
    Casters, MAX_GAIN, Material, Particle, Profile, Receives, Shape, Texture, Transfer, Triangle,
};
pub use class::Class;
pub(crate) use class::{CLASSES, by_class};
pub use clip::InvalidClip;
pub use counters::{Counters, Skipped};
pub use course::Course;
pub(crate) use course::{Moment, WindowsKey};
pub use dither::Pattern;
pub use environment::{
    Environment, IRRADIANCE, LEVELS, ROUGH_SIZE, Sky, SunDisc, irradiance_at, octahedral,
};
pub use fresnel::Fresnel;
pub use gaussian::{Gaussian, GaussianOpacity, reach_squared};
pub use grid::{
    BRICK_EDGE, BRICK_SIZE, BRICK_VALUES, Brick, Density, Grid, MAX_BRICK_SIZE, MAX_INDEX, Voxels,
};
pub use hash::pcg;
pub use image_sun::ImageSun;
pub use light::{
    Cascades, InvalidLight, Light, LightKind, MAX_BOUNCE, MAX_BOUNCES, MAX_CASCADES,
    MAX_CAUSTIC_RAYS, MAX_CAUSTIC_SIZE, MAX_SHADOWS, Shadow, SoftLight,
};
pub use look::{Lens, Occlusion, Tone};
pub use look_up::{LookUp, ShadowFilter};
pub use mask::MaskSettings;
pub use point::ReceiverPoint;
pub use scene::moved;
pub use scene::{MAX_SAMPLES, Motion, Scene};
pub use settings::{
    Air, BLUR_DEVIATIONS, ClusterSettings, CurveMemory, MAX_AIR_STEPS, MAX_BLUR, MAX_MAP_SIZE,
    MAX_MIPS, MAX_PAIRS, MIN_MAP_SIZE, Receiver, ShadowSettings,
};
pub use strand::{Capsule, Strand, StrandVertex, mitre};
pub use vertex_color::VertexColor;
pub use view::within_pixel;
pub use view::{Projection, TILE_SIZE, View, ViewRole, tiles_of};
pub use volume::{absorptions, is_closed, turn_outwards};
