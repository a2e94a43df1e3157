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

// A run of tiles. llvmpipe executes a walk's code, and all stores, even where no lane takes them, but leaves
// a loop at its end: empty tiles and others are stored in a loop each, which tests at its end whether there
// is one more. A tile is one share.
fn walk_tiles(number_of_run: u32, first_share: u32, step: u32, lane: u32) {
    let in_tile = share_texel(0u, lane);
    // Tiles of a part are not one behind the other.
    let count = select(TILE_RUN, 1u, dispatches[PARTED_DISPATCH].x != 0u);
    let first = number_of_run * count;
    var empty = 0u; // a bit for each tile
    var walked = 0u;
    for (var i = 0u; i < unrolled(TILE_RUN); i += 1u) {
        let tile = tile_at(first + min(i, count - 1u));
        let stays = stays_empty(views[tile.view], tile.position * TILE_SIZE + in_tile, tile);
        let bit = select(0u, 1u << i, (i < count) & (tile.merged == 0u));
        empty |= select(0u, bit, stays);
        walked |= select(bit, 0u, stays);
    }
    loop {
        if empty != 0u {
            let tile = tile_at(first + firstTrailingBit(empty));
            store_empty(views[tile.view], tile.position * TILE_SIZE + in_tile);
            empty &= empty - 1u;
        }
        if empty == 0u {
            break;
        }
    }
    loop {
        if walked != 0u {
            let tile = tile_at(first + firstTrailingBit(walked));
            walk_tile_share(views[tile.view], tile, in_tile);
            walked &= walked - 1u;
        }
        if walked == 0u {
            break;
        }
    }
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
