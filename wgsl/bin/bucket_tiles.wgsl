// bin, buckets: the tiles of each footprint, in any order, first to be counted, then to be written;
// `choice::bucket` says which. One workgroup per 64 footprints, whose tiles its lanes share. CPU reference:
// crates/gobo-reference/src/bin.rs. Rust: src/stage/bin.rs.

import package::bin::shared_tiles::{ends, lane_of, nth_tile, take, taken};
import package::bind::loaded::rects;
import package::bind::uniform::{bin_params, views};
import package::features::HAS_GAUSSIANS;
import package::records::bin::rect_count;
import package::records::outline::{is_outlined, load_outline, outline_farthest, outlined_columns};
import package::records::record::record_texel;
import package::scan::prefix::SCAN_LANES;
import choice::bucket::{put_tile, see};
import choice::scan::prefix_sum;

// The tiles of a Gaussian whose rectangle is large.
fn put_outlined(rect: vec2<u32>, footprint: u32) {
    let view = views[rect.y >> 16u];
    let outline = load_outline(footprint);
    let farthest = outline_farthest(outline);
    for (var row = (rect.x >> 8u) & 255u; row <= (rect.x >> 24u); row += 1u) {
        let columns = outlined_columns(outline, farthest, row, rect.x);
        for (var x = columns.x; x < columns.y; x += 1u) {
            put_tile(view.first_tile + row * view.tiles_x + x, footprint);
        }
    }
}

@compute @workgroup_size(SCAN_LANES)
fn bucket_tiles(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let footprint = id.x;
    var rect = vec2(0u);
    if footprint < bin_params.footprint_count {
        rect = textureLoad(rects, record_texel(footprint)).rg;
    }
    let count = rect_count(rect);
    see(count);
    let prefix = prefix_sum(lane, count);
    let outlined = HAS_GAUSSIANS && is_outlined(rect);
    take(lane, footprint, rect, prefix.before + count, !outlined);
    workgroupBarrier(); // all have taken one
    for (var k = lane; k < prefix.total; k += SCAN_LANES) {
        let owner = lane_of(k);
        let source = taken[owner];
        if source.tiles_x > 0u {
            let before = select(0u, ends[max(owner, 1u) - 1u], owner > 0u);
            put_tile(nth_tile(source, k - before), source.footprint);
        }
    }
    if outlined {
        put_outlined(rect, footprint);
    }
}
