// Sums over the casters of a texel, in storage textures: the native tier (TEXTURE_ATOMIC). Texel = tile *
// 256 + index in the tile. Optical depth per channel in fixed point, and nearness of the nearest hit.

import package::bind::updated::{nearness, sum_blue, sum_green, sum_red};
import package::records::record::record_texel;

fn load_sums(texel: u32) -> vec3<u32> {
    let at = record_texel(texel);
    return vec3(textureLoad(sum_red, at).r, textureLoad(sum_green, at).r, textureLoad(sum_blue, at).r);
}

fn add_to_sums(texel: u32, tau: vec3<u32>) {
    let at = record_texel(texel);
    textureAtomicAdd(sum_red, at, tau.r);
    textureAtomicAdd(sum_green, at, tau.g);
    textureAtomicAdd(sum_blue, at, tau.b);
}

fn load_nearness(texel: u32) -> u32 {
    return textureLoad(nearness, record_texel(texel)).r;
}

// Resets a texel for the next batch.
fn clear_sums(texel: u32) {
    let at = record_texel(texel);
    textureStore(sum_red, at, vec4(0u));
    textureStore(sum_green, at, vec4(0u));
    textureStore(sum_blue, at, vec4(0u));
    textureStore(nearness, at, vec4(0u));
}

fn raise_nearness(texel: u32, value: u32) {
    textureAtomicMax(nearness, record_texel(texel), value);
}

// Nearness per channel: the sums of coloured dithering.
fn raise_channels(texel: u32, values: vec3<u32>) {
    let at = record_texel(texel);
    textureAtomicMax(sum_red, at, values.r);
    textureAtomicMax(sum_green, at, values.g);
    textureAtomicMax(sum_blue, at, values.b);
}
