// Lights of the picture, records of the texture `lights`: all lights, then all shadow views. Rust:
// `GpuLight` in src/records/light.rs, `PictureParams` in crates/gobo-picture/src/stage/shade.rs.

import package::bind::sampled::{clusters, lights};
import package::bind::uniform::picture_params;
import package::records::record::record_texel;
import package::records::view::GpuView;

struct GpuLight {
    position: vec3<f32>,  // world space [m]
    kind: u32,
    direction: vec3<f32>, // in which light travels, unit, world space
    first_view: u32,
    color: vec3<f32>,     // times intensity
    view_count: u32,      // 0: casts no shadow
    cone_outer: f32,      // cosines of half the angle of a spot
    cone_inner: f32,
    per_range2: f32,      // [1/m^2]; 0: no end
    traits: u32,          // bits below; its area's index plus 1; its viewpoints less one
    taps: u32,            // FILTER_*; from bit 8 on its taps, from bit 16 on a disc's radius
    bias: f32,            // [m]; [texels] with TEXELS_BIT
    slope_bias: f32,      // [texels]
    normal_bias: f32,     // [texels]
}

const LIGHT_DIRECTIONAL: u32 = 0u;
const LIGHT_SPOT: u32 = 1u;
const LIGHT_POINT: u32 = 2u;
const SHAFTS_BIT: u32 = 1u; // the air scatters its light
const AREA_SHIFT: u32 = 1u;
const AREA_MASK: u32 = 0xffu;
const VIEWPOINTS_SHIFT: u32 = 9u;
const VIEWPOINTS_MASK: u32 = 0xfu;
const INNER_BIT: u32 = 0x2000u; // a spot falls off by the square of its share of the cosines
const END_BIT: u32 = 0x4000u;   // the window at the end of its range is not squared
const TEXELS_BIT: u32 = 0x8000u; // its bias is in texels
const LIGHT_TEXELS: u32 = 5u;
const VIEW_TEXELS: u32 = 8u;

struct PictureParams {
    world_from_view: mat4x4<f32>, // of the camera
    ambient: vec3<f32>,
    light_count: u32,
    background: vec3<f32>,
    first_setup: u32,  // footprint with setup 0, modulo 2^32
    exposure: f32,    // factor of the light before the tone curve
    first_area: u32,  // texel of `lights` where areas begin
    near: f32,        // of the camera [m]
    depth_range: f32, // far - near [m]
    cells: vec3<u32>, // of the clusters, in x, y and depth
    tile: u32,        // edge of a cluster [pixels]
    first_slice: f32, // end of the first slice [m]
    slices_per_doubling: f32,
    colored: u32,     // 1: opaque depths are per channel
    air_slices: u32,  // 0: no air
    tone: u32,        // TONE_*
    bloom: f32,       // share of the light that spreads
    occlusion_radius: f32,              // of occluders of ambient light [m]
    occlusion_radius_per_distance: f32, // added to it, times the distance along the axis
    extinction: vec3<f32>, // of the air [1/m]
    environment_size: u32,            // edge of its sharp level [texels]
    image_reach: f32,      // edge of the area of a sample, for images [pixels]
    cutout_threshold: f32, // mean opacity from which a cutout with small texels is solid
    from_first: vec2<f32>, // offset of the sample in its pixel from the first sample's [pixels]
    second_from_first: vec2<f32>, // offset of the second sample from the first [pixels]
    pad_0: u32,
    pad_1: u32,
    irradiance: array<vec4<f32>, 9>,  // of the environment, spherical harmonics (rgb)
}

fn light_record(index: u32) -> GpuLight {
    let at = index * LIGHT_TEXELS;
    let words = textureLoad(lights, record_texel(at), 0);
    let direction = textureLoad(lights, record_texel(at + 1u), 0);
    let color = textureLoad(lights, record_texel(at + 2u), 0);
    let bits = textureLoad(lights, record_texel(at + 3u), 0);
    let rest = bitcast<vec3<f32>>(bits.xyz);
    let look_up = textureLoad(lights, record_texel(at + 4u), 0);
    let biases = bitcast<vec3<f32>>(look_up.yzw);
    return GpuLight(
        bitcast<vec3<f32>>(words.xyz),
        words.w,
        bitcast<vec3<f32>>(direction.xyz),
        direction.w,
        bitcast<vec3<f32>>(color.xyz),
        color.w,
        rest.x,
        rest.y,
        rest.z,
        bits.w,
        look_up.x,
        biases.x,
        biases.y,
        biases.z,
    );
}

