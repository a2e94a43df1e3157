// Sums over the casters of a texel, in one storage buffer: tiers without TEXTURE_ATOMIC. Texel = tile * 256 +
// index in the tile. Optical depth per channel in fixed point, and nearness of the nearest hit.

import package::bind::changed::sums;

fn load_sums(texel: u32) -> vec3<u32> {
    return vec3(
        atomicLoad(&sums[texel].red),
        atomicLoad(&sums[texel].green),
        atomicLoad(&sums[texel].blue),
    );
}

fn add_to_sums(texel: u32, tau: vec3<u32>) {
    atomicAdd(&sums[texel].red, tau.r);
    atomicAdd(&sums[texel].green, tau.g);
    atomicAdd(&sums[texel].blue, tau.b);
}

fn load_nearness(texel: u32) -> u32 {
    return atomicLoad(&sums[texel].nearness);
}

// Resets a texel for the next batch.
fn clear_sums(texel: u32) {
    atomicStore(&sums[texel].red, 0u);
    atomicStore(&sums[texel].green, 0u);
    atomicStore(&sums[texel].blue, 0u);
    atomicStore(&sums[texel].nearness, 0u);
}

fn raise_nearness(texel: u32, value: u32) {
    atomicMax(&sums[texel].nearness, value);
}

// Nearness per channel: the sums of coloured dithering.
fn raise_channels(texel: u32, values: vec3<u32>) {
    atomicMax(&sums[texel].red, values.r);
    atomicMax(&sums[texel].green, values.g);
    atomicMax(&sums[texel].blue, values.b);
}
