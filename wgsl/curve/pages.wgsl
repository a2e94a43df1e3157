// Places of nodes of a map: the texels' own, or, with `HAS_PAGES`, in pages, one for each tile that
// casters touch. Rust: src/shadows/views/curve_pages.rs.

import package::bind::sampled::{curve_pages, curves, filters, nearests};
import package::curve::node::{DEPTHS, curve_layer, node_length, node_passed, node_start, packed_node};
import package::features::{HAS_PAGES, NODES};
import package::records::view::{GpuView, TILE_SIZE};

// A page by its place: column, row, and its layers.
const PAGE_BITS: u32 = 10u;
const PAGE_MASK: u32 = 1023u;
// The first page holds no node: all tiles without a caster have it. Tiles for which there was no page have
// the second, whose nodes are never read.
const BLANK_PAGE: u32 = 0u;
const SHORT_PAGE: u32 = 1u;

// Page of the tile of a texel of the atlas.
fn page_of(at: vec2<u32>, layer: u32) -> u32 {
    if HAS_PAGES {
        return textureLoad(curve_pages, at / TILE_SIZE, layer, 0).x;
    }
    return BLANK_PAGE;
}

// Place of a texel, whose tile has a page, in `curves`: x, y, and the layer of its first two nodes.
fn place_in(page: u32, at: vec2<u32>, layer: u32) -> vec3<u32> {
    if !HAS_PAGES {
        return vec3(at, curve_layer(layer, 0u));
    }
    let tile = vec2(page & PAGE_MASK, (page >> PAGE_BITS) & PAGE_MASK);
    return vec3(tile * TILE_SIZE + at % TILE_SIZE, curve_layer(page >> (2u * PAGE_BITS), 0u));
}

// Place where look-ups find a texel's nodes.
struct CurvePlace {
    first: vec3<u32>, // in `curves`
    only: vec2<u32>,  // node of a texel without a page
}

fn curve_place(at: vec2<u32>, layer: u32) -> CurvePlace {
    let page = page_of(at, layer);
    let is_short = page == SHORT_PAGE;
    var place = CurvePlace(place_in(select(page, BLANK_PAGE, is_short), at, layer), vec2(0u));
    if !HAS_PAGES {
        return place;
    }
    // A loop, because llvmpipe executes what is behind an `if` in any case.
    for (var turn = 0u; turn < u32(is_short); turn += 1u) {
        place.only = only_node(at, layer);
    }
    return place;
}

// All light that the filter takes, at the nearest depth.
fn only_node(at: vec2<u32>, layer: u32) -> vec2<u32> {
    let nearest = textureLoad(nearests, at, layer, 0).r;
    let passed = textureLoad(filters, at, layer, 0).rgb;
    let start = u32(clamp(round(nearest * DEPTHS), 1.0, DEPTHS));
    return select(vec2(0u), packed_node(start, 0.0, passed), nearest < 1.0);
}

// Nodes 2 `pair` and 2 `pair` + 1 of a texel.
fn nodes_at(place: CurvePlace, pair: u32) -> vec4<u32> {
    let nodes = textureLoad(curves, place.first.xy, place.first.z + pair, 0);
    if !HAS_PAGES {
        return nodes;
    }
    return nodes | vec4(select(vec2(0u), place.only, pair == 0u), 0u, 0u);
}

// Light at a depth of a texel's curve: the product of its nodes, in any order.

// Share of light that a node passes up to depth `z`, in fixed point.
fn passed_at(node: vec2<u32>, z: f32) -> vec3<f32> {
    let start = node_start(node);
    let share = clamp((z - start) / max(node_length(node), 1e-6), 0.0, 1.0);
    return mix(vec3(1.0), node_passed(node), select(0.0, share, start > 0.0));
}

fn curve_light(view: GpuView, at: vec2<u32>, z: f32) -> vec3<f32> {
    let place = curve_place(at, view.layer);
    var light = vec3(1.0);
    for (var pair = 0u; pair < NODES / 2u; pair += 1u) {
        let nodes = nodes_at(place, pair);
        light *= passed_at(nodes.xy, z * DEPTHS) * passed_at(nodes.zw, z * DEPTHS);
    }
    return light;
}
