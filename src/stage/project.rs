//! project: casters to footprints, depth keys and tile rectangles, per view.
//!
//! In: chunks of `casters` or `triangles`, `views`, `materials`. Out: one footprint, key and rectangle per
//! (caster, view), at an index that the CPU knows; for Gaussians and triangles also a setup.
use crate::gpu::KernelDesc;

/// Casters of a chunk: invocations of a workgroup.
pub const CHUNK_SIZE: u32 = 256;

/// Footprints of particles, bricks and capsules.
pub const PARTICLES: KernelDesc = KernelDesc {
    constants: &[("WORKGROUP_SIZE", CHUNK_SIZE as f64)],
    ..KernelDesc::new("project_particles", "project/project_particles.wgsl")
};

/// Footprints of Gaussians.
pub const GAUSSIANS: KernelDesc = KernelDesc {
    constants: &[("WORKGROUP_SIZE", CHUNK_SIZE as f64)],
    ..KernelDesc::new("project_gaussians", "project/project_gaussians.wgsl")
};

/// Footprints and setups of triangles.
pub const TRIANGLES: KernelDesc = KernelDesc {
    constants: &[("WORKGROUP_SIZE", CHUNK_SIZE as f64)],
    ..KernelDesc::new("project_triangles", "project/project_triangles.wgsl")
};

crate::records::gpu_struct! {
    /// A run of casters for one view. WGSL: `wgsl/records/batch.wgsl`.
    #[derive(Eq)]
    pub struct Chunk {
        /// Index of the view in the batch.
        pub view: u32,
        pub first_caster: u32,
        /// Number of casters, at most [`CHUNK_SIZE`].
        pub count: u32,
        pub first_footprint: u32,
    }
}

crate::records::gpu_struct! {
    /// WGSL: `wgsl/records/batch.wgsl`.
    #[derive(Default, Eq)]
    pub struct ProjectParams {
        pub chunk_count: u32,
        /// 1: tiny particles take the scatter path.
        pub scatter: u32,
        /// Footprint of the first triangle less the index of its setup, modulo 2^32: setups of Gaussians come
        /// first.
        pub first_setup: u32,
        /// Footprint of the Gaussian with setup 0, modulo 2^32: the host's Gaussians come behind all others.
        pub first_gaussian: u32,
        /// 1: the camera's list includes casters without shadows.
        pub include_non_casters: u32,
        /// 1: depth keys of perspective views are distances from the light or the eye.
        pub by_distance: u32,
    }
}

/// Workgroup grid for `count` chunks or tiles.
pub fn grid(count: u32) -> [u32; 3] {
    // Chunks in a row of workgroups, which every adapter allows.
    const MAX_X: u32 = 32768;
    [count.clamp(1, MAX_X), count.div_ceil(MAX_X).max(1), 1]
}
