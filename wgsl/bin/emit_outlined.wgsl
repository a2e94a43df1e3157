// Pairs of a Gaussian whose rectangle is large.

import package::bind::stored::pairs;
import package::records::outline::{load_outline, outline_farthest, outlined_columns};
import package::records::record::record_texel;

// The pairs of an outline, from pair `first` on.
fn emit_outlined(rect: vec2<u32>, first_tile: u32, tiles_x: u32, footprint: u32, first: u32) {
    let outline = load_outline(footprint);
    let farthest = outline_farthest(outline);
    var pair = first;
    for (var row = (rect.x >> 8u) & 255u; row <= (rect.x >> 24u); row += 1u) {
        let columns = outlined_columns(outline, farthest, row, rect.x);
        for (var x = columns.x; x < columns.y; x += 1u) {
            let tile = first_tile + row * tiles_x + x;
            textureStore(pairs, record_texel(pair), vec4(tile, footprint, 0u, 0u));
            pair += 1u;
        }
    }
}
