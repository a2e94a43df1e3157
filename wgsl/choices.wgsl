// Choices of kernels that walk casters, on GPUs. Software adapters: wgsl/llvmpipe/choices.wgsl.

import package::bind::stored::{curves, filters, nearests};
import package::bind::uniform::views;
import package::curve::list::Node;
import package::curve::node::packed_node;
import package::curve::ray::{Texel, corner};
import package::entry::walk::{SHARES, share_texel, walk_tile_share};
import package::features::NODES;
import package::records::batch::workgroup_number;
import package::records::view::GpuView;
import choice::output::{is_blank, store_nodes};
import choice::records::tile_at;

// Order of tiles: a workgroup takes the tile of its own index.
fn tile_number(workgroup: vec3<u32>, workgroups: vec3<u32>) -> u32 {
    return workgroup_number(workgroup, workgroups);
}

// A workgroup's tile, or some of its shares, from `first_share` on.
fn walk_tiles(number: u32, first_share: u32, step: u32, lane: u32) {
    let tile = tile_at(number);
    if tile.merged != 0u {
        return;
    }
    let view = views[tile.view];
    if SHARES == 1u {
        walk_tile_share(view, tile, share_texel(0u, lane));
        return;
    }
    for (var share = first_share; share < SHARES; share += step) {
        walk_tile_share(view, tile, share_texel(share, lane));
    }
}

// Texels of an invocation: one, because registers are scarce on GPUs, and fewer casters touch a subgroup's
// small block of texels.

const ROW_COUNT: u32 = 1u;

// Texels in a column of an invocation whose casters are all of one simple kind: two. So 32 lanes hold a
// square block, and smaller subgroups a smaller one, which fewer casters touch.

const COLUMN_TEXELS: u32 = 2u;

// Stores a finished tile to the maps, curves included.

// Alpha of texels without an owner tag.
fn plain_alpha(texel: vec2<u32>, layer: u32) -> f32 {
    return 1.0;
}

fn store_map(at: vec2<u32>, layer: u32, filtered: vec4<f32>, nearest: f32) {
    textureStore(filters, at, layer, filtered);
    textureStore(nearests, at, layer, vec4(nearest));
}

fn store_pair(at: vec2<u32>, layer: u32, pair: vec4<u32>) {
    textureStore(curves, at, layer, pair);
}

// Nodes of curves during insertion, in workgroup memory: each texel has its own, so that no invocation waits.

const NODE_LANES: u32 = 64u; // of a workgroup

// A vector would take a fourth word.
struct NodeWords {
    x: u32,
    y: u32,
    z: u32,
}

var<workgroup> nodes: array<array<NodeWords, NODE_LANES>, NODES + 1u>;
var<private> lane_slot: u32;
var<private> node_count: u32;
var<private> kept_light: vec3<f32>;

// `in_tile`: texel of the invocation; those of a workgroup are 8 x 8 neighbours.
fn open_nodes(in_tile: vec2<u32>) {
    lane_slot = (in_tile.y & 7u) * 8u + (in_tile.x & 7u);
    // Always `NODES`. Compilers must not know: they would unroll loops, with all nodes in registers.
    node_count = select(0u, NODES, views[0].tiles_x > 0u);
}

fn node_at(i: u32, k: u32) -> Node {
    let words = nodes[k][lane_slot];
    return Node(words.x, words.y, words.z);
}

fn set_node(i: u32, k: u32, node: Node) {
    nodes[k][lane_slot] = NodeWords(node.x, node.y, node.z);
}

// Keeps light between insertions in the node that is free then: after the merge where one is due.
fn lay_aside(i: u32, light: vec3<f32>, overfull: bool) {
    kept_light = light;
    if !overfull {
        lay_kept(i);
    }
}

fn lay_kept(i: u32) {
    set_node(i, NODES, bitcast<vec3<u32>>(kept_light));
}

fn laid_aside(i: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(node_at(i, NODES));
}

// Nodes are stored in pairs, as soon as both are written.

const WALKS_APART: bool = false; // one code for both walks takes fewer registers

fn put_node(view: GpuView, t: ptr<function, Texel>, i: u32, number: u32, node: vec2<u32>, is: bool) {
    if is && number % 2u == 1u {
        store_nodes(view, corner, i, number / 2u, vec4((*t).pending, node));
    }
    (*t).pending = select((*t).pending, node, is);
}

fn end_nodes(view: GpuView, t: ptr<function, Texel>, i: u32) {
    let unused = packed_node(0u, 0.0, vec3(1.0));
    for (var k = (*t).used; k < select(NODES, 0u, is_blank()); k += 1u) {
        put_node(view, t, i, k, unused, true);
    }
}
