//! load: casters in the host's buffers to records, and culling of their groups per view.
//!
//! `load_casters`, `load_gaussians` (once a frame and set) In: the host's `load_caster` or `load_gaussian`. Out: `casters`,
//! as if they had been uploaded, and a box around each group of [`CHUNK_SIZE`]. `pack_voxels` (before, once a
//! grid of the host) In: `host_voxels`, or the host's `load_density`. Out: `voxels`, and which bricks have some; these
//! `load_bricks` takes for casters. `cull_groups` (once a list) In: the boxes, six
//! planes a view. Out: chunks for `project` and their number, which is never read back: the dispatch covers
//! all groups, and surplus workgroups end early.
use super::project::CHUNK_SIZE;
use crate::gpu::{Choice, KernelDesc, Tier};

/// Name of the import that a host's text implements.
pub const LOADER: &str = "loader";

pub const CASTERS: KernelDesc = KernelDesc {
    name: "load_casters",
    entry: "load_casters",
    root: "load/load_casters.wgsl",
    with: &[Choice::new(LOADER, "load/load_plain.wgsl")],
    constants: &[],
    tiers: &[Tier::Core],
};

pub const GAUSSIANS: KernelDesc = KernelDesc {
    name: "load_gaussians",
    entry: "load_gaussians",
    root: "load/load_gaussians.wgsl",
    with: &[Choice::new(LOADER, "load/load_plain_gaussian.wgsl")],
    constants: &[],
    tiers: &[Tier::Core],
};

pub const BRICKS: KernelDesc = KernelDesc {
    name: "load_bricks",
    entry: "load_casters",
    root: "load/load_casters.wgsl",
    with: &[Choice::new(LOADER, "load/load_bricks.wgsl")],
    constants: &[],
    tiers: &[Tier::Core],
};

/// Invocations for the 729 voxels of a brick.
const VOXEL_LANES: u32 = 128;

pub const VOXELS: KernelDesc = KernelDesc {
    name: "pack_voxels",
    entry: "pack_voxels",
    root: "load/pack_voxels.wgsl",
    with: &[Choice::new(LOADER, "load/load_texture.wgsl")],
    constants: &[("WORKGROUP_SIZE", VOXEL_LANES as f64)],
    tiers: &[Tier::Core],
};

pub const GROUPS: KernelDesc = KernelDesc {
    name: "cull_groups",
    entry: "cull_groups",
    root: "load/cull_groups.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};

/// Number of groups of a set of `capacity` casters.
pub fn group_count(capacity: u32) -> u32 {
    capacity.div_ceil(CHUNK_SIZE)
}
