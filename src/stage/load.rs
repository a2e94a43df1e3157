//! load: casters in the host's buffers to records, and culling of their groups per view.
//!
//! `load_casters`, `load_gaussians` (once per frame and set): in: the host's `load_caster` or
//! `load_gaussian`; out: `casters`, as if they had been uploaded, and a box around each group of
//! [`CHUNK_SIZE`]. `pack_voxels` (before, once per grid of the host): in: `host_voxels`, or the host's
//! `load_density`; out: `voxels`, and the states of bricks, from which `load_bricks` makes casters.
//! `cull_groups`, `cull_scan`, `cull_list` (once per list): in: the boxes, six planes per view; out: chunks
//! for `project` and their number, which is never read back: the dispatch covers all groups, and surplus
//! workgroups end early.
use super::{project::CHUNK_SIZE, walk::SCAN};
use crate::gpu::{Choice, KernelDesc, Tier};

/// Name of the import that a host's text implements.
pub const LOADER: &str = "loader";

/// Records of the host's particles.
pub const CASTERS: KernelDesc = KernelDesc {
    with: &[Choice::new(LOADER, "load/load_plain.wgsl")],
    ..KernelDesc::new("load_casters", "load/load_casters.wgsl")
};

/// Records of the host's Gaussians.
pub const GAUSSIANS: KernelDesc = KernelDesc {
    with: &[Choice::new(LOADER, "load/load_plain.wgsl")],
    ..KernelDesc::new("load_gaussians", "load/load_gaussians.wgsl")
};

/// Records of bricks that hold voxels.
pub const BRICKS: KernelDesc = KernelDesc {
    entry: "load_casters",
    with: &[Choice::new(LOADER, "load/load_bricks.wgsl")],
    ..KernelDesc::new("load_bricks", "load/load_casters.wgsl")
};

/// Invocations for the 729 voxels of a brick.
const VOXEL_LANES: u32 = 128;

/// Voxels of the host's grids.
pub const VOXELS: KernelDesc = KernelDesc {
    with: &[Choice::new(LOADER, "load/load_plain.wgsl")],
    constants: &[("WORKGROUP_SIZE", VOXEL_LANES as f64)],
    ..KernelDesc::new("pack_voxels", "load/pack_voxels.wgsl")
};

/// Combinations of a view and a group that a workgroup culls. WGSL: `wgsl/load/cull.wgsl`.
pub const CULL_BLOCK: u32 = 128;
/// Invocations of `cull_scan`'s only workgroup.
const SCAN_LANES: u32 = 256;

/// Tests groups of the host's casters with each view.
pub const CULL_GROUPS: KernelDesc = KernelDesc {
    with: &[SCAN],
    constants: &[("SCAN_LANES", CULL_BLOCK as f64)],
    tiers: Tier::BY_SUBGROUPS,
    ..KernelDesc::new("cull_groups", "load/cull.wgsl")
};

/// Prefix sums of the chunks and footprints of blocks of groups, and their totals.
pub const CULL_SCAN: KernelDesc = KernelDesc {
    name: "cull_scan",
    entry: "cull_scan",
    root: "load/cull.wgsl",
    constants: &[("SCAN_LANES", SCAN_LANES as f64)],
    ..CULL_GROUPS
};

/// Chunks for `project`, view by view.
pub const CULL_LIST: KernelDesc =
    KernelDesc { name: "cull_list", entry: "cull_list", root: "load/cull.wgsl", ..CULL_GROUPS };

/// The kernels that cull `entries` combinations of a view and a group, and their workgroups.
pub fn cull(entries: u32) -> [(&'static KernelDesc, [u32; 3]); 3] {
    let blocks = [entries.div_ceil(CULL_BLOCK), 1, 1];
    [(&CULL_GROUPS, blocks), (&CULL_SCAN, [1; 3]), (&CULL_LIST, blocks)]
}

/// Elements of `listed_counts` for `entries` combinations.
pub fn listed_length(entries: u32) -> u64 {
    u64::from(entries) + 2 * u64::from(entries.div_ceil(CULL_BLOCK))
}

/// Number of groups of a set of `capacity` casters.
pub fn group_count(capacity: u32) -> u32 {
    capacity.div_ceil(CHUNK_SIZE)
}
