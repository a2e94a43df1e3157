// Positions and normals of visible surfaces. CPU reference: crates/gobo-reference/src/shading/mod.rs.

import package::bind::uniform::picture_params;
import package::records::view::GpuView;

// World-space position from the camera's light depth.
fn world_point(view: GpuView, pixel: vec2<f32>, depth: f32) -> vec3<f32> {
    let slope = (pixel - view.size * 0.5) / view.scale;
    let distance = view.near + depth * (view.far - view.near);
    return (picture_params.world_from_view * vec4(
        slope.x * distance,
        -slope.y * distance,
        -distance,
        1.0,
    )).xyz;
}

fn eye() -> vec3<f32> {
    return picture_params.world_from_view[3].xyz;
}

fn toward(side: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    return select(-normal, normal, dot(normal, side) >= 0.0);
}
