//! soften: dithered opaque depths become a grey or coloured filter, by a separable blur of the visibility
//! over one window of the pattern.
//!
//! In: the maps. Out: maps of the same size, without blurring any depth. Curves get the visibility through
//! dithered surfaces as one more ramp.
use super::blur::separable;
use crate::gpu::{Choice, KernelDesc};

const WINDOW: Choice = Choice::new("window", "soften/run.wgsl");
const OF_ROWS: &[Choice] = &[Choice::new("accumulator", "soften/rows.wgsl"), WINDOW];
const OF_COLUMNS: &[Choice] = &[Choice::new("accumulator", "soften/columns.wgsl"), WINDOW];

/// Opaque depths, along rows.
pub const ROWS: KernelDesc = separable("soften_rows", OF_ROWS, &[]);
/// Opaque depths, along columns.
pub const COLUMNS: KernelDesc = separable("soften_columns", OF_COLUMNS, &[("COLUMN", 1.0)]);

/// [`ROWS`] for depths per channel.
pub const COLORED_ROWS: KernelDesc = separable("soften_colored_rows", OF_ROWS, &[("COLORED", 1.0)]);
/// [`COLUMNS`] for depths per channel.
pub const COLORED_COLUMNS: KernelDesc =
    separable("soften_colored_columns", OF_COLUMNS, &[("COLUMN", 1.0), ("COLORED", 1.0)]);

/// Follows [`ROWS`] or [`COLORED_ROWS`], whose results are the same with curves.
pub const CURVE_COLUMNS: KernelDesc = KernelDesc {
    constants: &[("NODES", 8.0)],
    ..KernelDesc::new("soften_curve_columns", "soften/curve_columns.wgsl")
};

/// Layers of `rows` per layer of the maps. WGSL: `run_layer` in `wgsl/soften/run.wgsl`.
pub const fn run_layers(colored: bool, nodes: u32) -> u32 {
    match (colored, nodes) {
        (false, 0) => 1,
        (true, 0) => 2,
        _ => 3,
    }
}

crate::records::gpu_struct! {
    /// WGSL: `wgsl/soften/run.wgsl`.
    #[derive(Default, Eq)]
    pub struct SoftenParams {
        /// Half the window \[texels\].
        pub radius: i32,
        pub pad_0: u32,
        pub pad_1: u32,
        pub pad_2: u32,
    }
}
