//! occlusion: ambient light that what is seen around a surface keeps from it.
//!
//! In: `composited` and `ambients` of the whole picture, by `shade`'s `composite`. `search` -> `occlusions`: at half the
//! size, the share of the ambient light that arrives. `apply` -> `radiance`, `pixels`.
use crate::{
    gpu::{KernelDesc, Tier},
    model::Occlusion,
};
use bytemuck::{Pod, Zeroable};

/// Edge of a workgroup [pixels].
pub const GROUP_SIZE: u32 = 8;

/// Radius of what occludes, of a tenth of the picture's height, if the scene does not say [heights of the picture].
pub const USUAL_RADIUS: f32 = 0.1;

const fn of(name: &'static str, root: &'static str) -> KernelDesc {
    KernelDesc { name, entry: name, root, with: &[], constants: &[], tiers: &[Tier::Core] }
}

pub const SEARCH: KernelDesc = of("occlusion_search", "occlusion/occlusion_search.wgsl");
pub const APPLY: KernelDesc = of("occlusion_apply", "occlusion/occlusion_apply.wgsl");

/// WGSL: `wgsl/occlusion/seen_point.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct OcclusionParams {
    /// Radius of the surroundings that occlude [m].
    pub radius: f32,
    /// Added to it, times the distance along the axis.
    pub radius_per_distance: f32,
}
crate::gpu_layout!(OcclusionParams { radius, radius_per_distance });

impl OcclusionParams {
    /// `fov_y`: of the camera [radians]; `None` without occlusion.
    pub fn new(occlusion: Occlusion, fov_y: f32) -> Option<Self> {
        match occlusion {
            Occlusion::None => None,
            Occlusion::Usual => {
                let height = 2.0 * (fov_y * 0.5).tan();
                Some(Self { radius: 0.0, radius_per_distance: USUAL_RADIUS * height })
            }
            Occlusion::Radius(radius) => Some(Self { radius, radius_per_distance: 0.0 }),
        }
    }
}
