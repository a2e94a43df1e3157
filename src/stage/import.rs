//! import: the host's depth maps to opaque depths, after `occlude` and before `accumulate`; and convert:
//! filters to a layout of the host, after all other stages.
//!
//! `import_depths`: in: `host_depths` of one view; out: `opaques`, lowered or replaced. `convert_maps`: in:
//! `filters`, `nearests`; out: `converted`, words to be copied to a texture.
use crate::gpu::KernelDesc;

/// Edge of a workgroup \[texels\].
const EDGE: u32 = 8;

/// Takes depth maps of the host over.
pub const DEPTHS: KernelDesc = KernelDesc {
    constants: &[("WORKGROUP_EDGE", EDGE as f64)],
    ..KernelDesc::new("import_depths", "import/import.wgsl")
};

/// Converts maps to the host's formats.
pub const MAPS: KernelDesc = KernelDesc {
    constants: &[("WORKGROUP_EDGE", EDGE as f64)],
    ..KernelDesc::new("convert_maps", "import/import.wgsl")
};

/// Workgroups for a map of `size` texels.
pub fn grid(size: glam::UVec2) -> [u32; 3] {
    [size.x.div_ceil(EDGE), size.y.div_ceil(EDGE), 1]
}
