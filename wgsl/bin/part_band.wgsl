// Bands: runs of a batch's tiles. Each band has a row of bits, one per footprint in depth order, set if the
// footprint may touch the band. 32 footprints have 32 texels of `keys`, with the words of two bands in each.

import package::bind::uniform::bin_params;

const BANDS: u32 = 64u;

fn band_of(tile: u32) -> u32 {
    return tile * BANDS / max(bin_params.tile_count, 1u);
}
