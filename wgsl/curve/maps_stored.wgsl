// Stores a finished tile to the maps, curves included.

import package::bind::stored::{curves, filters, nearests};

// Alpha of texels without an owner tag.
fn plain_alpha(texel: vec2<u32>, layer: u32) -> f32 {
    return 1.0;
}

fn store_map(at: vec2<u32>, layer: u32, filtered: vec4<f32>, nearest: f32) {
    textureStore(filters, at, layer, filtered);
    textureStore(nearests, at, layer, vec4(nearest));
}

fn store_pair(at: vec2<u32>, layer: u32, nodes: vec4<u32>) {
    textureStore(curves, at, layer, nodes);
}
