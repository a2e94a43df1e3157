// Points and normals of what the camera sees. Needs common/caster_hit.wgsl, octahedral.wgsl; the
// kernel binds `triangles`, `params`.

// World space, from the camera's light depth.
fn world_point(view: GpuView, pixel: vec2<f32>, depth: f32) -> vec3<f32> {
    let slope = (pixel - view.size * 0.5) / view.scale;
    let distance = view.near + depth * (view.far - view.near);
    return (params.world_from_view * vec4(slope.x * distance, -slope.y * distance, -distance, 1.0)).xyz;
}

const TRIANGLE_TEXELS: u32 = 5u;

fn triangle_normal(id: u32, barycentric: vec3<f32>) -> vec3<f32> {
    let bits = textureLoad(triangles, record_texel(id * TRIANGLE_TEXELS + 4u), 0).xyz;
    let normal = from_octahedral(bits.x) * barycentric.x + from_octahedral(bits.y) * barycentric.y
        + from_octahedral(bits.z) * barycentric.z;
    return normalize(normal);
}
