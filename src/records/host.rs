//! Host casters in the host's buffers, converted to records. WGSL: `wgsl/records/host.wgsl`.
use super::gaussian::gaussian_marks;
use crate::model::{GaussianOpacity, Material};
use glam::{UVec2, UVec3, Vec3};

/// Farthest position of a host caster from the origin along each axis \[m\].
pub const MAX_COORDINATE: f32 = 1e7;

/// Half a quad's diagonal, rounded up \[radii\].
pub const DIAGONAL: f32 = 1.4143;

crate::records::gpu_struct! {
    /// Parameters of `load` for a set of casters.
    #[derive(Default)]
    pub struct LoadParams {
        /// Capacity of the set \[casters\].
        pub capacity: u32,
        /// 1: the number of casters is in `host_counts`.
        pub is_counted: u32,
        pub count_index: u32,
        pub group_count: u32,
        pub first_group: u32,
        /// First group's first caster, in the buffer of records.
        pub first_caster: u32,
        /// Reach of a quad in its group's box \[radii\].
        pub quad_reach: f32,
        /// 1: a caster without a radius is no caster, and is not counted.
        pub may_be_none: u32,
        /// Materials that the set may use, a bit each.
        pub materials: [[u32; 4]; 4],
        /// Axes of the first group's first Gaussian, in the buffer of records.
        pub first_axes: u32,
        /// First record of the buffer, among all records.
        pub first_record: u32,
        pub pad_0: u32,
        pub pad_1: u32,
    }
}

crate::records::gpu_struct! {
    /// Values of a material that its Gaussians need.
    #[derive(Default)]
    pub struct GaussianLook {
        /// [`NEUTRAL_BIT`](super::NEUTRAL_BIT), [`MEDIUM_BIT`](super::MEDIUM_BIT).
        pub marks: u32,
        /// Extinction of a medium of opacity 1 [1/m].
        pub density: f32,
        /// Largest opacity.
        pub most: f32,
        pub pad: u32,
    }
}

impl GaussianLook {
    /// The look of Gaussians of a material.
    pub fn new(material: &Material) -> Self {
        let density = match material.gaussian {
            GaussianOpacity::Splat => 0.0,
            GaussianOpacity::Medium { density } => density,
        };
        Self { marks: gaussian_marks(material), density, most: material.gaussian.most(), pad: 0 }
    }
}

crate::records::gpu_struct! {
    /// A run of casters of a set: one workgroup of `load`.
    #[derive(Default)]
    pub struct HostGroup {
        /// Lower corner of the box around their spheres, world space \[m\].
        pub low: Vec3,
        /// Number of valid casters: the group's first records.
        pub count: u32,
        pub high: Vec3,
        /// Least alpha of its valid casters.
        pub least_alpha: f32,
    }
}

crate::records::gpu_struct! {
    /// Counters of `load`.
    #[derive(Default, Eq)]
    pub struct LoadCounters {
        pub taken: u32,
        /// Casters with a number that is infinite, NaN or out of range.
        pub skipped: u32,
    }
}

impl LoadCounters {
    /// Splits a buffer of groups: its first element holds the counters.
    pub fn split(buffer: &[HostGroup]) -> (Self, &[HostGroup]) {
        let (first, groups) = buffer.split_first().expect("the counters come first");
        (bytemuck::pod_read_unaligned(&bytemuck::bytes_of(first)[..size_of::<Self>()]), groups)
    }
}

crate::records::gpu_struct! {
    /// A grid of the host, and the slots of its bricks.
    #[derive(Default, Eq)]
    pub struct HostGridParams {
        /// \[voxels\]
        pub size: UVec3,
        /// Slot of its first brick in `voxels`.
        pub first_slot: u32,
        /// Bricks along x and y.
        pub bricks: UVec2,
        /// Slots of `voxels` along x and y.
        pub slots: UVec2,
        pub brick_count: u32,
        /// Record of its first brick in `bricks`.
        pub first_record: u32,
        pub material: u32,
        pub pad: u32,
    }
}

crate::records::gpu_struct! {
    /// Parameters of `cull` for a list.
    #[derive(Default, Eq)]
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
}
