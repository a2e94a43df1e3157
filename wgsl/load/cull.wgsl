// Counts that the steps of `cull` share. Rust: src/stage/load.rs.

import package::bind::uniform::cull_params;

const CULL_BLOCK: u32 = 128u; // (view, group) combinations per workgroup
const CHUNKS_SHIFT: u32 = 20u;

fn cull_entries() -> u32 {
    return cull_params.view_count * cull_params.group_count;
}

fn cull_blocks() -> u32 {
    return (cull_entries() + CULL_BLOCK - 1u) / CULL_BLOCK;
}

// Chunks and footprints of a combination, in one word: a block has fewer than 2^20 footprints.
fn both_counts(count: u32) -> u32 {
    return (min(count, 1u) << CHUNKS_SHIFT) | count;
}

fn chunks_of(counts: u32) -> u32 {
    return counts >> CHUNKS_SHIFT;
}

fn footprints_of(counts: u32) -> u32 {
    return counts & ((1u << CHUNKS_SHIFT) - 1u);
}
