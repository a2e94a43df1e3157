//! cluster: light lists of the froxels of the camera.
//!
//! The frustum is cut into clusters: squares of pixels, and slices that grow with the distance
//! (Olsson et al. 2012, "Clustered Deferred and Forward Shading", section 3).
//!
//! 1. `count` tests every light with every cluster, and keeps a bit for each and their sum per cluster.
//! 2. `scan` places the lists of the clusters one after another.
//! 3. `emit` writes the lists, in order of the lights' indices.
//!
//! A list that does not fit is not written: its cluster is shaded with all lights, and counted.
//!
//! Both deciding steps of the test are integer arithmetic on numbers made by correctly rounded operations,
//! so every device finds the same bits. The test is conservative: it errs towards reaching.
use super::kernel;
use gobo::gpu::KernelDesc;

/// Invocations of a workgroup of `count` and `emit`.
pub const LANES: u32 = 64;
/// Invocations of `scan`'s only workgroup.
const SCAN_LANES: u32 = 256;
/// Tests lights with clusters.
pub const COUNT: KernelDesc = KernelDesc {
    constants: &[("WORKGROUP_SIZE", LANES as f64)],
    ..kernel("cluster_count", "cluster/cluster.wgsl")
};

/// Places the lists.
pub const SCAN: KernelDesc = KernelDesc {
    constants: &[("WORKGROUP_SIZE", SCAN_LANES as f64)],
    ..kernel("cluster_scan", "cluster/cluster.wgsl")
};

/// Writes the lists of lights.
pub const EMIT: KernelDesc = KernelDesc {
    constants: &[("WORKGROUP_SIZE", LANES as f64)],
    ..kernel("cluster_emit", "cluster/cluster_emit.wgsl")
};
