// Walks a tile's pairs front to back; every invocation visits every pair. The core tier, without
// subgroups. The kernel says what to do in `visit` and when to stop in `settled`.

import package::bind::loaded::{footprints, pairs};
import package::records::footprint::front_depth;
import package::records::record::{FOOTPRINT_TEXELS, record_texel};
import package::records::view::GpuView;
import choice::state::{settled, visit};

fn walk(view: GpuView, first: u32, end: u32) {
    for (var pair = first; pair < end; pair += 1u) {
        let footprint = textureLoad(pairs, record_texel(pair)).g;
        let at = footprint * FOOTPRINT_TEXELS;
        let look = textureLoad(footprints, record_texel(at + 1u));
        visit(view, footprint, textureLoad(footprints, record_texel(at)), look);
        if settled(front_depth(look)) {
            break;
        }
    }
}
