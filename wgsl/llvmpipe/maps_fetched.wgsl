// Where a tile is written that is finished, on a software adapter: what is there is read before the
// tile is walked, so that its memory is near when it is written. The stores, eight and more for
// each lane, would wait for one line after the other. Lanes are neighbours in a row, eight to a
// block of eight rows.

import package::bind::updated::{filters, nearests};

// Of texels that belong to nobody. `texel`: the lane's first in the map; every lane fetches a row.
fn plain_alpha(texel: vec2<u32>, layer: u32) -> f32 {
    let lane = texel.x & 7u;
    let row = texel - vec2(lane, 0u) + vec2(0u, lane);
    let fetched = textureLoad(filters, row, layer).a + textureLoad(nearests, row, layer).r;
    // Neither is negative, which no compiler knows: what is not used is not read.
    return select(1.0, fetched, fetched < 0.0);
}

fn store_map(at: vec2<u32>, layer: u32, filtered: vec4<f32>, nearest: f32) {
    textureStore(filters, at, layer, filtered);
    textureStore(nearests, at, layer, vec4(nearest));
}
