// air, scatter: light that the air of one slice of a column of pixels sends to the eye, per unit of
// scattering optical depth. One invocation per column and slice. CPU reference: src/reference/air.rs. Rust:
// src/stage/air.rs.

import package::bind::sampled::lights;
import package::bind::stored::sources;
import package::bind::uniform::{air_params, picture_params, views};
import package::records::air_params::AIR_CELL;
import package::records::light::{GpuLight, LIGHT_DIRECTIONAL, LIGHT_SPOT, SHAFTS_BIT, light_record};
import package::shade::phase::phase;
import package::shade::receive::{incoming, shadow};
import package::shade::sample_offset::{air_shift, sample_offset};

// Angle at a lamp between two samples [radians]: half a degree.
const SAMPLE_ANGLE: f32 = 0.0087266;
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
    // A point x is in it where dot(x, light.direction) >= cosine |x|; squared, a t^2 + 2 b t + c >= 0.
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
    // Across the cone: between the roots, if they are not those of its mirror image. Along it: the ray
    // leaves one of the two by one root, and enters the other by the other.
    let is_across = a < 0.0;
    let is_missed = is_across && (inner < 0.0 || start - along * b / a < 0.0);
    let lit = vec2(
        select(max(ends.x, low), select(ends.x, max(ends.x, high), along > 0.0), !is_across),
        select(min(ends.y, high), select(min(ends.y, low), ends.y, along > 0.0), !is_across),
    );
    return select(lit, vec2(1.0, 0.0), is_missed);
}

// Radiance that the air between two distances along the camera's axis, `ends`, scatters back along `ray`,
// per unit of scattering optical depth: the mean. Samples of a lamp are at even angles seen from it (Kulla
// and Fajardo 2012, section 4), as many as its light needs, in the cone of a spot alone.
// `offset`: of the samples, in their distances, -0.5 to 0.5.
fn scattered(
    light: GpuLight,
    eye: vec3<f32>,
    direction: vec3<f32>,
    ray: vec3<f32>,
    ends: vec2<f32>,
    offset: f32,
) -> vec3<f32> {
    let origin = eye - light.position;
    let metres = length(direction);
    let lit = select(ends, in_cone(light, origin, direction, ends), light.kind == LIGHT_SPOT);
    // Along the ray, from the point nearest to the lamp [m].
    let nearest = dot(origin, ray);
    let low = lit.x * metres + nearest;
    let high = lit.y * metres + nearest;
    let apart = max(length(origin - ray * nearest), NEAREST);
    let is_local = light.kind != LIGHT_DIRECTIONAL;
    let angle = select(0.0, atan2(apart * (high - low), apart * apart + low * high), is_local);
    let most = clamp(MAX_LIT_SAMPLES / picture_params.light_count, air_params.samples, MAX_AIR_SAMPLES);
    let wanted = clamp(u32(ceil(max(angle, 0.0) / SAMPLE_ANGLE)), air_params.samples, most);
    let is_lit = high > low && (light.traits & SHAFTS_BIT) != 0u;
    let count = select(0u, wanted, is_lit);
    var sum = vec3(0.0);
    for (var i = 0u; i < count; i += 1u) {
        let part = (f32(i) + 0.5 + offset) / f32(count);
        let turn = vec2(cos(angle * part), sin(angle * part));
        let turned = apart * dot(vec2(low, apart), turn) / dot(vec2(apart, -low), turn);
        let at = select(mix(low, high, part), clamp(turned, low, high), is_local);
        // Length of the ray that the sample stands for, in slices.
        let share = select(high - low, (apart + at * at / apart) * angle, is_local)
            / (metres * (ends.y - ends.x) * f32(count));
        let point = eye + ray * (at - nearest);
        let arriving = incoming(light, point);
        if any(arriving.color > vec3(0.0)) {
            let passed = shadow(light, point, vec3(0.0), arriving.toward, 0.0);
            sum += arriving.color * passed * (share * phase(dot(arriving.toward, ray), air_params.anisotropy));
        }
    }
    return sum;
}

@compute @workgroup_size(8, 8)
fn air_scatter(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(sources);
    if any(id.xy >= size) {
        return;
    }
    let view = views[0];
    let pixel = (vec2<f32>(id.xy) + 0.5) * f32(AIR_CELL) + air_shift(view);
    let slope = (pixel - view.size * 0.5) / view.scale;
    let eye = picture_params.world_from_view[3].xyz;
    let direction = (picture_params.world_from_view * vec4(slope.x, -slope.y, -1.0, 0.0)).xyz;
    let ray = normalize(direction);
    let parts = vec2(f32(id.z), f32(id.z) + 1.0) / f32(air_params.slices);
    let ends = view.near + parts * (view.far - view.near);
    let offset = sample_offset(view);
    var sum = air_params.ambient;
    // The loop's end depends on more than the uniform: llvmpipe would recompile the kernel for its value.
    let count = min(picture_params.light_count, textureDimensions(lights).x);
    for (var i = 0u; i < count; i += 1u) {
        sum += scattered(light_record(i), eye, direction, ray, ends, offset.x);
    }
    textureStore(sources, id.xy, id.z, vec4(sum, 1.0));
}
