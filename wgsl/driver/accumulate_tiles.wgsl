// accumulate, tiles: filter and nearest depth of every tile that one workgroup finishes. One
// workgroup per tile, a column of texels per invocation, no atomics. CPU twin:
// src/reference/accumulate.rs. Host: src/stage/accumulate.rs.

import package::bind::sampled::tiles;
import package::bind::uniform::views;
import package::features::HAS_OWNERS;
import package::records::owner::{tagged_alpha, tagged_depth};
import package::records::record::record_texel;
import package::records::tile::{interleaved, tile_of};
import package::records::view::TILE_SIZE;
import package::sums::sums::blackened;
import package::walk::lane::{LANES, lane_texel};
import choice::maps::{plain_alpha, store_map};
import choice::rows::ROWS;
import choice::state::{nearest_texel, owner_texel, passed_texel, start};
import choice::walk::walk;

@compute @workgroup_size(LANES)
fn accumulate_tiles(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let tile_id = interleaved(workgroup, workgroups);
    let tile = tile_of(textureLoad(tiles, record_texel(tile_id), 0));
    if tile.merged != 0u {
        return;
    }
    let view = views[tile.view];
    let texel = tile.place * TILE_SIZE + lane_texel(lane);
    let alpha_of_none = plain_alpha(view.origin + texel, view.layer);
    start(view, texel);
    walk(view, tile.first, tile.end);
    for (var i = 0u; i < ROWS; i += 1u) {
        let at = view.origin + texel + vec2(0u, i);
        var nearest_depth = nearest_texel(i);
        var alpha = alpha_of_none;
        if HAS_OWNERS {
            alpha = tagged_alpha(owner_texel(i));
            nearest_depth = tagged_depth(nearest_depth, owner_texel(i));
        }
        store_map(at, view.layer, vec4(blackened(passed_texel(i)), alpha), nearest_depth);
    }
}
