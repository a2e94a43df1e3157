// Surfaces of the picture in view space. CPU reference: crates/gobo-reference/src/occlusion.rs.

import package::bind::uniform::{picture_params, views};

// Transform from pixels and light depths to view space.
struct Screen {
    first: vec2<f32>, // slopes of the middle of the first pixel, upwards
    step: vec2<f32>,  // from pixel to pixel
    near: f32,        // [m]
    range: f32,       // from the near to the far plane [m]
}

fn screen() -> Screen {
    let view = views[0];
    let step = vec2(1.0, -1.0) / view.scale;
    return Screen((0.5 - view.size * 0.5) * step, step, view.near, view.far - view.near);
}

// View-space position at light depth `depth` in the middle of a pixel [m].
fn seen_point(on: Screen, pixel: vec2<f32>, depth: f32) -> vec3<f32> {
    return vec3(on.first + pixel * on.step, -1.0) * (on.near + depth * on.range);
}

// View-space unit normal of a surface at `point`; zero stands for a surface that faces the eye.
fn seen_normal(normal: vec3<f32>, point: vec3<f32>) -> vec3<f32> {
    let turned = normal * mat3x3<f32>(
        picture_params.world_from_view[0].xyz,
        picture_params.world_from_view[1].xyz,
        picture_params.world_from_view[2].xyz,
    );
    return select(turned, -normalize(point), all(normal == vec3(0.0)));
}

fn radius_at(point: vec3<f32>) -> f32 {
    return picture_params.occlusion_radius - picture_params.occlusion_radius_per_distance * point.z;
}
