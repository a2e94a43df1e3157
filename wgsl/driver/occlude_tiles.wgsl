// occlude, tiles: opaque depth of every tile that one workgroup finishes. One workgroup per tile, a
// column of texels per invocation; no clip and no blending, only a minimum in registers. CPU twin:
// src/reference/occlude.rs. Host: src/stage/occlude.rs.

import package::bind::sampled::tiles;
import package::bind::stored::opaques;
import package::bind::uniform::views;
import package::hit::small::small_depth;
import package::records::record::record_texel;
import package::records::tile::{interleaved, tile_of};
import package::records::view::TILE_SIZE;
import package::walk::lane::{LANES, lane_texel};
import choice::rows::ROWS;
import choice::state::{nearest_texel, start};
import choice::walk::walk;

@compute @workgroup_size(LANES)
fn occlude_tiles(
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
    start(view, texel);
    walk(view, tile.first, tile.end);
    for (var i = 0u; i < ROWS; i += 1u) {
        let at = texel + vec2(0u, i);
        let depth = min(nearest_texel(i), small_depth(view, at));
        textureStore(opaques, view.origin + at, view.layer, vec4(depth));
    }
}
