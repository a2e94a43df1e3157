//! blur: a separable Gaussian of the filter map and of the curves. Depths are not blurred; the nearest
//! translucent depth becomes the window's.
//!
//! In: the maps. Out: the same. `near_around` holds, per texel, the nearest translucent depth of its
//! window, its alpha, and the first depth of the window's curves; `rows` the sum over a row's window and
//! its weight.
use crate::gpu::{Choice, Constant, KernelDesc};

/// A pass of a separable filter.
pub(super) const fn separable(
    name: &'static str,
    with: &'static [Choice],
    constants: &'static [Constant],
) -> KernelDesc {
    let of_window = KernelDesc::new("filter_window", "blur/separable.wgsl");
    KernelDesc { name, with, constants, ..of_window }
}

const WINDOW: Choice = Choice::new("window", "blur/window.wgsl");
const COLUMN: &[Constant] = &[("COLUMN", 1.0)];

/// Nearest depths, along rows.
pub const NEAR_ROWS: KernelDesc =
    separable("blur_near_rows", &[Choice::new("accumulator", "blur/near_rows.wgsl"), WINDOW], &[]);
/// Nearest depths, along columns.
pub const NEAR_COLUMNS: KernelDesc = separable(
    "blur_near_columns",
    &[Choice::new("accumulator", "blur/near_columns.wgsl"), WINDOW],
    COLUMN,
);
/// Filters, along rows.
pub const ROWS: KernelDesc =
    separable("blur_rows", &[Choice::new("accumulator", "blur/rows.wgsl"), WINDOW], &[]);
/// Filters, along columns.
pub const COLUMNS: KernelDesc =
    separable("blur_columns", &[Choice::new("accumulator", "blur/columns.wgsl"), WINDOW], COLUMN);

/// Curves, along rows.
pub const CURVE_ROWS: KernelDesc = KernelDesc {
    entry: "blur_curves",
    with: &[Choice::new("below", "blur/curves.wgsl")],
    constants: &[("NODES", 8.0)],
    ..KernelDesc::new("blur_curve_rows", "blur/curves.wgsl")
};
/// Curves, along columns.
pub const CURVE_COLUMNS: KernelDesc = KernelDesc {
    name: "blur_curve_columns",
    constants: &[("NODES", 8.0), ("COLUMN", 1.0)],
    ..CURVE_ROWS
};

/// Makes a mip level of the filter map.
pub const FILTER_MIP: KernelDesc = KernelDesc::new("make_filter_mip", "blur/window.wgsl");

crate::records::gpu_struct! {
    /// WGSL: `wgsl/blur/window.wgsl`.
    #[derive(Default)]
    pub struct BlurParams {
        /// Radius of the window \[texels\].
        pub radius: i32,
        /// Factor of a squared offset in the exponent.
        pub scale: f32,
        /// Mip level of the filter map to make, from the one before.
        pub level: u32,
        pub pad_0: u32,
    }
}
