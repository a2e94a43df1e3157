// Where a mask's pixel is, in the camera's view.

import package::bind::uniform::{mask_params, views};
import package::records::mask::MaskSurface;

// Centre of the picture's pixel that a mask's pixel stands for.
fn shown_pixel(at: vec2<u32>, step: u32, surface: MaskSurface) -> vec2<f32> {
    return vec2<f32>(at * step + surface.offset) + 0.5;
}

// View space [m].
fn view_point(at: vec2<u32>, step: u32, surface: MaskSurface) -> vec3<f32> {
    let view = views[0];
    let slope = (shown_pixel(at, step, surface) - view.size * 0.5) / view.scale;
    let distance = view.near + surface.depth * (view.far - view.near);
    return vec3(slope.x, -slope.y, -1.0) * distance;
}

// A surface that others are held against.
struct MaskPlane {
    point: vec3<f32>,  // view space [m]
    normal: vec3<f32>, // view space
    world: vec3<f32>,  // the same normal
    distance: f32,     // along the axis [m]
}

fn mask_plane(at: vec2<u32>, step: u32, surface: MaskSurface) -> MaskPlane {
    let point = view_point(at, step, surface);
    let normal = (views[0].view_from_world * vec4(surface.face, 0.0)).xyz;
    return MaskPlane(point, normal, surface.normal, -point.z);
}

// How far a point lies off the plane, in what the blur tolerates: 1 is too far.
fn plane_error(plane: MaskPlane, point: vec3<f32>) -> f32 {
    return abs(dot(plane.normal, point - plane.point)) * mask_params.sensitivity / plane.distance;
}

// How much a surface counts to another: by depth, and by the angle between them.
fn surface_weight(plane: MaskPlane, point: vec3<f32>, normal: vec3<f32>) -> f32 {
    let facing = max(dot(plane.world, normal), 0.0);
    let two = facing * facing;
    let four = two * two;
    return max(1.0 - plane_error(plane, point), 0.0) * four * four;
}
