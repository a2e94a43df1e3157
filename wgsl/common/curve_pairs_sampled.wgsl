// Pairs of a tile, front to back. Of the kernels of curves, on the core tier.
@group(0) @binding(10) var pairs: texture_2d<u32>;

fn pair_footprint(pair: u32) -> u32 {
    return textureLoad(pairs, record_texel(pair), 0).g;
}
