// Texels of a 16x16 tile that an invocation keeps in registers: some in a column. Eight consecutive
// invocations hold 8 x ROWS texels, and the next eight the texels below: a subgroup is a compact block that
// culls casters for itself, and its loads and stores are runs of a row.

import package::records::view::{GpuView, TILE_SIZE};
import choice::accumulator::ROWS;

const LANES: u32 = 256u / ROWS;

fn lane_texel(lane: u32) -> vec2<u32> {
    let below = (lane / 8u) * ROWS;
    return vec2((below / TILE_SIZE) * 8u + lane % 8u, below % TILE_SIZE);
}

// First texel of tile number `tile` of the batch, in its view's map.
fn tile_texel(view: GpuView, tile: u32) -> vec2<u32> {
    let index = tile - view.first_tile;
    return vec2(index % view.tiles_x, index / view.tiles_x) * TILE_SIZE;
}

// Index of a texel of a tile among the batch's sums.
fn sum_index(tile: u32, in_tile: vec2<u32>) -> u32 {
    return (tile * TILE_SIZE + in_tile.y) * TILE_SIZE + in_tile.x;
}
