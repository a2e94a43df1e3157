// Pairs of a tile, front to back. Of the kernels of curves, on the native tier.
@group(0) @binding(10) var pairs: texture_storage_2d<rg32uint, read>;

fn pair_footprint(pair: u32) -> u32 {
    return textureLoad(pairs, record_texel(pair)).g;
}
