// Sums over the casters of a texel, in a storage buffer for each channel: tiers without TEXTURE_ATOMIC whose
// records are in textures. Texel = tile * 256 + index in the tile. Optical depth in fixed point, and nearness
// of the nearest hit.

import package::bind::changed::{nearness, sum_blue, sum_green, sum_red};

fn load_sums(texel: u32) -> vec3<u32> {
    return vec3(
        atomicLoad(&sum_red[texel]),
        atomicLoad(&sum_green[texel]),
        atomicLoad(&sum_blue[texel]),
    );
}

fn add_to_sums(texel: u32, tau: vec3<u32>) {
    atomicAdd(&sum_red[texel], tau.r);
    atomicAdd(&sum_green[texel], tau.g);
    atomicAdd(&sum_blue[texel], tau.b);
}

fn load_nearness(texel: u32) -> u32 {
    return atomicLoad(&nearness[texel]);
}

// Resets a texel for the next batch.
fn clear_sums(texel: u32) {
    atomicStore(&sum_red[texel], 0u);
    atomicStore(&sum_green[texel], 0u);
    atomicStore(&sum_blue[texel], 0u);
    atomicStore(&nearness[texel], 0u);
}

fn raise_nearness(texel: u32, value: u32) {
    atomicMax(&nearness[texel], value);
}

// Nearness per channel: the sums of coloured dithering.
fn raise_channels(texel: u32, values: vec3<u32>) {
    atomicMax(&sum_red[texel], values.r);
    atomicMax(&sum_green[texel], values.g);
    atomicMax(&sum_blue[texel], values.b);
}
