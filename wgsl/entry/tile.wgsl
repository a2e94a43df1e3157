// Entry: every tile that one workgroup finishes. One workgroup per tile, a column of texels per
// invocation, no atomics. A state defines what is gathered per texel, a store where it goes. Host:
// src/stage/mod.rs.

import package::bind::sampled::tiles;
import package::bind::uniform::views;
import package::records::record::record_texel;
import package::records::tile::{tile_number_of, tile_of};
import package::records::view::TILE_SIZE;
import package::traversal::lane::{LANES, lane_texel};
import choice::order::tile_number;
import choice::accumulator::start;
import choice::output::{before_tile, store_tile};
import choice::traversal::walk;

@compute @workgroup_size(LANES)
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
    let place = lane_texel(lane);
    let texel = tile.place * TILE_SIZE + place;
    before_tile(view, texel, tile_number_of(view, tile), place);
    start(view, texel);
    walk(view, tile.first, tile.end);
    store_tile(view, texel);
}
