// Record of a long tile's segment in `partials`, texel by texel: its filter and nearest depth, then
// `CHANGE_WORDS` if hits add light or volumes absorb, then its nodes, two at a time. Rust:
// src/stage/curve.rs, `partial_bytes`.

import package::features::{HAS_OVER, HAS_VOLUMES, NODES};

const CHANGE_WORDS: u32 = 7u; // scale; surface scale, last face; surface light; density; crossed; `Unentered`

fn first_node() -> u32 {
    return 1u + select(0u, CHANGE_WORDS, HAS_OVER || HAS_VOLUMES);
}

fn partial_size() -> u32 {
    return first_node() + NODES / 2u;
}
