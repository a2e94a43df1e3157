// Choices of look-ups that have no masks, no thrown light and no shadow function of the host.

import package::records::light::GpuLight;
import package::records::point::Point;

// Stands in where the host has no shadow function.
fn host_shadow(light: u32, position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    return vec3(1.0);
}

// Share of a light from its mask, 1 without a mask; and whether it has one.
struct Masked {
    share: vec3<f32>,
    is_masked: bool,
}

fn masked(light: u32, point: Point) -> Masked {
    return Masked(vec3(1.0), false);
}

// Look-up without light that glass throws.
fn with_thrown(light: GpuLight, point: vec3<f32>, straight: vec3<f32>) -> vec3<f32> {
    return straight;
}
