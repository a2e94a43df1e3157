// Entry: every tile that one workgroup finishes, or several, each some of its texels. No atomics. An
// accumulator defines what is gathered per texel, an output where it goes. Rust: src/stage/mod.rs.

import package::bind::sampled::tiles;
import package::bind::uniform::views;
import package::records::record::record_texel;
import package::records::tile::{Tile, tile_number_of, tile_of};
import package::records::view::{GpuView, TILE_SIZE};
import package::traversal::share::{SHARES, SHARE_LANES, share_texel};
import choice::order::tile_number;
import choice::accumulator::start;
import choice::output::{before_tile, store_tile};
import choice::traversal::walk;

@compute @workgroup_size(SHARE_LANES)
fn walk_tile(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let record = record_texel(tile_number(workgroup, workgroups));
    let tile = tile_of(textureLoad(tiles, record, 0));
    if tile.merged != 0u {
        return;
    }
    let view = views[tile.view];
    if SHARES == 1u {
        walk_share(view, tile, share_texel(0u, lane));
        return;
    }
    for (var share = workgroup.z; share < SHARES; share += workgroups.z) {
        walk_share(view, tile, share_texel(share, lane));
    }
}

// `in_tile`: the invocation's first texel.
fn walk_share(view: GpuView, tile: Tile, in_tile: vec2<u32>) {
    let texel = tile.position * TILE_SIZE + in_tile;
    before_tile(view, texel, tile_number_of(view, tile), in_tile);
    start(view, texel);
    walk(view, tile.first, tile.end);
    store_tile(view, texel);
}
