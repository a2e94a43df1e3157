// Texels of a 16x16 tile that an invocation keeps in registers: some in a column. Eight consecutive
// invocations hold 8 x ROWS texels, and the next eight the texels below: a subgroup is a compact block that
// culls casters for itself, and its loads and stores are runs of a row.

import package::features::WIDE;
import package::records::view::{GpuView, TILE_SIZE};
import choice::accumulator::{ROWS, corner};

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

// A subgroup that walks pairs: its block of texels, and the lanes of a ballot.

const ALL_LANES: vec2<u32> = vec2(0xffffffffu);

struct Block {
    lane: u32,     // of the invocation
    size: u32,     // lanes
    // First texel of the block, and of its last lane. As integers, which GPUs keep once for all lanes.
    first: vec2<u32>,
    last: vec2<u32>,
}

// Bounds of a block's texel centres.
fn block_low(block: Block) -> vec2<f32> {
    return vec2<f32>(block.first) + 0.5;
}

fn block_high(block: Block) -> vec2<f32> {
    return vec2<f32>(block.last) + vec2(0.5, f32(ROWS) - 0.5);
}

// An index that all lanes share, in a form that compilers recognise.
fn shared_index(index: u32) -> u32 {
    return subgroupBroadcastFirst(index);
}

// Lanes follow each other in rows of blocks, so the first and the last lane hold the block's corners.
fn subgroup_block() -> Block {
    let all_lanes = subgroupBallot(true);
    let size = countOneBits(all_lanes.x) + countOneBits(all_lanes.y);
    let texel = vec2<u32>(corner);
    return Block(
        subgroupExclusiveAdd(1u),
        size,
        subgroupBroadcastFirst(texel),
        subgroupBroadcastFirst(subgroupShuffle(texel, size - 1u)),
    );
}

fn has_lanes(ballot: vec2<u32>) -> bool {
    return select(ballot.x, ballot.x | ballot.y, WIDE) != 0u;
}

fn has_lane(ballot: vec2<u32>, lane: u32) -> bool {
    if !WIDE {
        return ((ballot.x >> lane) & 1u) != 0u;
    }
    return ((select(ballot.x, ballot.y, lane >= 32u) >> (lane & 31u)) & 1u) != 0u;
}

fn first_lane(ballot: vec2<u32>) -> u32 {
    if !WIDE {
        return firstTrailingBit(ballot.x);
    }
    return select(32u + firstTrailingBit(ballot.y), firstTrailingBit(ballot.x), ballot.x != 0u);
}

fn without_first(ballot: vec2<u32>) -> vec2<u32> {
    if !WIDE {
        return vec2(ballot.x & (ballot.x - 1u), 0u);
    }
    return select(
        vec2(0u, ballot.y & (ballot.y - 1u)),
        vec2(ballot.x & (ballot.x - 1u), ballot.y),
        ballot.x != 0u,
    );
}
