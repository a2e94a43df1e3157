// Pairs of a tile, front to back, on tiers with four storage textures.

import package::bind::sampled::pairs;
import package::records::record::record_texel;

fn pair_footprint(pair: u32) -> u32 {
    return textureLoad(pairs, record_texel(pair), 0).g;
}
