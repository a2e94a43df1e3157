// shade, layered: lists the tiles of a band that have translucent casters. One invocation per tile. Rust:
// crates/gobo-picture/src/stage/shade.rs.

import package::bind::changed::layered_tiles;
import package::bind::sampled::tiles;
import package::bind::uniform::{band, views};
import package::records::record::record_texel;
import package::records::tile::tile_of;
import package::shade::band::{PIXELS_OF_TILE, indexed_pixel};
import package::shade::layer::LAYERED_HEAD;

override WORKGROUP_SIZE: u32;

@compute @workgroup_size(WORKGROUP_SIZE)
fn shade_layered(@builtin(global_invocation_id) id: vec3<u32>) {
    let number = id.x;
    if number >= band.size.x * band.size.y {
        return;
    }
    let at = indexed_pixel(number * PIXELS_OF_TILE, views[0].tiles_x);
    let tile = tile_of(textureLoad(tiles, record_texel(at.tile), 0));
    if tile.first < tile.end {
        let slot = atomicAdd(&layered_tiles[0], 1u);
        atomicStore(&layered_tiles[LAYERED_HEAD + slot], number);
    }
}
