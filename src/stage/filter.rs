//! filter: holes that dithering left in the opaque depth become a grey filter, by a separable blur
//! of the visibility over one window of the pattern.
//!
//! In: the maps. Out: maps of the same size, in which no depth is blurred.
use super::hits::{OPAQUES, VIEWS};
use crate::gpu::{Binding, FLOAT, KernelDesc, Tier};
use bytemuck::{Pod, Zeroable};
use wgpu::TextureFormat::{R32Float, Rgba16Float, Rgba32Float};

/// Edge of a workgroup [texels].
pub const GROUP_SIZE: u32 = 8;

pub(super) const PARAMS: Binding = Binding::uniform::<FilterParams>("params");

pub const ROWS: KernelDesc = KernelDesc {
    name: "filter_rows",
    sources: crate::sources!["common/view.wgsl", "common/window.wgsl", "filter_rows.wgsl"],
    bindings: &[PARAMS, VIEWS, OPAQUES, Binding::texture_write("rows", Rgba32Float).array()],
    constants: &[],
    tier: Tier::Core,
};

/// From blurred rows to the maps.
pub(super) const COLUMNS_BINDINGS: &[Binding] = &[
    PARAMS,
    VIEWS,
    Binding::texture("rows", FLOAT).array(),
    Binding::texture("filters", FLOAT).array(),
    Binding::texture("nearests", FLOAT).array(),
    OPAQUES,
    Binding::texture_write("soft_filters", Rgba16Float).array(),
    Binding::texture_write("soft_nearests", R32Float).array(),
    Binding::texture_write("soft_opaques", R32Float).array(),
];

pub const COLUMNS: KernelDesc = KernelDesc {
    name: "filter_columns",
    sources: crate::sources!["common/view.wgsl", "common/window.wgsl", "filter_columns.wgsl"],
    bindings: COLUMNS_BINDINGS,
    constants: &[],
    tier: Tier::Core,
};

/// WGSL: `wgsl/common/window.wgsl`.
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
