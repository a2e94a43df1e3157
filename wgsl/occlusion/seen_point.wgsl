// Surfaces of the picture in view space. CPU reference: src/reference/occlusion.rs.

import package::bind::uniform::{occlusion_params, picture_params, views};

// Rust: `OcclusionParams` in src/stage/occlusion.rs.
struct OcclusionParams {
    radius: f32,              // of the surroundings that occlude [m]
    radius_per_distance: f32, // added to it, times the distance along the axis
}

// Position in view space [m] of light depth `depth` in the middle of a pixel.
fn seen_point(pixel: vec2<i32>, depth: f32) -> vec3<f32> {
    let view = views[0];
    let slope = (vec2<f32>(pixel) + 0.5 - view.size * 0.5) / view.scale;
    let distance = view.near + depth * (view.far - view.near);
    return vec3(slope.x, -slope.y, -1.0) * distance;
}

// Unit normal in view space of a surface at `point`; zero faces the eye.
fn seen_normal(normal: vec3<f32>, point: vec3<f32>) -> vec3<f32> {
    let turned = normal * mat3x3<f32>(
        picture_params.world_from_view[0].xyz,
        picture_params.world_from_view[1].xyz,
        picture_params.world_from_view[2].xyz,
    );
    return select(turned, -normalize(point), all(normal == vec3(0.0)));
}

fn radius_at(point: vec3<f32>) -> f32 {
    return occlusion_params.radius - occlusion_params.radius_per_distance * point.z;
}
