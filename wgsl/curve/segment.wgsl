// Output: the curves of one segment of a long tile; `resolve` combines a tile's segments in order. CPU
// reference: crates/gobo-reference/src/curve/tile.rs.

import package::bind::changed::{counters, partials};
import package::curve::gather::{ROWS, corner, texels, total_light};
import package::curve::list::disordered;
import package::curve::stored::{begin_stored, first_node, partial_size, stored_pair};
import package::features::{HAS_OVER, HAS_VOLUMES, NODES, unrolled};
import package::records::tile::Segment;
import package::records::view::{GpuView, TILE_SIZE};
import package::traversal::lane::sum_index;

fn is_scattered() -> bool {
    return false;
}

// Steps behind all pairs: none, since `resolve` adds those of the tile.
fn tile_steps() -> u32 {
    return 0u;
}

fn open_rest(view: GpuView, step: u32) {}

fn before_segment(index: u32) {}

fn store_segment(segment: Segment, index: u32, in_tile: vec2<u32>) {
    // By the texel's centre, which is in registers anyhow.
    let first = sum_index(index, vec2<u32>(corner + 0.5) % TILE_SIZE) * partial_size();
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let at = first + i * TILE_SIZE * partial_size();
        var texel = texels[i];
        partials[at] = bitcast<vec4<u32>>(vec4(total_light(&texel, i), texel.nearest));
        if HAS_OVER || HAS_VOLUMES {
            let inside = texel.unentered;
            partials[at + 1u] = bitcast<vec4<u32>>(vec4(texel.scale, 0.0));
            partials[at + 2u] = bitcast<vec4<u32>>(vec4(texel.surface_scale, texel.last_face));
            partials[at + 3u] = bitcast<vec4<u32>>(vec4(texel.surface_light, 0.0));
            partials[at + 4u] = bitcast<vec4<u32>>(vec4(texel.density, 0.0));
            partials[at + 5u] = bitcast<vec4<u32>>(texel.crossed);
            partials[at + 6u] = bitcast<vec4<u32>>(vec4(inside.density, inside.first));
            partials[at + 7u] = bitcast<vec4<u32>>(vec4(inside.tau, inside.last));
        }
        var left = vec3(1.0);
        begin_stored(i);
        for (var pair = 0u; pair < unrolled(NODES / 2u); pair += 1u) {
            partials[at + first_node() + pair] = stored_pair(i, pair, &left);
        }
    }
    if disordered > 0u {
        atomicAdd(&counters.disordered, disordered);
    }
}
