// Walks a tile's soft discs front to back; every invocation visits every disc. The core tier,
// without subgroups.

import package::bind::loaded::{footprints, pairs};
import package::hit::disc::prepare_disc;
import package::records::record::{FOOTPRINT_TEXELS, record_texel};
import package::records::tile_rect::INVISIBLE;
import package::records::view::GpuView;
import package::state::discs::{settled, visit_disc};

fn walk(view: GpuView, first: u32, end: u32) {
    for (var pair = first; pair < end; pair += 1u) {
        let at = textureLoad(pairs, record_texel(pair)).g * FOOTPRINT_TEXELS;
        let look = textureLoad(footprints, record_texel(at + 1u));
        visit_disc(view, prepare_disc(view, textureLoad(footprints, record_texel(at)), look));
        if settled(f32(look.z >> 16u) / f32(INVISIBLE - 1u)) {
            break;
        }
    }
}
