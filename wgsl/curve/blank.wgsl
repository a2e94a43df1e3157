// Tiles without a node. New curves are zeros, which are nodes that are unused: a tile that never had a caster
// is not stored. With pages, tiles without casters share one that is zeros.

import package::bind::changed::drawn_tiles;
import package::bind::sampled::opaques;
import package::features::HAS_PAGES;
import package::records::view::{GpuView, TILE_SIZE};

// Whether the curves of a tile are still zeros and stay so. `texel`: in the view's map.
fn stays_blank(view: GpuView, texel: vec2<u32>, has_casters: bool) -> bool {
    if HAS_PAGES {
        return !has_casters;
    }
    let size = textureDimensions(opaques) / TILE_SIZE;
    let at = (view.origin + texel) / TILE_SIZE;
    let tile = (view.layer * size.y + at.y) * size.x + at.x;
    if has_casters {
        drawn_tiles[tile] = 1u;
        return false;
    }
    return drawn_tiles[tile] == 0u;
}