fn view_texel(index: u32, texel: u32) -> vec4<u32> {
    let at = picture_params.light_count * LIGHT_TEXELS + index * VIEW_TEXELS + texel;
    return textureLoad(lights, record_texel(at), 0);
}

// ROLE_* number of a view.
fn shadow_role(index: u32) -> u32 {
    return view_texel(index, 7u).x;
}

fn shadow_view(index: u32) -> GpuView {
    let shape = bitcast<vec4<f32>>(view_texel(index, 4u));
    let depth = view_texel(index, 5u);
    let words = view_texel(index, 6u);
    let role = view_texel(index, 7u);
    return GpuView(
        mat4x4(
            bitcast<vec4<f32>>(view_texel(index, 0u)),
            bitcast<vec4<f32>>(view_texel(index, 1u)),
            bitcast<vec4<f32>>(view_texel(index, 2u)),
            bitcast<vec4<f32>>(view_texel(index, 3u)),
        ),
        shape.xy,
        shape.z,
        shape.w,
        bitcast<f32>(depth.x),
        bitcast<f32>(depth.y),
        depth.z,
        depth.w,
        words.xy,
        words.z,
        words.w,
        role.x,
        role.y,
        role.z,
        bitcast<f32>(role.w),
    );
}

// Lights that may reach a point, in order of their index: a list of `clusters`, or all.
struct LightList {
    first: u32, // texel of `clusters`, or ALL_LIGHTS
    count: u32,
}

// Cluster of a pixel of the camera at light depth `depth`. Points outside every cluster, such as the centre
// of a particle beside the picture, get all lights.
fn cluster_of(pixel: vec2<f32>, depth: f32) -> u32 {
    let distance = picture_params.near + depth * picture_params.depth_range;
    let doublings = log2(max(distance / picture_params.first_slice, 1.0));
    let beyond = u32(doublings * picture_params.slices_per_doubling) + 1u;
    let slice = min(select(0u, beyond, distance >= picture_params.first_slice), picture_params.cells.z - 1u);
    let cell = vec2<u32>(max(pixel, vec2(0.0))) / picture_params.tile;
    let inside = all(pixel >= vec2(0.0)) && all(cell < picture_params.cells.xy)
        && depth >= 0.0 && depth <= 1.0;
    let cluster = (slice * picture_params.cells.y + cell.y) * picture_params.cells.x + cell.x;
    return select(ALL_LIGHTS, cluster, inside);
}

fn cluster_list(cluster: u32) -> LightList {
    let at = select(2u * cluster, 0u, cluster == ALL_LIGHTS);
    let first = textureLoad(clusters, record_texel(at), 0).r;
    let count = textureLoad(clusters, record_texel(at + 1u), 0).r;
    if (cluster == ALL_LIGHTS) | (first == ALL_LIGHTS) {
        return LightList(ALL_LIGHTS, picture_params.light_count);
    }
    return LightList(first, count);
}

fn listed_index(list: LightList, i: u32) -> u32 {
    var index = i;
    if list.first != ALL_LIGHTS {
        index = textureLoad(clusters, record_texel(list.first + i), 0).r;
    }
    return index;
}

// A batch of points that are evaluated together. Rust: crates/gobo-picture/src/stage/shade.rs.
struct PointBatch {
    first: u32,       // first entry of the list; without a list the first point of `lit`, or the first caster
    count: u32,       // of answers without a list
    has_normals: u32, // 1 if the host's points have normals, else 0
    list: u32,        // *_LIST
    grid: u32,        // of points in bricks: first texel of their grid's record
    own_shadow: u32,  // 1 where the voxels of their own brick shadow them
}

const ALL_LIGHTS: u32 = 0xffffffffu; // for a list that did not fit
