// resolve, tiles: filter and nearest depth of the tiles that several workgroups or the scatter path
// added to; leaves the sums zero. One workgroup per tile, four texels per invocation. CPU twin:
// src/reference/resolve.rs. Host: src/stage/resolve.rs.

import package::bind::read::{dispatches, merged_tiles};
import package::bind::sampled::tiles;
import package::bind::stored::{filters, nearests};
import package::bind::uniform::views;
import package::records::dispatch::MERGED_DISPATCH;
import package::records::record::record_texel;
import package::records::tile::tile_of;
import package::records::view::TILE_SIZE;
import package::sums::sums::{blackened, light, nearness_to_depth};
import package::walk::lane::{LANES, lane_texel, sum_index};
import choice::sums::{clear_sums, load_nearness, load_sums};

@compute @workgroup_size(LANES)
fn resolve_tiles(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let slot = workgroup.y * workgroups.x + workgroup.x;
    if slot >= dispatches[MERGED_DISPATCH].w {
        return;
    }
    let tile_id = merged_tiles[slot];
    let tile = tile_of(textureLoad(tiles, record_texel(tile_id), 0));
    let view = views[tile.view];
    let place = lane_texel(lane);
    for (var i = 0u; i < 4u; i += 1u) {
        let sum = sum_index(tile_id, place + vec2(0u, i));
        let at = view.origin + tile.place * TILE_SIZE + place + vec2(0u, i);
        textureStore(filters, at, view.layer, vec4(blackened(light(load_sums(sum))), 1.0));
        textureStore(nearests, at, view.layer, vec4(nearness_to_depth(load_nearness(sum))));
        clear_sums(sum);
    }
}
