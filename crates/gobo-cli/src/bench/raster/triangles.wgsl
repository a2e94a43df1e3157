// Opaque triangles of a directional view: nothing but depth.
@group(0) @binding(0) var<uniform> clip_from_world: mat4x4<f32>;

@vertex
fn corner(@location(0) position: vec3<f32>) -> @builtin(position) vec4<f32> {
    return clip_from_world * vec4(position, 1.0);
}
