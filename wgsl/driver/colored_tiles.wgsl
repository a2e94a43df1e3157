// colored, tiles: nearest opaque depth of each channel, of the tiles that one workgroup finishes.
// Four texels per invocation. CPU twin: src/reference/colored.rs. Host: src/stage/colored.rs.

import package::bind::sampled::tiles;
import package::bind::stored::{colored, opaques};
import package::bind::uniform::views;
import package::hit::blocks_colored::last_depth;
import package::hit::small::small_depth;
import package::records::record::record_texel;
import package::records::tile::{interleaved, tile_of};
import package::records::view::TILE_SIZE;
import package::state::colored::{nearest, start};
import package::walk::lane::{LANES, lane_texel};
import choice::walk::walk;

@compute @workgroup_size(LANES)
fn colored_tiles(
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
    for (var i = 0u; i < 4u; i += 1u) {
        let at = texel + vec2(0u, i);
        let depths = min(nearest[i], vec3(small_depth(view, at)));
        textureStore(opaques, view.origin + at, view.layer, vec4(last_depth(depths)));
        textureStore(colored, view.origin + at, view.layer, vec4(depths, 1.0));
    }
}
