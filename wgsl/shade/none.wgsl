// Choices of look-ups without thrown light and without a shadow function of the host.

import package::records::light::GpuLight;

// Stands in where the host has no shadow function.
fn host_shadow(light: u32, position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    return vec3(1.0);
}

// Look-up without light that glass throws.
fn thrown_at(light: GpuLight, point: vec3<f32>) -> vec4<f32> {
    return vec4(0.0);
}

fn with_thrown(thrown: vec4<f32>, straight: vec3<f32>) -> vec3<f32> {
    return straight;
}
