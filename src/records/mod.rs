//! Records that stages pass on: casters as uploaded, footprints as projected to one view.
//!
//! Records that kernels write are in buffers, or in textures where a device cannot bind such large buffers
//! ([`RecordForm`]).
//! Textures of records are rgba32uint or rg32uint, [`ROW`] texels wide: element `i` of `n` texels starts at
//! linear texel `i * n`. WGSL: `wgsl/records/record.wgsl`.
//!
//! [`RecordForm`]: crate::gpu::RecordForm
mod area;
mod blue;
mod bounce;
mod brick;
mod capsule;
mod caster;
mod caustic;
mod cluster;
mod convert;
pub mod curve;
mod emitter;
mod footprint;
mod gaussian;
mod host;
mod image;
mod import;
mod layout;
mod light;
mod maps;
mod mask;
mod material;
mod outline;
mod owner;
mod pack;
mod sums;
mod triangle;
mod view;

pub use crate::model::pcg;
pub use area::{
    AREA_FLAT, AREA_SPHERE, AREA_SUN, AREA_TEXELS, BLOCK_NODES, BLOCK_TEXELS, GpuArea,
    LEVELED_TEXELS, LeveledView, LightRecords, MAX_AREAS, MAX_LEVELS, SKIRT, level_count,
    level_size,
};
pub use blue::{BLUE_SIZE, blue_ranks};
pub use bounce::{
    BOUNCE_LENGTH, BOUNCE_SAMPLES, BOUNCE_VECTORS, BounceParams, albedo_of, solid_faces,
};
pub use brick::{BRICK_TEXELS, BrickRecord, Bricks, GridRecord, LATTICE_EDGE, SLOT_SIZE};
pub use capsule::{CAPSULE_RECORDS, CapsuleRecord, Capsules};
pub use caster::{CASTER_TEXELS, CasterRecord};
pub use caustic::{
    CARRY_BITS, CAUSTIC_ONE, CausticTexel, GLASS_VECTORS, GlassFace, NO_FACE, THROWN_BIT,
    add_caustic, caustic_light, caustic_words, glass_faces,
};
pub use cluster::{ALL_LIGHTS, MAX_TILE, PLANES, REACH_TEXELS, Reach, UNIT};
pub use convert::{ConvertParams, FORMAT_RG11B10UFLOAT, FORMAT_RGBA8UNORM, FORMAT_RGBA16FLOAT};
pub use curve::{CurveMap, PackedNode};
pub use emitter::{EmissionParams, EmitterParams, GpuEmitted, STEPS_AT_ONCE};
pub use footprint::{
    BRICK_SEGMENT, CAPSULE_MARK, CURVE_SEGMENT, DEPTH_BITS, FOOTPRINT_TEXELS, Footprint,
    GAUSSIAN_MARK, INVISIBLE, MIN_RADIUS, ORDERED_SEGMENT, TRIANGLE_BIT, TileRect,
};
pub use gaussian::{
    GAUSSIAN_TEXELS, GaussianAxes, GaussianSetup, MEDIUM_BIT, NEUTRAL_BIT, OUTLINE_TEXEL,
    UNIT_ROUNDING,
};
pub use host::{
    CullParams, DIAGONAL, GaussianLook, HostGridParams, HostGroup, LoadCounters, LoadParams,
    MAX_COORDINATE,
};
pub use image::{
    CLEAR_WEIGHT, ImageDetail, ImageLevel, LEAST_TAP, MAX_IMAGE_TAPS, image_level_count,
    image_level_size, image_levels, linear_from_srgb,
};
pub use import::ImportParams;
pub use layout::{Field, GpuLayout};
pub(crate) use layout::{gpu_struct, texel_struct};
pub use light::{
    AREA_MASK, AREA_SHIFT, CASTER_BIAS, END_BIT, FILTER_BOX, FILTER_DISC, FILTER_NONE,
    FILTER_SPLINE, GpuLight, INNER_BIT, LARGEST_BIAS, LEAST_BIAS, LEAST_COSINE, LIGHT_DIRECTIONAL,
    LIGHT_POINT, LIGHT_SPOT, LIGHT_TEXELS, MAX_LIGHTS, MAX_SHADOW_VIEWS, MAX_TAPS, RADIUS_STEPS,
    SHAFTS_BIT, SPLINE_REACH, TEXELS_BIT, VIEW_TEXELS, VIEWPOINTS_MASK, VIEWPOINTS_SHIFT,
};
pub use maps::{Picture, ViewMaps};
pub use mask::{
    COLORED_BIT, FormerSlots, HostView, JOINED_BIT, MaskParams, MaskSlots, NORMALS_NONE,
    NORMALS_SIGNED, NORMALS_UNORM, SLOTS, ScreenBounds, mask_size,
};
pub use material::{
    DETAILS_SHIFT, FAR_SIDE_SHIFT, GpuMaterial, MAX_MATERIALS, NO_TEXTURE, SHOWS_COLOR,
    SHOWS_SURROUNDINGS,
};
pub use outline::{OUTLINE_ROUNDING, Outline};
pub use owner::{DEPTH_TAG_BITS, NO_OWNER, owner_tag, stored_tag};
pub use pack::OPACITY_SCALE;
pub use pack::{from_octahedral, octahedral};
pub use sums::{FIXED_ONE, MAX_TAU, SATURATED, added, nearness, resolved};
pub use triangle::{BACK_BIT, SETUP_TEXELS, TRIANGLE_TEXELS, TriangleRecord, TriangleSetup};
pub use view::{GpuView, MAX_VIEWS, ROLE_FACE, ROLE_WHOLE, ROLE_WINDOW};

/// Texels in a row of a record texture.
pub const ROW: u32 = 4096;
