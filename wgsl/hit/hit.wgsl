// What one ray through one texel meets. CPU twin: src/reference/hit.rs.

import package::records::material::{
    MAX_GAIN, PROFILE_SOFT, SHAPE_DISC, SHAPE_QUAD, TRANSFER_DITHER, TRANSFER_FILTER,
    TRANSFER_GAIN, TRANSFER_OVER, TRANSFER_SMOKE, TRANSFER_STAIN,
};
import package::records::view::GpuView;

// A particle made ready for the texels around it: q = frame * delta / (1 + tilt . delta), where
// delta is the way from its centre to the texel's [texels].
struct Facing {
    center: vec2<f32>,
    frame_x: vec2<f32>,
    frame_y: vec2<f32>,
    tilt: vec2<f32>,
    distance: f32, // of the centre along the axis [m]
}

fn to_world(view: GpuView, v: vec3<f32>) -> vec3<f32> {
    return v * mat3x3(view.view_from_world[0].xyz, view.view_from_world[1].xyz, view.view_from_world[2].xyz);
}

fn to_map(view: GpuView, axis: vec3<f32>) -> vec2<f32> {
    let v = view.view_from_world * vec4(axis, 0.0);
    return vec2(v.x, -v.y);
}

// `radius` as in a footprint; `rotation` about the ray [radians].
fn facing(view: GpuView, center: vec2<f32>, radius: f32, depth: f32, rotation: f32) -> Facing {
    let slope = (center - view.size * 0.5) / view.scale;
    var ray = vec3(slope.x, -slope.y, -1.0);
    var k = 1.0 / radius;
    var tilt = vec2(0.0);
    if view.perspective > 0.0 {
        let len = length(ray);
        ray /= len;
        k = 1.0 / (radius * len * view.scale);
        tilt = vec2(ray.x, -ray.y) / (len * view.scale);
    } else {
        ray = vec3(0.0, 0.0, -1.0);
    }
    let n = to_world(view, ray);
    let up = select(vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0), abs(n.y) > 0.99);
    let x = normalize(cross(up, n));
    let y = cross(n, x);
    let s = sin(rotation);
    let c = cos(rotation);
    return Facing(
        center,
        to_map(view, x * c + y * s) * k,
        to_map(view, y * c - x * s) * k,
        tilt,
        view.near + depth * (view.far - view.near),
    );
}

// q.xy and light depth; depth -1 where the ray runs away from the plane.
fn facing_hit(f: Facing, view: GpuView, texel: vec2<f32>) -> vec3<f32> {
    let delta = texel - f.center;
    let denominator = 1.0 + dot(f.tilt, delta);
    let q = vec2(dot(f.frame_x, delta), dot(f.frame_y, delta)) / denominator;
    let depth = (f.distance / denominator - view.near) / (view.far - view.near);
    return select(vec3(2.0, 2.0, -1.0), vec3(q, depth), denominator > 0.0);
}

// The share of a particle's alpha at q, 0 outside its shape.
fn coverage(shape: u32, profile: u32, q: vec2<f32>) -> f32 {
    let square = dot(q, q);
    if shape == SHAPE_QUAD {
        return select(0.0, 1.0, max(abs(q.x), abs(q.y)) <= 1.0);
    }
    let rest = 1.0 - square;
    let soft = shape == SHAPE_DISC && profile == PROFILE_SOFT;
    return select(0.0, select(1.0, rest * rest, soft), square <= 1.0);
}

// Light that passes a hit of opacity a and colour c (of `gain`: over 16).
fn transmittance(transfer: u32, a: f32, c: vec3<f32>) -> vec3<f32> {
    switch transfer {
        // In the picture; shadows are dithered.
        case TRANSFER_FILTER, TRANSFER_DITHER: { return 1.0 - a * (1.0 - c); }
        case TRANSFER_STAIN: { return c * (1.0 - a); }
        case TRANSFER_SMOKE: { return (1.0 - a) * (1.0 - a * (1.0 - c)); }
        case TRANSFER_GAIN: { return c * MAX_GAIN; }
        case TRANSFER_OVER: { return vec3(1.0 - a); }
        default: { return vec3(1.0); }
    }
}
