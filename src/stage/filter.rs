//! filter: dithered opaque depths become a grey filter, by a separable blur of the visibility over one
//! window of the pattern.
//!
//! In: the maps. Out: maps of the same size, without blurring any depth. Curves get the visibility through
//! dithered surfaces as one more ramp.
use super::{curve, walk};
use crate::gpu::{Choice, KernelDesc, Tier};
use bytemuck::{Pod, Zeroable};

/// Edge of a workgroup [texels].
pub const GROUP_SIZE: u32 = 8;

pub const ROWS: KernelDesc = KernelDesc {
    name: "filter_rows",
    entry: "filter_rows",
    root: "soften/filter_rows.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};

pub const COLUMNS: KernelDesc = KernelDesc {
    name: "filter_columns",
    entry: "filter_columns",
    root: "soften/filter_columns.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};

pub const CURVE_ROWS: KernelDesc = KernelDesc {
    name: "curve_rows",
    entry: "curve_rows",
    root: "soften/curve_rows.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};

/// Texels of a column per invocation. WGSL: `ROWS` in `wgsl/soften/curve_columns.wgsl`.
pub const CURVE_TEXELS: u32 = 4;

pub const CURVE_COLUMNS: KernelDesc = KernelDesc {
    name: "curve_columns",
    entry: "curve_columns",
    root: "soften/curve_columns.wgsl",
    with: &[
        Choice::new("visit", "soften/curve_columns.wgsl"),
        walk::INVOCATION_ROWS,
        curve::OPEN_NODES,
    ],
    constants: &[("NODES", 8.0)],
    tiers: &[Tier::Core],
};

/// Layers that [`CURVE_ROWS`] writes per layer of the maps. WGSL: `CURVE_RUN_LAYERS`.
pub const CURVE_RUN_LAYERS: u32 = 3;

/// WGSL: `wgsl/soften/window.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct FilterParams {
    /// Half the window [texels].
    pub radius: i32,
    /// 1: opaque depths are per channel.
    pub colored: u32,
    pub pad_0: u32,
    pub pad_1: u32,
}
crate::gpu_layout!(FilterParams { radius, colored, pad_0, pad_1 });
