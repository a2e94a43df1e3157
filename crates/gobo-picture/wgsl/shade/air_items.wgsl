// air: blocks of columns, and the runs of their slices that are lit. Rust:
// crates/gobo-picture/src/stage/air.rs.

import package::bind::picture_in::{air_params, band, seen_pixels};
import package::bind::picture_out::{air_ends, air_items};
import package::bind::uniform::views;
import package::hit::coplanar::COPLANAR;
import package::records::picture::AIR_CELL;
import package::records::record::record_texel;
import package::records::view::TILE_SIZE;
import package::shade::air::air_place;

// Blocks of columns of air, and the items that are lit: runs of slices of a block. `air_items` holds the
// workgroups of a dispatch over the items in x, y and z, the number of items, and then the items.

const AIR_BLOCK: u32 = 4u;    // edge of a block [columns]
const AIR_RUN: u32 = 4u;      // slices of a run
const MAX_AIR_RUNS: u32 = 64u; // runs of a block

const ITEM_HEAD: u32 = 4u; // words
const ITEM_COUNT: u32 = 3u;

// Blocks of columns of air that the pixels of a band see: those of its tiles, and one around them.

const MAX_WORKGROUPS: u32 = 65535u; // workgroups in a row on every adapter

// Columns of the picture.
fn air_size() -> vec2<u32> {
    return (vec2<u32>(views[0].size) + AIR_CELL - 1u) / AIR_CELL;
}

fn band_blocks() -> vec2<u32> {
    return band.size + 2u;
}

// First column of a block of the band; for a block in front of the picture, beyond its end.
fn block_column(number: u32) -> vec2<u32> {
    let width = band_blocks().x;
    return (band.origin - 1u + vec2(number % width, number / width)) * AIR_BLOCK;
}

// Workgroups in y of a dispatch over the items.
fn item_rows() -> u32 {
    let blocks = band_blocks();
    return blocks.x * blocks.y * ((air_params.slices + AIR_RUN - 1u) / AIR_RUN) / MAX_WORKGROUPS + 1u;
}

const REACH_LANES: u32 = 64u;
const COLUMNS: u32 = AIR_BLOCK * AIR_BLOCK; // of a block
// Pixels around a block that may read it: a column and a half, and the shift of the columns.
const AROUND: u32 = 8u;
const EDGE: u32 = AIR_BLOCK * AIR_CELL + 2u * AROUND; // of the searched area [pixels]

var<workgroup> reached: array<atomic<u32>, COLUMNS>; // slices
var<workgroup> last: atomic<u32>;
var<workgroup> unlit: atomic<u32>; // slices behind the first one that is not lit

// Number of slices read in front of a surface at a light depth, or of a face in its plane.
fn slices_before(depth: f32) -> u32 {
    let farthest = min(depth + 2.0 * COPLANAR * depth, 1.0);
    return min(u32(farthest * f32(air_params.slices)) + 1u, air_params.slices);
}

fn reach(column: vec2<i32>, first: vec2<i32>, slices: u32) {
    let at = column - first;
    if all(at >= vec2(0)) && all(at < vec2(i32(AIR_BLOCK))) {
        atomicMax(&reached[u32(at.y) * AIR_BLOCK + u32(at.x)], slices);
    }
}

// air, reach: the slices of each column that the pixels of a band need, beyond those that earlier bands
// needed, and a list of them: slices behind all surfaces are not lit. One workgroup per block of columns.
@compute @workgroup_size(REACH_LANES)
fn air_reach(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let columns = air_size();
    let number = workgroup.y * band_blocks().x + workgroup.x;
    let first = block_column(number);
    let is_seen = all(first < columns);
    if is_seen {
        let view = views[0];
        let size = vec2<u32>(view.size);
        for (var i = lane; i < EDGE * EDGE; i += REACH_LANES) {
            let pixel = first * AIR_CELL + vec2(i % EDGE, i / EDGE) - AROUND;
            let tile = pixel / TILE_SIZE - band.origin;
            if all(pixel < size) && all(tile < band.size) {
                let texel = pixel % TILE_SIZE;
                let index = ((tile.y * band.size.x + tile.x) * TILE_SIZE + texel.y) * TILE_SIZE + texel.x;
                let depth = bitcast<f32>(textureLoad(seen_pixels, record_texel(index), 0).x);
                let slices = slices_before(depth);
                let place = air_place(view, vec2<f32>(pixel) + 0.5, vec2<i32>(columns));
                let corner = vec2<i32>(first);
                reach(place.low, corner, slices);
                reach(vec2(place.high.x, place.low.y), corner, slices);
                reach(vec2(place.low.x, place.high.y), corner, slices);
                reach(place.high, corner, slices);
            }
        }
    }
    workgroupBarrier();
    let column = first + vec2(lane % AIR_BLOCK, lane / AIR_BLOCK);
    if lane < COLUMNS && all(column < columns) {
        let index = column.y * columns.x + column.x;
        let before = air_ends[index] & 0xffffu;
        let now = max(before, atomicLoad(&reached[lane]));
        air_ends[index] = now | (before << 16u);
        if now > before {
            atomicMax(&last, now);
            atomicMax(&unlit, air_params.slices - before);
        }
    }
    workgroupBarrier();
    let end = atomicLoad(&last);
    if lane == 0u && end > 0u {
        let run = (air_params.slices - atomicLoad(&unlit)) / AIR_RUN;
        let count = (end + AIR_RUN - 1u) / AIR_RUN - run;
        let slot = atomicAdd(&air_items[ITEM_COUNT], count);
        for (var i = 0u; i < count; i += 1u) {
            atomicStore(&air_items[ITEM_HEAD + slot + i], number * MAX_AIR_RUNS + run + i);
        }
        let rows = item_rows();
        atomicMax(&air_items[0], (slot + count + rows - 1u) / rows);
        atomicStore(&air_items[1], rows);
        atomicStore(&air_items[2], 1u);
    }
}
