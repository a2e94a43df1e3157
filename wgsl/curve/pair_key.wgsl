// Depth key of a pair of the tile.

import package::records::footprint::footprint_key;
import package::records::footprint_loaded::load_footprint;
import choice::pairs::pair_footprint;

fn pair_key(pair: u32) -> u32 {
    return footprint_key(load_footprint(pair_footprint(pair)));
}
