//! Lights as kernels read them.
use super::GpuView;
use crate::model::{Light, LightKind, View};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Lights of a picture. A point that asks all of them, nine taps each, stays below the 65,535
/// iterations that llvmpipe allows an invocation.
pub const MAX_LIGHTS: usize = 4096;
/// Shadow views of a picture: as many as all lights may have, four shadows of six views each.
pub const MAX_SHADOW_VIEWS: usize = 4 * 6 * MAX_LIGHTS;
/// Texels of a [`GpuLight`]. WGSL: `wgsl/records/light.wgsl`.
pub const LIGHT_TEXELS: u32 = 4;
const _: () = assert!(size_of::<GpuLight>() == LIGHT_TEXELS as usize * 16);
/// Texels of a [`GpuView`]. WGSL: `wgsl/records/light.wgsl`.
pub const VIEW_TEXELS: u32 = 8;
const _: () = assert!(size_of::<GpuView>() == VIEW_TEXELS as usize * 16);

/// Numbers of [`LightKind`] in [`GpuLight::kind`].
pub const LIGHT_DIRECTIONAL: u32 = 0;
pub const LIGHT_SPOT: u32 = 1;
pub const LIGHT_POINT: u32 = 2;

/// Of [`GpuLight::traits`].
pub const SHAFTS_BIT: u32 = 1;

/// WGSL: `wgsl/records/light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GpuLight {
    /// World space [m].
    pub position: Vec3,
    pub kind: u32,
    /// Of travel: unit, world space.
    pub direction: Vec3,
    pub first_view: u32,
    /// Times the intensity.
    pub color: Vec3,
    /// 0: casts no shadow.
    pub view_count: u32,
    /// Cosines of half the angle of a spot: where its light ends, and where it begins to fade.
    pub cone_outer: f32,
    pub cone_inner: f32,
    /// One over the square of the range [1/m^2]; 0 where the light has no end.
    pub per_range2: f32,
    /// [`SHAFTS_BIT`] where the air scatters its light; above it the number of its area, and 1.
    pub traits: u32,
}
crate::gpu_layout!(GpuLight {
    position,
    kind,
    direction,
    first_view,
    color,
    view_count,
    cone_outer,
    cone_inner,
    per_range2,
    traits
});

impl GpuLight {
    /// `views`: the shadow views of all lights.
    pub fn new(light: &Light, index: usize, views: &[View]) -> Self {
        let own = |view: &View| view.light == Some(index);
        let (kind, position, direction, angle) = match light.kind.with_unit_direction() {
            LightKind::Directional { direction } => (LIGHT_DIRECTIONAL, Vec3::ZERO, direction, 0.0),
            LightKind::Spot { position, direction, angle } => {
                (LIGHT_SPOT, position, direction, angle)
            }
            LightKind::Point { position } => (LIGHT_POINT, position, Vec3::NEG_Y, 0.0),
        };
        Self {
            position,
            kind,
            direction,
            first_view: views.iter().position(own).unwrap_or(0) as u32,
            color: light.color * light.intensity,
            view_count: views.iter().filter(|view| own(view)).count() as u32,
            cone_outer: (angle * 0.5).cos(),
            cone_inner: (angle * 0.5 * 0.85).cos(),
            per_range2: light.range().map_or(0.0, |range| 1.0 / (range * range)),
            traits: if light.shafts { SHAFTS_BIT } else { 0 },
        }
    }

    /// Number of its area.
    pub fn area(&self) -> Option<usize> {
        (self.traits as usize / 2).checked_sub(1)
    }
}
