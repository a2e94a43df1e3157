//! filter: holes that dithering left in the opaque depth become a grey filter, by a separable blur
//! of the visibility over one window of the pattern.
//!
//! In: the maps. Out: maps of the same size, in which no depth is blurred.
use crate::gpu::{KernelDesc, Tier};
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

/// WGSL: `wgsl/soften/window.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct FilterParams {
    /// Half the window [texels].
    pub radius: i32,
    pub pad_0: u32,
    pub pad_1: u32,
    pub pad_2: u32,
}
crate::gpu_layout!(FilterParams { radius, pad_0, pad_1, pad_2 });
