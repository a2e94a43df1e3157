// colored, resolve: opaque depths by channel of the tiles that several workgroups or the scatter
// path added to. Leaves the sums zero. One workgroup per tile, four texels per invocation. CPU
// twin: src/reference/colored.rs. Host: src/stage/colored.rs.

import package::bind::read::{dispatches, merged_tiles};
import package::bind::sampled::tiles;
import package::bind::stored::{colored, opaques};
import package::bind::uniform::views;
import package::hit::small::small_depth;
import package::records::dispatch::MERGED_DISPATCH;
import package::records::record::record_texel;
import package::records::tile::tile_of;
import package::records::view::TILE_SIZE;
import package::sums::sums::nearness_to_depth;
import package::walk::lane::{LANES, lane_texel, sum_index};
import choice::sums::{clear_sums, load_sums};

@compute @workgroup_size(LANES)
fn colored_resolve(
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
        let at = tile.place * TILE_SIZE + place + vec2(0u, i);
        let sums = load_sums(sum);
        let added =
            vec3(nearness_to_depth(sums.r), nearness_to_depth(sums.g), nearness_to_depth(sums.b));
        let depths = min(added, vec3(small_depth(view, at)));
        let last = max(max(depths.r, depths.g), depths.b);
        textureStore(opaques, view.origin + at, view.layer, vec4(last));
        textureStore(colored, view.origin + at, view.layer, vec4(depths, 1.0));
        clear_sums(sum);
    }
}
