// Entry: resolves the tiles that several workgroups or the scatter path added to. One workgroup per tile,
// a column of texels per invocation; the output makes maps from the sums and resets these to zero. Rust:
// src/stage/mod.rs.

import package::bind::read::{dispatches, merged_tiles};
import package::bind::sampled::tiles;
import package::bind::uniform::views;
import package::records::dispatch::{MERGED_DISPATCH, workgroup_number};
import package::records::record::record_texel;
import package::records::tile::{tile_number_of, tile_of};
import package::traversal::share::{SHARES, SHARE_LANES, share_texel};
import choice::output::resolve;

@compute @workgroup_size(SHARE_LANES)
fn resolve_tile(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let slot = workgroup_number(workgroup, workgroups);
    if slot >= dispatches[MERGED_DISPATCH].w {
        return;
    }
    let tile = tile_of(textureLoad(tiles, record_texel(merged_tiles[slot]), 0));
    let view = views[tile.view];
    if SHARES == 1u {
        resolve(view, tile, tile_number_of(view, tile), share_texel(0u, lane));
        return;
    }
    for (var share = workgroup.z; share < SHARES; share += workgroups.z) {
        resolve(view, tile, tile_number_of(view, tile), share_texel(share, lane));
    }
}
