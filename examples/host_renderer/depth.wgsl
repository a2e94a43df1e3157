// Depth of a light's view.

@group(0) @binding(0) var<uniform> clip_from_world: mat4x4<f32>;

@vertex
fn depth(@location(0) place: vec3<f32>) -> @builtin(position) vec4<f32> {
    return clip_from_world * vec4(place, 1.0);
}
