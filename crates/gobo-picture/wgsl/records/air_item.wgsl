// Blocks of columns of air, and the items that are lit: runs of slices of a block. `air_items` holds the
// workgroups of a dispatch over the items in x, y and z, the number of items, and then the items. Rust:
// `crates/gobo-picture/src/stage/air.rs`.

const AIR_BLOCK: u32 = 4u;    // edge of a block [columns]
const AIR_RUN: u32 = 4u;      // slices of a run
const MAX_AIR_RUNS: u32 = 64u; // runs of a block

const ITEM_HEAD: u32 = 4u; // words
const ITEM_COUNT: u32 = 3u;
