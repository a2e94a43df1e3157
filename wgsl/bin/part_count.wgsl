// bin, where pairs did not fit: number of pairs of every tile of the batch, and the bands of tiles that each
// footprint may touch. One workgroup per 32 footprints in depth order. Rust: src/shadows/batch/parts.rs.

import package::bin::part_band::{BANDS, band_of};
import package::bind::changed::tile_pairs;
import package::bind::loaded::{rects, sorted};
import package::bind::stored::keys;
import package::bind::uniform::{bin_params, views};
import package::features::HAS_GAUSSIANS;
import package::records::bin::{covers, rect_count};
import package::records::dispatch::workgroup_number;
import package::records::outline::{Outline, is_outlined, is_within, load_outline};
import package::records::record::record_texel;

const LANES: u32 = 32u;

fn footprint_of(index: u32) -> u32 {
    return textureLoad(sorted, record_texel(min(index, bin_params.footprint_count - 1u))).g;
}

fn rect_of(index: u32) -> vec2<u32> {
    let rect = textureLoad(rects, record_texel(footprint_of(index))).rg;
    return select(vec2(0u), rect, index < bin_params.footprint_count);
}

fn add_tile(rect: vec2<u32>, outline: Outline, corner: vec2<u32>, width: u32, height: u32, k: u32) {
    let view = rect.y >> 16u;
    let tile = corner + vec2(k % width, k / width);
    let is_outside = HAS_GAUSSIANS && is_outlined(rect) && !is_within(outline, rect, tile);
    if k < width * height && covers(rect, view, tile) && !is_outside {
        atomicAdd(&tile_pairs[views[view].first_tile + tile.y * views[view].tiles_x + tile.x], 1u);
    }
}

// First and last band that the rectangle may touch; none if the first is larger.
fn bands_of(rect: vec2<u32>) -> vec2<u32> {
    let view = views[rect.y >> 16u];
    let first = view.first_tile + ((rect.x >> 8u) & 255u) * view.tiles_x + (rect.x & 255u);
    let last = view.first_tile + (rect.x >> 24u) * view.tiles_x + ((rect.x >> 16u) & 255u);
    return select(vec2(BANDS, 0u), vec2(band_of(first), band_of(last)), rect_count(rect) > 0u);
}

@compute @workgroup_size(LANES)
fn part_count(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let first = workgroup_number(workgroup, workgroups) * LANES;
    if first >= bin_params.footprint_count {
        return;
    }
    let lane_rect = rect_of(first + lane);
    let corner = vec2(lane_rect.x & 255u, (lane_rect.x >> 8u) & 255u);
    let width = ((lane_rect.x >> 16u) & 255u) - corner.x + 1u;
    let height = select(0u, (lane_rect.x >> 24u) - corner.y + 1u, rect_count(lane_rect) > 0u);
    var outline: Outline;
    if HAS_GAUSSIANS && is_outlined(lane_rect) {
        outline = load_outline(footprint_of(first + lane));
    }
    // Two tiles a turn: a map has more tiles than the turns that llvmpipe allows an invocation.
    for (var k = 0u; k < width * height; k += 2u) {
        add_tile(lane_rect, outline, corner, width, height, k);
        add_tile(lane_rect, outline, corner, width, height, k + 1u);
    }
    var words = vec2(0u);
    for (var i = 0u; i < LANES; i += 1u) {
        let bands = bands_of(rect_of(first + i));
        let even = bands.x <= 2u * lane && 2u * lane <= bands.y;
        let odd = bands.x <= 2u * lane + 1u && 2u * lane + 1u <= bands.y;
        words |= select(vec2(0u), vec2(1u << i), vec2(even, odd));
    }
    textureStore(keys, record_texel(first + lane), vec4(words, 0u, 0u));
}
