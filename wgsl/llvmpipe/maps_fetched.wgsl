// Stores a finished tile to the maps, on a software adapter: reads the texels before the tile is walked, so
// that their cache lines are present for the stores. Otherwise the stores, eight and more per lane, would
// wait for one line after the other. Lanes are neighbours in a row, eight to a block of eight rows.

import package::bind::updated::{filters, nearests};

// Alpha of texels without an owner tag. `texel`: the lane's first in the map; each lane fetches a row.
fn plain_alpha(texel: vec2<u32>, layer: u32) -> f32 {
    let lane = texel.x & 7u;
    let row = texel - vec2(lane, 0u) + vec2(0u, lane);
    let fetched = textureLoad(filters, row, layer).a + textureLoad(nearests, row, layer).r;
    // Keeps the prefetch from being optimised away: neither is negative, but compilers cannot know.
    return select(1.0, fetched, fetched < 0.0);
}

fn store_map(at: vec2<u32>, layer: u32, filtered: vec4<f32>, nearest: f32) {
    textureStore(filters, at, layer, filtered);
    textureStore(nearests, at, layer, vec4(nearest));
}
