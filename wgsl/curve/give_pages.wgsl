// Pages of curves: those of the views that are rendered are put back, then each tile with casters gets one.
// If there are too few, no tile of the batch has one, so that maps do not depend on which came first. Rust:
// src/stage/curve.rs.

import package::bind::changed::{counters, free_pages};
import package::bind::read::dispatches;
import package::bind::uniform::{bin_params, views};
import package::bind::updated::curve_pages;
import package::curve::pages::{BLANK_PAGE, SHORT_PAGE};
import package::records::batch::{PARTED_DISPATCH, PART_DISPATCH};
import package::records::tile::Tile;
import package::records::view::TILE_SIZE;
import choice::records::tile_at;

// Puts a page back. `free_pages` has the number of free pages, then these.
fn put_back(page: u32) {
    if page > SHORT_PAGE {
        let slot = atomicAdd(&free_pages[0], 1u) + 1u;
        atomicStore(&free_pages[slot], page);
    }
}

// curve, release pages: puts back those of the views. One invocation per tile.
@compute @workgroup_size(8, 8)
fn release_pages(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = views[id.z];
    if any(id.xy >= vec2<u32>(view.size + f32(TILE_SIZE - 1u)) / TILE_SIZE) {
        return;
    }
    let at = view.origin / TILE_SIZE + id.xy;
    put_back(textureLoad(curve_pages, at, view.layer).x);
    textureStore(curve_pages, at, view.layer, vec4(BLANK_PAGE));
}

// Tiles that were binned: all, or those of a part.
fn tile_count() -> u32 {
    let of_part = dispatches[PARTED_DISPATCH].w - dispatches[PART_DISPATCH].w;
    return select(bin_params.tile_count, of_part, dispatches[PARTED_DISPATCH].x != 0u);
}

fn has_casters(tile: Tile) -> bool {
    return (tile.first < tile.end) | tile.scattered;
}

// curve, give pages: one to each tile with casters, as long as there are any. One invocation per tile.
@compute @workgroup_size(64)
fn give_pages(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= tile_count() {
        return;
    }
    let tile = tile_at(id.x);
    if !has_casters(tile) {
        return;
    }
    let view = views[tile.view];
    let count = atomicSub(&free_pages[0], 1u);
    var page = SHORT_PAGE;
    // Below zero others have taken the last ones.
    if bitcast<i32>(count) > 0 {
        page = atomicLoad(&free_pages[count]);
    } else {
        atomicAdd(&free_pages[0], 1u);
        atomicAdd(&counters.short_tiles, 1u);
    }
    textureStore(curve_pages, view.origin / TILE_SIZE + tile.position, view.layer, vec4(page));
}

// curve, settle pages: takes all back if some tile got none. One invocation per tile.
@compute @workgroup_size(64)
fn settle_pages(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= tile_count()) | (atomicLoad(&counters.short_tiles) == 0u) {
        return;
    }
    let tile = tile_at(id.x);
    let view = views[tile.view];
    let at = view.origin / TILE_SIZE + tile.position;
    let page = textureLoad(curve_pages, at, view.layer).x;
    if page > SHORT_PAGE {
        put_back(page);
        atomicAdd(&counters.short_tiles, 1u);
        textureStore(curve_pages, at, view.layer, vec4(SHORT_PAGE));
    }
}
