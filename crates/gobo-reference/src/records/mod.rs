//! Records of pictures, which the library itself does not read.
mod air;
mod bloom;
mod cluster;
mod occlusion;

pub use air::{AIR_CELL, AirParams, air_columns};
pub use bloom::{bloom_sizes, refraction_levels};
pub use cluster::{ClusterCounters, ClusterGrid, ClusterParams};
pub use occlusion::OcclusionRadius;
