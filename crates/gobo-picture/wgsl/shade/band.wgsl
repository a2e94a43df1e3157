// Band: a rectangle of the picture's tiles that are shaded at a time. Its pixels are records of `seen`,
// `layers`, `points` and `lit`. Rust: `Band` in crates/gobo-picture/src/stage/shade.rs.

import package::bind::picture_in::band;
import package::records::view::TILE_SIZE;
import package::traversal::lane::lane_texel;
import choice::order::tile_number;

struct Band {
    origin: vec2<u32>, // in the picture [tiles]
    size: vec2<u32>,   // [tiles]
    round: u32,        // rounds in which its tiles were walked before
    pixel_count: u32,  // pixel capacity of a band
}

const ROUND_LENGTH: u32 = 16384u; // pairs of a tile in a round; Rust: crates/gobo-picture/src/stage/shade.rs

const PIXELS_OF_TILE: u32 = TILE_SIZE * TILE_SIZE;

// A pixel of the band.
struct BandPixel {
    tile: u32,        // in the picture
    pixel: vec2<u32>, // in the picture
    index: u32,       // in the band
}

fn band_pixel(workgroup: vec3<u32>, workgroups: vec3<u32>, lane: u32, tiles_x: u32) -> BandPixel {
    return tile_pixel(tile_number(workgroup, workgroups), lane, tiles_x);
}

// `number`: index of the tile in the band.
fn tile_pixel(number: u32, lane: u32, tiles_x: u32) -> BandPixel {
    let texel = lane_texel(lane);
    return indexed_pixel((number * TILE_SIZE + texel.y) * TILE_SIZE + texel.x, tiles_x);
}

fn indexed_pixel(index: u32, tiles_x: u32) -> BandPixel {
    let number = index / PIXELS_OF_TILE;
    let tile = band.origin + vec2(number % band.size.x, number / band.size.x);
    let texel = vec2(index % TILE_SIZE, index / TILE_SIZE % TILE_SIZE);
    return BandPixel(tile.y * tiles_x + tile.x, tile * TILE_SIZE + texel, index);
}
