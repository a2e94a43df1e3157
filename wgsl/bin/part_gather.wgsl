// bin, where pairs did not fit: the pairs of each tile of a part, front to back. One workgroup per tile,
// which walks the footprints of the tile's band in depth order. Loops take eight footprints at a time:
// llvmpipe allows an invocation 65,535 turns. Rust: src/shadows/batch/parts.rs.

import package::bin::parts::band_of;
import package::bind::read::{dispatches, tile_pairs};
import package::bind::uniform::bin_params;
import package::features::HAS_GAUSSIANS;
import package::records::batch::{PART_DISPATCH, covers, workgroup_number};
import package::records::outline::{is_outlined, is_within, load_outline};
import package::records::tile::Tile;
import choice::records::{key_record, rect_record, sorted_record, tile_at};
import choice::writes::write_pair;

const LANES: u32 = 128u;
const WORDS: u32 = 4u; // words of 32 footprints each that a lane walks at a time

var<workgroup> counts: array<u32, LANES>;

var<private> touched: array<u32, WORDS>; // footprints of each word that touch the tile

var<private> left: u32;  // footprints of a word that are to be tested or written
var<private> found: u32; // those of them that touch the tile
var<private> slot: u32;  // of the next pair

fn footprint_of(index: u32) -> u32 {
    return sorted_record(index).y;
}

fn test(tile: Tile, first: u32) {
    let bit = firstTrailingBit(left | 0x80000000u);
    let index = min(first + bit, bin_params.footprint_count - 1u);
    let footprint = footprint_of(index);
    let rect = rect_record(footprint);
    var touches = left != 0u && covers(rect, tile.view, tile.position);
    if HAS_GAUSSIANS && touches && is_outlined(rect) {
        touches = is_within(load_outline(footprint), rect, tile.position);
    }
    found |= select(0u, 1u << bit, touches);
    left &= left - 1u;
}

// Footprints of a word that touch the tile.
fn touching(tile: Tile, band: u32, word: u32) -> u32 {
    let first = word * 32u;
    found = 0u;
    left = 0u;
    if first < bin_params.footprint_count {
        left = key_record(first + band / 2u)[band & 1u];
    }
    while left != 0u {
        test(tile, first);
        test(tile, first);
        test(tile, first);
        test(tile, first);
        test(tile, first);
        test(tile, first);
        test(tile, first);
        test(tile, first);
    }
    return found;
}

fn put(tile_id: u32, first: u32) {
    if left != 0u {
        write_pair(slot, vec2(tile_id, footprint_of(first + firstTrailingBit(left))));
        slot += 1u;
        left &= left - 1u;
    }
}

fn put_all(tile_id: u32, word: u32, touches: u32) {
    let first = word * 32u;
    left = touches;
    while left != 0u {
        put(tile_id, first);
        put(tile_id, first);
        put(tile_id, first);
        put(tile_id, first);
        put(tile_id, first);
        put(tile_id, first);
        put(tile_id, first);
        put(tile_id, first);
    }
}

// Inclusive prefix sum over the lanes, in `counts` (Hillis and Steele 1986).
fn scan(lane: u32, gathered: u32) {
    counts[lane] = gathered;
    workgroupBarrier(); // every count before any is read
    for (var step = 1u; step < LANES; step *= 2u) {
        var sum = counts[lane];
        if lane >= step {
            sum += counts[lane - step];
        }
        workgroupBarrier(); // every sum of the step before any is replaced
        counts[lane] = sum;
        workgroupBarrier();
    }
}

@compute @workgroup_size(LANES)
fn part_gather(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = workgroup_number(workgroup, workgroups);
    let tile_id = dispatches[PART_DISPATCH].w + index;
    let count = tile_pairs[tile_id + 1u] - tile_pairs[tile_id];
    let tile = tile_at(index);
    let band = band_of(tile_id);
    let words = select(0u, (bin_params.footprint_count + 31u) / 32u, count > 0u);
    // Not constant, so that compilers do not unroll.
    let some = min(words, WORDS);
    var first = tile.first;
    for (var base = 0u; base < words; base += LANES * WORDS) {
        let word = base + lane * WORDS;
        var gathered = 0u;
        for (var i = 0u; i < some; i += 1u) {
            touched[i] = touching(tile, band, word + i);
            gathered += countOneBits(touched[i]);
        }
        scan(lane, gathered);
        slot = first + counts[lane] - gathered;
        first += counts[LANES - 1u];
        workgroupBarrier(); // every count is read before the next are written
        for (var i = 0u; i < some; i += 1u) {
            put_all(tile_id, word + i, touched[i]);
        }
    }
}
