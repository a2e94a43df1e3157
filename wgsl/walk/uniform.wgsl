// Walks a tile's pairs front to back; every invocation visits every pair. The core tier, without subgroups.
// The state defines `visit`, and when to stop in `settled`.

import package::bind::loaded::pairs;
import package::records::footprint::front_depth;
import package::records::footprint_loaded::load_footprint;
import package::records::record::record_texel;
import package::records::view::GpuView;
import choice::state::{settled, visit};

fn walk(view: GpuView, first: u32, end: u32) {
    for (var pair = first; pair < end; pair += 1u) {
        let id = textureLoad(pairs, record_texel(pair)).g;
        let footprint = load_footprint(id);
        visit(view, id, footprint);
        if settled(front_depth(footprint)) {
            break;
        }
    }
}
