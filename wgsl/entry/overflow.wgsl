// Entry: footprints whose pairs did not fit, added straight to the sums. One workgroup per footprint and
// slice of its tiles (a large map has 65,536 tiles, more than the turns that llvmpipe allows an invocation),
// one invocation per texel of a tile. The output defines `add`, which is called for every texel of the view
// that the footprint may touch. Rust: src/stage/mod.rs.

import package::bind::read::{dispatches, overflow};
import package::bind::sampled::rects;
import package::bind::uniform::views;
import package::records::dispatch::{OVERFLOW_DISPATCH, OVERFLOW_SLICES, workgroup_number};
import package::records::footprint_loaded::load_footprint;
import package::records::record::record_texel;
import package::records::view::TILE_SIZE;
import choice::output::add;

const OVERFLOW_LANES: u32 = 256u; // one per texel of a tile

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
    let rect = textureLoad(rects, record_texel(index), 0).rg;
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
