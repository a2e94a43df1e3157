// Levels of bloom: each half as large as the one before (Jimenez 2014, "Next Generation Post Processing in
// Call of Duty", with the weights of linear interpolation, so that no light is lost or added). CPU reference:
// crates/gobo-reference/src/bloom.rs. Rust: crates/gobo-picture/src/stage/bloom.rs.

import package::bind::picture_in::{bloom_from, bloom_level, composited};
import package::bind::picture_out::{bloom_to, pixels, radiance};
import package::bind::uniform::picture_params;
import package::shade::tone::on_screen;

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

// Most light of a texel: levels are halves.
const MAX_BLOOM: f32 = 65504.0;

// bloom, down: the next level. One invocation per texel of it.
@compute @workgroup_size(8, 8)
fn bloom_down(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(bloom_to)) {
        return;
    }
    let last = vec2<i32>(textureDimensions(bloom_from)) - 1;
    let first = vec2<i32>(id.xy * 2u) - 1;
    var sum = vec3(0.0);
    for (var i = 0; i < 16; i += 1) {
        let step = vec2(i & 3, i >> 2u);
        let inner = select(vec2(1.0), vec2(3.0), step == clamp(step, vec2(1), vec2(2)));
        let texel = clamp(first + step, vec2(0), last);
        sum += min(from_level(texel), vec3(MAX_BLOOM)) * (inner.x * inner.y / 64.0);
    }
    textureStore(bloom_to, id.xy, vec4(sum, 1.0));
}

// Share of the coarser levels.
const BLOOM_SPREAD: f32 = 0.7;

// bloom, up: a level with its share of all coarser ones. One invocation per texel.
@compute @workgroup_size(8, 8)
fn bloom_up(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(bloom_to)) {
        return;
    }
    let level = textureLoad(bloom_level, id.xy, 0).rgb;
    textureStore(bloom_to, id.xy, vec4(mix(level, enlarged(id.xy), BLOOM_SPREAD), 1.0));
}

// bloom, apply: spreads a share of the picture's light. One invocation per pixel.
@compute @workgroup_size(8, 8)
fn bloom_apply(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(composited);
    if any(id.xy >= size) {
        return;
    }
    let sharp = textureLoad(composited, id.xy, 0);
    let light = mix(sharp.rgb, enlarged(id.xy), picture_params.bloom);
    textureStore(radiance, id.xy, vec4(light, sharp.w));
    pixels[id.y * size.x + id.x] = on_screen(light);
}
