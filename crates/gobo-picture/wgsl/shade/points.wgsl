// Points for `light_points`, and their lists.

import package::bind::picture_in::band;
import package::bind::picture_out::{layered_tiles, point_lists, points};
import package::records::point::{POINT_TEXELS, Point, packed_point};
import package::records::point_list::{LIST_COUNT, LIST_HEAD, LIST_LENGTH, LIST_ROWS, POINT_LANES, list_first};
import package::records::record::record_texel;

// Writes a point for `light_points`.
fn store_point(index: u32, point: Point) {
    let texels = packed_point(point);
    let first = index * POINT_TEXELS;
    textureStore(points, record_texel(first), texels[0]);
    textureStore(points, record_texel(first + 1u), texels[1]);
    textureStore(points, record_texel(first + 2u), texels[2]);
    textureStore(points, record_texel(first + 3u), texels[3]);
}

// Lists of a band: appends points, and empties the lists.
fn empty_lists() {
    atomicStore(&layered_tiles[0], 0u);
    atomicStore(&layered_tiles[1], 1u);
    atomicStore(&layered_tiles[2], 1u);
    for (var list = 0u; list < LIST_COUNT; list += 1u) {
        let head = list * LIST_HEAD;
        atomicStore(&point_lists[head], 0u);
        atomicStore(&point_lists[head + 1u], LIST_ROWS);
        atomicStore(&point_lists[head + 2u], 1u);
        atomicStore(&point_lists[head + LIST_LENGTH], 0u);
    }
}

fn append_point(list: u32, point: u32) {
    let head = list * LIST_HEAD;
    let slot = atomicAdd(&point_lists[head + LIST_LENGTH], 1u);
    atomicStore(&point_lists[list_first(list, band.pixel_count) + slot], point);
    if slot % (LIST_ROWS * POINT_LANES) == 0u {
        atomicAdd(&point_lists[head], 1u);
    }
}
