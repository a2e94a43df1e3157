// Entry points over tiles and segments of a list. Rust: src/stage/mod.rs.

import package::bind::read::{dispatches, merged_tiles, overflow, segments};
import package::bind::uniform::views;
import package::records::batch::{
    MERGED_DISPATCH, OVERFLOW_DISPATCH, OVERFLOW_SLICES, workgroup_number,
};
import package::records::footprint::load_footprint;
import package::records::tile::{Segment, Tile, segment_view, tile_number_of};
import package::records::view::{GpuView, TILE_SIZE};
import package::traversal::lane::{lane_texel, tile_texel};
import choice::accumulator::{ROWS, start};
import choice::order::tile_number;
import choice::output::{add, before_segment, before_tile, resolve, store_segment, store_tile};
import choice::records::{rect_record, tile_at};
import choice::tiles::walk_tiles;
import choice::traversal::walk;

// Shares of a tile's texels: a workgroup takes one at a time.

const SHARE_LANES: u32 = min(256u / ROWS, 64u);
const SHARES: u32 = 256u / (SHARE_LANES * ROWS);

fn share_texel(share: u32, lane: u32) -> vec2<u32> {
    return lane_texel(share * SHARE_LANES + lane);
}

// Entry: every tile that one workgroup finishes, or several, each some of its texels. No atomics. An
// accumulator defines what is gathered per texel, an output where it goes.
@compute @workgroup_size(SHARE_LANES)
fn walk_tile(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    walk_tiles(tile_number(workgroup, workgroups), workgroup.z, workgroups.z, lane);
}

// `in_tile`: the invocation's first texel.
fn walk_tile_share(view: GpuView, tile: Tile, in_tile: vec2<u32>) {
    let texel = tile.position * TILE_SIZE + in_tile;
    before_tile(view, texel, tile);
    start(view, texel);
    walk(view, tile.first, tile.end);
    store_tile(view, texel);
}

// Entry: one segment of a long tile. One workgroup per segment, a column of texels per invocation. An
// accumulator defines what is gathered per texel, an output where it goes: to the tile's sums by atomics,
// because segments of a tile run in parallel, or to the segment's own record.
@compute @workgroup_size(SHARE_LANES)
fn walk_segment(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = workgroup_number(workgroup, workgroups);
    if index >= segments.count {
        return;
    }
    let segment = segments.all[index];
    let view = views[segment_view(segment)];
    if SHARES == 1u {
        walk_segment_share(view, segment, index, share_texel(0u, lane));
        return;
    }
    for (var share = workgroup.z; share < SHARES; share += workgroups.z) {
        walk_segment_share(view, segment, index, share_texel(share, lane));
    }
}

// `in_tile`: the invocation's first texel.
fn walk_segment_share(view: GpuView, segment: Segment, index: u32, in_tile: vec2<u32>) {
    before_segment(index);
    start(view, tile_texel(view, segment.tile) + in_tile);
    walk(view, segment.first, segment.end);
    store_segment(segment, index, in_tile);
}

const OVERFLOW_LANES: u32 = 256u; // one per texel of a tile

// Entry: footprints whose pairs did not fit, added straight to the sums. One workgroup per footprint and
// slice of its tiles (a large map has 65,536 tiles, more than the turns that llvmpipe allows an invocation),
// one invocation per texel of a tile. The output defines `add`, which is called for every texel of the view
// that the footprint may touch.
@compute @workgroup_size(OVERFLOW_LANES)
fn scatter_overflow(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let slot = workgroup_number(workgroup, workgroups);
    if slot >= dispatches[OVERFLOW_DISPATCH].w {
        return;
    }
    let index = overflow[slot];
    let rect = rect_record(index);
    let view = views[rect.y >> 16u];
    let footprint = load_footprint(index);
    let first = vec2(rect.x & 255u, (rect.x >> 8u) & 255u);
    let last = vec2((rect.x >> 16u) & 255u, rect.x >> 24u);
    let width = last.x - first.x + 1u;
    let tile_count = width * (last.y - first.y + 1u);
    let in_tile = vec2(lane % TILE_SIZE, lane / TILE_SIZE);
    for (var k = workgroup.z; k < tile_count; k += OVERFLOW_SLICES) {
        let tile_xy = first + vec2(k % width, k / width);
        if all(tile_xy * TILE_SIZE + in_tile < vec2<u32>(view.size)) {
            add(view, footprint, tile_xy, in_tile);
        }
    }
}

// Entry: resolves the tiles that several workgroups or the scatter path added to. One workgroup per tile, a
// column of texels per invocation; the output makes maps from the sums and resets these to zero.
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
    let tile = tile_at(merged_tiles[slot]);
    let view = views[tile.view];
    if SHARES == 1u {
        resolve(view, tile, tile_number_of(view, tile), share_texel(0u, lane));
        return;
    }
    for (var share = workgroup.z; share < SHARES; share += workgroups.z) {
        resolve(view, tile, tile_number_of(view, tile), share_texel(share, lane));
    }
}
