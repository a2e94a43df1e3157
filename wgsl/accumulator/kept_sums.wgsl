// Output: the sums themselves, for maps that are merged with others. CPU reference:
// crates/gobo-reference/src/sums.rs.

import package::bind::stored::kept_sums;
import package::records::tile::Tile;
import package::records::view::{GpuView, TILE_SIZE};
import package::traversal::lane::sum_index;
import choice::accumulator::ROWS;
import choice::sums::{clear_sums, load_nearness, load_sums};

fn resolve(view: GpuView, tile: Tile, tile_id: u32, in_tile: vec2<u32>) {
    for (var i = 0u; i < ROWS; i += 1u) {
        let sum = sum_index(tile_id, in_tile + vec2(0u, i));
        let at = view.origin + tile.position * TILE_SIZE + in_tile + vec2(0u, i);
        textureStore(kept_sums, at, view.layer, vec4(load_sums(sum), load_nearness(sum)));
        clear_sums(sum);
    }
}
