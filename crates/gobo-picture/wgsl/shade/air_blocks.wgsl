// Blocks of columns of air that the pixels of a band see: those of its tiles, and one around them.

import package::bind::uniform::{air_params, band, views};
import package::records::air_item::{AIR_BLOCK, AIR_RUN};
import package::records::air_params::AIR_CELL;

const MAX_WORKGROUPS: u32 = 65535u; // workgroups in a row on every adapter

// Columns of the picture.
fn air_size() -> vec2<u32> {
    return (vec2<u32>(views[0].size) + AIR_CELL - 1u) / AIR_CELL;
}

fn band_blocks() -> vec2<u32> {
    return band.size + 2u;
}

// First column of a block of the band; for a block in front of the picture, beyond its end.
fn block_column(number: u32) -> vec2<u32> {
    let width = band_blocks().x;
    return (band.origin - 1u + vec2(number % width, number / width)) * AIR_BLOCK;
}

// Workgroups in y of a dispatch over the items.
fn item_rows() -> u32 {
    let blocks = band_blocks();
    return blocks.x * blocks.y * ((air_params.slices + AIR_RUN - 1u) / AIR_RUN) / MAX_WORKGROUPS + 1u;
}
