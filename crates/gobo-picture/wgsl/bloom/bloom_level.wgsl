// Levels of bloom: each half as large as the one before (Jimenez 2014, "Next Generation Post Processing in
// Call of Duty", with the weights of linear interpolation, so that no light is lost or added). CPU reference:
// crates/gobo-reference/src/bloom.rs.

import package::bind::sampled::bloom_from;

// Light of the coarser level at a texel of the finer one: the bilinear mean.
fn enlarged(texel: vec2<u32>) -> vec3<f32> {
    let last = vec2<i32>(textureDimensions(bloom_from)) - 1;
    let near = vec2<i32>(texel / 2u);
    let far = clamp(near + vec2<i32>(texel & vec2(1u)) * 2 - 1, vec2(0), last);
    let ahead = 3.0 * from_level(near) + from_level(vec2(far.x, near.y));
    let behind = 3.0 * from_level(vec2(near.x, far.y)) + from_level(far);
    return (3.0 * ahead + behind) / 16.0;
}

fn from_level(texel: vec2<i32>) -> vec3<f32> {
    return textureLoad(bloom_from, texel, 0).rgb;
}
