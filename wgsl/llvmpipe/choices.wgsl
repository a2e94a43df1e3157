// Choices of kernels that walk casters, on software adapters. GPUs: wgsl/choices.wgsl.

import package::bind::read::dispatches;
import package::bind::uniform::views;
import package::bind::updated::{filters, nearests};
import package::curve::node::packed_node;
import package::curve::ray::{ROWS, Texel, corner};
import package::entry::walk::{share_texel, walk_tile_share};
import package::features::{NODES, unrolled};
import package::records::batch::{PARTED_DISPATCH, workgroup_number};
import package::records::view::{GpuView, TILE_SIZE};
import choice::output::{is_blank, stays_empty, store_empty, store_nodes};
import choice::records::tile_at;

// Order of tiles for drivers that give each of two cores one half of the dispatch: runs of neighbours
// alternate between the cores. (Runs, because consecutive stores to memory are many times faster.)

const RUN: u32 = 64u; // tiles

fn tile_number(workgroup: vec3<u32>, workgroups: vec3<u32>) -> u32 {
    let i = workgroup_number(workgroup, workgroups);
    let count = workgroups.x * workgroups.y;
    let half_count = count / 2u;
    let second = i >= half_count;
    let index = select(i, i - half_count, second);
    let whole = count / (2u * RUN) * RUN; // tiles of each half, in whole runs
    let run = 2u * (index - index % RUN) + index % RUN + select(0u, RUN, second);
    return select(select(i + whole, i, second), run, index < whole);
}

const TILE_RUN: u32 = 4u; // Rust: src/stage/tuning.rs

// A run of tiles. llvmpipe executes a walk's code, and all stores, even where no lane takes them, but leaves a
// loop at its end: empty tiles and others are stored in a loop each, which tests at its end whether there is
// one more. A tile is one share.
fn walk_tiles(number_of_run: u32, first_share: u32, step: u32, lane: u32) {
    let in_tile = share_texel(0u, lane);
    // Tiles of a part are not one behind the other.
    let count = select(TILE_RUN, 1u, dispatches[PARTED_DISPATCH].x != 0u);
    let first = number_of_run * count;
    let end = first + count;
    var number = next_tile(first, end, in_tile, true);
    loop {
        if number < end {
            let tile = tile_at(number);
            store_empty(views[tile.view], tile.position * TILE_SIZE + in_tile);
        }
        number = next_tile(number + 1u, end, in_tile, true);
        if number >= end {
            break;
        }
    }
    number = next_tile(first, end, in_tile, false);
    loop {
        if number < end {
            let tile = tile_at(number);
            walk_tile_share(views[tile.view], tile, in_tile);
        }
        number = next_tile(number + 1u, end, in_tile, false);
        if number >= end {
            break;
        }
    }
}

// The first tile from `first` on that stays empty, or else that must be walked; `end` or more if there is
// none.
fn next_tile(first: u32, end: u32, in_tile: vec2<u32>, is_empty: bool) -> u32 {
    var number = first;
    var is_next = false;
    loop {
        let tile = tile_at(min(number, end - 1u));
        let view = views[tile.view];
        let stays = stays_empty(view, tile.position * TILE_SIZE + in_tile, tile);
        is_next = (tile.merged == 0u) & (stays == is_empty);
        number += u32(!is_next);
        if is_next | (number >= end) {
            break;
        }
    }
    return number;
}

// Texels of an invocation: four in a column. They share the costs of a visit that don't depend on the texel.

const ROW_COUNT: u32 = 4u;

// Texels in a column of an invocation whose casters are all of one simple kind: eight, which share the costs
// of a visit that don't depend on the texel. For software adapters.

const COLUMN_TEXELS: u32 = 8u;

// Stores a finished tile to the maps, on a software adapter: reads the texels before the tile is walked, so
// that their cache lines are present for the stores. Otherwise the stores, eight and more per lane, would
// wait for one line after the other. Lanes are neighbours in a row, eight to a block of eight rows.

// Alpha of texels without an owner tag. `texel`: the lane's first in the map; each lane fetches a row.
fn plain_alpha(texel: vec2<u32>, layer: u32) -> f32 {
    let lane = texel.x & 7u;
    let at = texel - vec2(lane, 0u) + vec2(0u, lane);
    let fetched = textureLoad(filters, at, layer).a + textureLoad(nearests, at, layer).r;
    // Keeps the prefetch from being optimised away: neither is negative, but compilers cannot know.
    return select(1.0, fetched, fetched < 0.0);
}

fn store_map(at: vec2<u32>, layer: u32, filtered: vec4<f32>, nearest: f32) {
    textureStore(filters, at, layer, filtered);
    textureStore(nearests, at, layer, vec4(nearest));
}

// Nodes are kept in registers, and stored after the walk: stores that some lanes wait for cost more.

const WALKS_APART: bool = true; // each walk has code of its own, without the state of the other

struct KeptNodes {
    nodes: array<vec2<u32>, 16>,
}

var<private> kept_nodes: array<KeptNodes, ROWS>;

fn put_node(view: GpuView, t: ptr<function, Texel>, i: u32, number: u32, node: vec2<u32>, is: bool) {
    for (var k = 0u; k < unrolled(NODES); k += 1u) {
        kept_nodes[i].nodes[k] = select(kept_nodes[i].nodes[k], node, is & (number == k));
    }
}

fn end_nodes(view: GpuView, t: ptr<function, Texel>, i: u32) {
    let unused = packed_node(0u, 0.0, vec3(1.0));
    for (var turn = u32(is_blank()); turn < 1u; turn += 1u) {
        for (var pair = 0u; pair < unrolled(NODES / 2u); pair += 1u) {
            let first = select(unused, kept_nodes[i].nodes[2u * pair], (*t).used > 2u * pair);
            let second = select(unused, kept_nodes[i].nodes[2u * pair + 1u], (*t).used > 2u * pair + 1u);
            store_nodes(view, corner, i, pair, vec4(first, second));
        }
    }
}
