// Output: the curves of one segment of a long tile; `resolve` combines a tile's segments in order. CPU
// reference: crates/gobo-reference/src/curve/tile.rs.

import package::bind::changed::{counters, partials};
import package::curve::gather::{corner, nearest, scale, total_light};
import package::curve::lights::light_row;
import package::curve::list::disordered;
import package::curve::stored::{begin_stored, first_node, partial_size, stored_node, stored_pair};
import package::curve::volumes::{crossed, density, last_face, surface_light, surface_scale, unentered};
import package::features::{HAS_OVER, HAS_VOLUMES, NODES, unrolled};
import package::records::tile::Segment;
import package::records::view::{GpuView, TILE_SIZE};
import package::traversal::lane::sum_index;
import choice::rows::{ROW_COUNT, row};

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
    let all = total_light();
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        let at = first + i * TILE_SIZE * partial_size();
        partials[at] = bitcast<vec4<u32>>(vec4(light_row(all, i), row(nearest, i)));
        if HAS_OVER || HAS_VOLUMES {
            partials[at + 1u] = bitcast<vec4<u32>>(vec4(light_row(scale, i), 0.0));
            partials[at + 2u] = bitcast<vec4<u32>>(vec4(light_row(surface_scale, i), row(last_face, i)));
            partials[at + 3u] = bitcast<vec4<u32>>(vec4(light_row(surface_light, i), 0.0));
            partials[at + 4u] = bitcast<vec4<u32>>(vec4(light_row(density, i), 0.0));
            partials[at + 5u] = bitcast<vec4<u32>>(crossed[i]);
            partials[at + 6u] = bitcast<vec4<u32>>(vec4(
                light_row(unentered.density, i),
                row(unentered.first, i),
            ));
            partials[at + 7u] = bitcast<vec4<u32>>(vec4(light_row(unentered.tau, i), row(unentered.last, i)));
        }
    }
    begin_stored();
    for (var pair = 0u; pair < unrolled(NODES / 2u); pair += 1u) {
        let near = stored_node(2u * pair);
        let far = stored_node(2u * pair + 1u);
        for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
            let at = first + i * TILE_SIZE * partial_size() + first_node();
            partials[at + pair] = stored_pair(near, far, i);
        }
    }
    if disordered > 0u {
        atomicAdd(&counters.disordered, disordered);
    }
}
