// Images of materials: one layer each, bilinear, repeating. CPU reference: src/reference/texture.rs.

fn sample_texture(
    images: texture_2d_array<f32>,
    layer: u32,
    size: vec2<f32>,
    uv: vec2<f32>,
) -> vec4<f32> {
    let at = (uv - floor(uv)) * size - 0.5;
    let low = floor(at);
    let part = at - low;
    let s = vec2<i32>(size);
    let a = (vec2<i32>(low) + s) % s;
    let b = (a + 1) % s;
    let top = mix(
        textureLoad(images, a, layer, 0),
        textureLoad(images, vec2(b.x, a.y), layer, 0),
        part.x,
    );
    let bottom = mix(
        textureLoad(images, vec2(a.x, b.y), layer, 0),
        textureLoad(images, b, layer, 0),
        part.x,
    );
    return mix(top, bottom, part.y);
}
