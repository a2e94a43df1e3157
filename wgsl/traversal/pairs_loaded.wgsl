// Pairs of a tile, front to back, on the native tier.

import package::bind::loaded::pairs;
import package::records::record::record_texel;

fn pair_footprint(pair: u32) -> u32 {
    return textureLoad(pairs, record_texel(pair)).g;
}
