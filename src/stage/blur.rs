//! blur: a separable Gaussian of the filter map and of the curves. Depths are not blurred; the nearest
//! translucent one becomes that of the window.
//!
//! In: the maps. Out: the same. `near_around` holds, per texel, the nearest translucent depth of its
//! window, its alpha, and the first depth of the window's curves; `rows` the sum over a row's window and
//! its weight.
use crate::gpu::{Choice, KernelDesc, Tier};
use bytemuck::{Pod, Zeroable};

/// Edge of a workgroup [texels].
pub const GROUP_SIZE: u32 = 8;

const fn of(name: &'static str, root: &'static str) -> KernelDesc {
    let tiers = &[Tier::Core];
    KernelDesc { name, entry: name, root, with: &[], constants: &[], tiers }
}

pub const NEAR_ROWS: KernelDesc = of("blur_near_rows", "blur/near_rows.wgsl");
pub const NEAR_COLUMNS: KernelDesc = of("blur_near_columns", "blur/near_columns.wgsl");
pub const ROWS: KernelDesc = of("blur_rows", "blur/rows.wgsl");
pub const COLUMNS: KernelDesc = of("blur_columns", "blur/columns.wgsl");

const fn of_curves(name: &'static str, with: &'static [Choice]) -> KernelDesc {
    KernelDesc {
        name,
        entry: "blur_curves",
        root: "blur/curves.wgsl",
        with,
        constants: &[("NODES", 8.0)],
        tiers: &[Tier::Core],
    }
}

pub const CURVE_ROWS: KernelDesc =
    of_curves("blur_curve_rows", &[Choice::new("below", "blur/curve_rows.wgsl")]);
pub const CURVE_COLUMNS: KernelDesc =
    of_curves("blur_curve_columns", &[Choice::new("below", "blur/curve_columns.wgsl")]);

/// Makes a mip level of the filter map.
pub const FILTER_MIP: KernelDesc = of("make_filter_mip", "blur/filter_mip.wgsl");

/// WGSL: `wgsl/blur/window.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct BlurParams {
    /// Radius of the window [texels].
    pub radius: i32,
    /// Factor of a squared offset in the exponent.
    pub scale: f32,
    /// Mip level of the filter map that is made, from the one before.
    pub level: u32,
    pub pad_0: u32,
}
crate::gpu_layout!(BlurParams { radius, scale, level, pad_0 });
