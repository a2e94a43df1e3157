// Footprints from `footprints`.

import package::bind::sampled::footprints;
import package::features::SETUPS_IN_ORDER;
import package::records::footprint::{Footprint, footprint_of};
import package::records::record::{FOOTPRINT_TEXELS, record_texel};

fn load_footprint(id: u32) -> Footprint {
    let at = id * FOOTPRINT_TEXELS;
    var footprint = footprint_of(
        textureLoad(footprints, record_texel(at), 0),
        textureLoad(footprints, record_texel(at + 1u), 0),
    );
    if SETUPS_IN_ORDER {
        // A setup can then be loaded without waiting for the footprint.
        footprint.look.x = id;
    }
    return footprint;
}
