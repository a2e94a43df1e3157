// air, scatter: light that the air of one slice of a column of pixels sends to the eye, per unit of
// scattering optical depth. One workgroup per item, one invocation per column and slice of it. CPU reference:
// crates/gobo-reference/src/air.rs. Rust: crates/gobo-picture/src/stage/air.rs.

import package::bind::picture_in::{air_ends, air_items, air_params};
import package::bind::picture_out::sources;
import package::bind::sampled::lights;
import package::bind::uniform::{picture_params, views};
import package::records::light::{GpuLight, LIGHT_DIRECTIONAL, LIGHT_SPOT, SHAFTS_BIT, light_record};
import package::records::picture::AIR_CELL;
import package::shade::air::{air_shift, sample_offset};
import package::shade::air_items::{
    AIR_BLOCK, AIR_RUN, ITEM_COUNT, ITEM_HEAD, MAX_AIR_RUNS, air_size, block_column, item_rows,
};
import package::shade::incoming::incoming;
import package::shade::shading::phase;
import package::shade::shadow::{UNSHADED, past_view, receiver_of};

// Angle at a lamp between two samples [radians]: half a degree.
const SAMPLE_ANGLE: f32 = 0.0087266;
// Fewest samples of a light in a slice: the edge of a shaft across the slice is then no step.
const MIN_AIR_SAMPLES: u32 = 2u;
// Most samples of a light in a slice, and of all lights: the loops of an invocation share llvmpipe's 65,535
// iterations.
const MAX_AIR_SAMPLES: u32 = 16u;
const MAX_LIT_SAMPLES: u32 = 256u;
// Distance from a lamp below which its light does not rise [m]: that of `incoming`.
const NEAREST: f32 = 0.01;
// Instead of 0 in a divisor.
const TINY: f32 = 1e-20;

// Part of the ray `origin + direction t` with t within `ends` that is in the cone of a spot at zero; empty
// where x > y.
fn in_cone(light: GpuLight, origin: vec3<f32>, direction: vec3<f32>, ends: vec2<f32>) -> vec2<f32> {
    // A point x is in the cone where dot(x, light.direction) >= cosine |x|; squared, a t^2 + 2 b t + c >= 0.
    let along = dot(direction, light.direction);
    let start = dot(origin, light.direction);
    let square = light.cone_outer * light.cone_outer;
    let curved = along * along - square * dot(direction, direction);
    let a = select(curved, TINY, abs(curved) < TINY);
    let b = along * start - square * dot(direction, origin);
    let c = start * start - square * dot(origin, origin);
    let inner = b * b - a * c;
    let root = sqrt(max(inner, 0.0));
    let q = select(-(b + root), root - b, b < 0.0);
    let first = q / a;
    let second = c / select(q, TINY, abs(q) < TINY);
    let low = min(first, second);
    let high = max(first, second);
    // A ray across the cone is inside between the roots, if they are not those of the mirrored cone. A ray
    // along it leaves one of the two cones by one root, and enters the other by the other.
    let is_across = a < 0.0;
    let is_missed = is_across & ((inner < 0.0) | (start - along * b / a < 0.0));
    let lit = vec2(
        select(max(ends.x, low), select(ends.x, max(ends.x, high), along > 0.0), !is_across),
        select(min(ends.y, high), select(min(ends.y, low), ends.y, along > 0.0), !is_across),
    );
    return select(lit, vec2(1.0, 0.0), is_missed);
}

// A column of pixels, and a slice's part of it.
struct Column {
    direction: vec3<f32>, // of its ray, as long as 1 m along the camera's axis
    ray: vec3<f32>,       // unit
    ends: vec2<f32>,      // of the slice, distances along the camera's axis [m]
}

fn eye_position() -> vec3<f32> {
    return picture_params.world_from_view[3].xyz;
}

fn column_of(id: vec3<u32>) -> Column {
    let view = views[0];
    let pixel = (vec2<f32>(id.xy) + 0.5) * f32(AIR_CELL) + air_shift(view);
    let slope = (pixel - view.size * 0.5) / view.scale;
    let direction = (picture_params.world_from_view * vec4(slope.x, -slope.y, -1.0, 0.0)).xyz;
    let parts = vec2(f32(id.z), f32(id.z) + 1.0) / f32(air_params.slices);
    return Column(direction, normalize(direction), view.near + parts * (view.far - view.near));
}

// The part of a slice that a light reaches, and its samples. For a lamp, they are at even angles seen from it
// (Kulla and Fajardo 2012, section 4), as many as its light needs; for a spot, within its cone.
struct Stretch {
    metres: f32,  // of the ray per metre along the camera's axis
    nearest: f32, // place along the ray nearest to the lamp [m]
    low: f32,     // ends, from that place [m]
    high: f32,
    apart: f32,   // distance of ray and lamp [m]
    angle: f32,   // between the ends, seen from the lamp [radians]
    count: u32,   // of samples
}

