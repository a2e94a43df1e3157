// Walks a tile's opaque triangles front to back; every invocation visits every triangle. The core
// tier, without subgroups.

import package::bind::loaded::{footprints, pairs};
import package::records::record::{FOOTPRINT_TEXELS, record_texel};
import package::records::tile_rect::INVISIBLE;
import package::records::view::GpuView;
import package::state::triangles::{load_sheet, settled, visit_sheet};

fn walk(view: GpuView, first: u32, end: u32) {
    for (var pair = first; pair < end; pair += 1u) {
        let at = textureLoad(pairs, record_texel(pair)).g * FOOTPRINT_TEXELS;
        let look = textureLoad(footprints, record_texel(at + 1u));
        visit_sheet(load_sheet(look.x));
        if settled(f32(look.z >> 16u) / f32(INVISIBLE - 1u)) {
            break;
        }
    }
}
