//! colored: coloured dithering. Each channel of a dithered caster has a threshold of its own and an
//! opaque depth of its own, so that three depths hold coloured layers in any order (McGuire and
//! Enderton 2011). Takes the place of `occlude`, and of `filter` where shadows are softened.
//!
//! In: as of `occlude`. Out: `colored`, the opaque depths by channel; `opaques`, the last of the
//! three, behind which no light is left. Softened: maps without `colored`.
use super::walk::{ROWS_4, SUMS, WALK};
use crate::gpu::{Choice, KernelDesc, Tier};

const COLORED: Choice = Choice::new("state", "state/colored.wgsl");

pub const TILES: KernelDesc = KernelDesc {
    name: "colored_tiles",
    root: "driver/colored_tiles.wgsl",
    with: &[ROWS_4, COLORED, WALK],
    constants: &[],
    tiers: Tier::ALL,
};

pub const SEGMENTS: KernelDesc = KernelDesc {
    name: "colored_segments",
    root: "driver/colored_segments.wgsl",
    with: &[ROWS_4, COLORED, WALK, SUMS],
    constants: &[],
    tiers: Tier::ALL,
};

pub const OVERFLOW: KernelDesc = KernelDesc {
    name: "colored_overflow",
    root: "driver/colored_overflow.wgsl",
    with: &[SUMS],
    constants: &[],
    tiers: Tier::ALL,
};

pub const RESOLVE: KernelDesc = KernelDesc {
    name: "colored_resolve",
    root: "driver/colored_resolve.wgsl",
    with: &[ROWS_4, SUMS],
    constants: &[],
    tiers: Tier::ALL,
};

pub const ROWS: KernelDesc = KernelDesc {
    name: "colored_rows",
    root: "soften/colored_rows.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};

pub const COLUMNS: KernelDesc = KernelDesc {
    name: "colored_columns",
    root: "soften/colored_columns.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};