fn stretch_of(light: GpuLight, column: Column) -> Stretch {
    let origin = eye_position() - light.position;
    let metres = length(column.direction);
    var lit = column.ends;
    if light.kind == LIGHT_SPOT {
        lit = in_cone(light, origin, column.direction, column.ends);
    }
    let nearest = dot(origin, column.ray);
    let low = lit.x * metres + nearest;
    let high = lit.y * metres + nearest;
    let apart = max(length(origin - column.ray * nearest), NEAREST);
    let is_local = light.kind != LIGHT_DIRECTIONAL;
    let angle = select(0.0, atan2(apart * (high - low), apart * apart + low * high), is_local);
    let most = clamp(MAX_LIT_SAMPLES / picture_params.light_count, MIN_AIR_SAMPLES, MAX_AIR_SAMPLES);
    let wanted = min(u32(ceil(max(angle, 0.0) / SAMPLE_ANGLE)), most);
    // Those of the pictures through all samples of a pixel interleave.
    let count = max((wanted + air_params.pictures - 1u) / air_params.pictures, MIN_AIR_SAMPLES);
    let is_lit = (high > low) & ((light.traits & SHAFTS_BIT) != 0u);
    return Stretch(metres, nearest, low, high, apart, angle, select(0u, count, is_lit));
}

// Distance of sample `i` along the ray, from the place nearest to the lamp [m], and the length of ray that it
// represents, in slices. Samples are offset by -0.5 to 0.5 of their distances.
fn sample_of(light: GpuLight, column: Column, stretch: Stretch, i: u32) -> vec2<f32> {
    let is_local = light.kind != LIGHT_DIRECTIONAL;
    let part = (f32(i) + 0.5 + sample_offset(views[0]).x) / f32(stretch.count);
    let turn = vec2(cos(stretch.angle * part), sin(stretch.angle * part));
    let turned = stretch.apart * dot(vec2(stretch.low, stretch.apart), turn)
        / dot(vec2(stretch.apart, -stretch.low), turn);
    let at = select(mix(stretch.low, stretch.high, part), clamp(turned, stretch.low, stretch.high), is_local);
    let share = select(
        stretch.high - stretch.low,
        (stretch.apart + at * at / stretch.apart) * stretch.angle,
        is_local,
    )
        / (stretch.metres * (column.ends.y - column.ends.x) * f32(stretch.count));
    return vec2(at, share);
}

@compute @workgroup_size(AIR_BLOCK * AIR_BLOCK * AIR_RUN)
fn air_scatter(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let number = workgroup.x * item_rows() + workgroup.y;
    if number >= air_items[ITEM_COUNT] {
        return;
    }
    let item = air_items[ITEM_HEAD + number];
    let at = vec3(lane % AIR_BLOCK, lane / AIR_BLOCK % AIR_BLOCK, lane / (AIR_BLOCK * AIR_BLOCK));
    let id = vec3(block_column(item / MAX_AIR_RUNS), item % MAX_AIR_RUNS * AIR_RUN) + at;
    let size = air_size();
    if any(id.xy >= size) {
        return;
    }
    let ends = air_ends[id.y * size.x + id.x];
    if (id.z < (ends >> 16u)) | (id.z >= (ends & 0xffffu)) {
        return;
    }
    // The loop's end depends on more than the uniform, for whose value llvmpipe would recompile the kernel.
    let count = min(picture_params.light_count, textureDimensions(lights).x);
    textureStore(sources, id.xy, id.z, vec4(scattered(id, count), 1.0));
}

// Radiance that the air of a slice sends along the ray to the eye, per unit of scattering optical depth: of
// its surroundings and, as means over samples, of the first `count` lights. A turn reads one view for a
// sample, and evaluates the sample for it: an area light leaves no registers to keep it.
fn scattered(slice: vec3<u32>, count: u32) -> vec3<f32> {
    var all = air_params.ambient;
    var of_light = vec3(0.0);
    var passed = UNSHADED;
    var number = 0u; // of the light
    var i = 0u;      // of its sample
    if count > 0u {
        loop {
            let column = column_of(slice);
            let light = light_record(number);
            let stretch = stretch_of(light, column);
            let along = sample_of(light, column, stretch, i);
            let point = eye_position() + column.ray * (along.x - stretch.nearest);
            let arriving = incoming(light, point);
            let share = along.y * phase(dot(arriving.toward, column.ray), air_params.anisotropy);
            let is_lit = (i < stretch.count) & any(arriving.color > vec3(0.0));
            let is_last = i + 1u >= stretch.count;
            passed.is_all = true;
            if is_lit & (light.view_count > 0u) {
                let receiver = receiver_of(light, point, vec3(0.0), arriving.toward, 0.0);
                passed = past_view(passed, light, receiver);
            }
            if passed.is_all {
                of_light += select(vec3(0.0), arriving.color * passed.light * share, is_lit);
                passed = UNSHADED;
                i += 1u;
                if is_last {
                    all += of_light;
                    of_light = vec3(0.0);
                    i = 0u;
                    number += 1u;
                    if number >= count {
                        break;
                    }
                }
            }
        }
    }
    return all;
}
