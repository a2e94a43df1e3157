// Stores a finished tile to the maps, curves included, like wgsl/llvmpipe/choices.wgsl: their cache
// lines are read before the tile is walked.

import package::bind::updated::{curves, filters, nearests};
import package::curve::pages::{page_of, place_in};
import package::features::{NODES, unrolled};

// Whether a node is unused and yet has a length: no map has such a node, but compilers cannot know.
fn is_impossible(nodes: vec4<u32>) -> bool {
    return ((nodes.x >> 16u) == 0u) & (((nodes.x >> 4u) & 0xfffu) != 0u);
}

// Alpha of texels without an owner tag. `texel`: the lane's first in the map; each lane fetches a row.
fn plain_alpha(texel: vec2<u32>, layer: u32) -> f32 {
    let lane = texel.x & 7u;
    let row = texel - vec2(lane, 0u) + vec2(0u, lane);
    let fetched = textureLoad(filters, row, layer).a + textureLoad(nearests, row, layer).r;
    let place = place_in(page_of(row, layer), row, layer);
    var is = fetched < 0.0;
    for (var pair = 0u; pair < unrolled(NODES / 2u); pair += 1u) {
        // Two cache lines.
        is = is | is_impossible(textureLoad(curves, place.xy, place.z + pair));
        is = is | is_impossible(textureLoad(curves, place.xy + vec2(4u, 0u), place.z + pair));
    }
    return select(1.0, fetched, is);
}

fn store_map(at: vec2<u32>, layer: u32, filtered: vec4<f32>, nearest: f32) {
    textureStore(filters, at, layer, filtered);
    textureStore(nearests, at, layer, vec4(nearest));
}

fn store_pair(at: vec2<u32>, layer: u32, nodes: vec4<u32>) {
    textureStore(curves, at, layer, nodes);
}

// Stores the others again: a branch for each lane takes more.
fn store_pair_where(at: vec2<u32>, layer: u32, nodes: vec4<u32>, is: bool) {
    textureStore(curves, at, layer, select(textureLoad(curves, at, layer), nodes, is));
}
