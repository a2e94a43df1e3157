// Depth key of a pair of the tile.

import package::bind::loaded::footprints;
import package::records::footprint::footprint_key;
import package::records::record::{FOOTPRINT_TEXELS, record_texel};
import choice::pairs::pair_footprint;

fn pair_key(pair: u32) -> u32 {
    let at = pair_footprint(pair) * FOOTPRINT_TEXELS;
    return footprint_key(textureLoad(footprints, record_texel(at + 1u)));
}
