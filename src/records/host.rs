//! Casters in buffers of the host's, on their way to records. WGSL: `wgsl/records/host.wgsl`.
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// How far from the origin a caster of the host's may be, along each axis [m].
pub const FARTHEST_PLACE: f32 = 1e7;

/// What `load` needs of a set of casters.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct LoadParams {
    /// Casters at most.
    pub capacity: u32,
    /// 1: how many there are is in `host_counts`.
    pub is_counted: u32,
    pub count_index: u32,
    pub group_count: u32,
    pub first_group: u32,
    /// Record of the first group's first caster.
    pub first_caster: u32,
    pub pad_0: u32,
    pub pad_1: u32,
    /// That the set may have, a bit each.
    pub materials: [[u32; 4]; 4],
}
crate::gpu_layout!(LoadParams {
    capacity,
    is_counted,
    count_index,
    group_count,
    first_group,
    first_caster,
    pad_0,
    pad_1,
    materials
});

/// Casters of a set side by side: one workgroup of `load`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct HostGroup {
    /// Lower corner of the box around their spheres, world space [m].
    pub low: Vec3,
    /// Usable casters: the group's first records.
    pub count: u32,
    pub high: Vec3,
    pub pad_0: u32,
}
crate::gpu_layout!(HostGroup { low, count, high, pad_0 });

/// What `load` counted.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct LoadCounters {
    pub taken: u32,
    /// That have a number that is not finite or out of range.
    pub skipped: u32,
}
crate::gpu_layout!(LoadCounters { taken, skipped });

/// What `cull` needs of a list.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct CullParams {
    pub view_count: u32,
    pub group_count: u32,
    pub first_group: u32,
    /// Record of the first caster of all sets.
    pub first_caster: u32,
    /// First footprint of the list's host casters.
    pub first_footprint: u32,
    pub pad_0: u32,
    pub pad_1: u32,
    pub pad_2: u32,
}
crate::gpu_layout!(CullParams {
    view_count,
    group_count,
    first_group,
    first_caster,
    first_footprint,
    pad_0,
    pad_1,
    pad_2
});

/// What a list holds of the host's casters.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Listed {
    pub chunk_count: u32,
    /// With all that the list has before them.
    pub footprint_end: u32,
}
crate::gpu_layout!(Listed { chunk_count, footprint_end });
