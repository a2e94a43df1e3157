//! Conservative bounds of each light's influence.
use crate::model::{Light, LightKind, View};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Largest edge of a cluster \[pixels\].
pub const MAX_TILE: u32 = 256;
/// Header of a cluster whose list did not fit. WGSL: `wgsl/records/light.wgsl`.
pub const ALL_LIGHTS: u32 = u32::MAX;

/// Planes around the cone of a spot light.
pub const PLANES: usize = 6;
/// Fixed-point scale of offsets (in radii) and of normals. Squares and products fit 32 bits.
pub const UNIT: f32 = 8192.0;

/// Conservative bounds of a light's influence: a sphere, and for a spot the planes around its cone.
/// 4 texels; WGSL: `crates/gobo-picture/wgsl/records/picture.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Reach {
    /// Centre of the sphere: x to the right, y down, z along the view axis \[m\].
    pub center: Vec3,
    /// Reciprocal of the radius [1/m]; 0: everywhere.
    pub per_radius: f32,
    /// Outward normals, and their offsets from the centre in radii, all in units of `1 / UNIT`.
    pub planes: [[i16; 4]; PLANES],
}

/// Texels of a [`Reach`].
pub const REACH_TEXELS: u32 = 4;
const _: () = assert!(size_of::<Reach>() == REACH_TEXELS as usize * 16);

impl Reach {
    /// The reach of a light, seen by the camera.
    pub fn new(light: &Light, camera: &View) -> Self {
        let everywhere = Self { center: Vec3::ZERO, per_radius: 0.0, planes: [[0; 4]; PLANES] };
        let (position, cone) = match light.kind.with_unit_direction() {
            LightKind::Directional { .. } => return everywhere,
            LightKind::Spot { position, direction, angle } => (position, Some((direction, angle))),
            LightKind::Point { position } => (position, None),
        };
        let down = Vec3::new(1.0, -1.0, -1.0);
        let center = camera.view_from_world.transform_point3(position) * down;
        let corner = (camera.size.as_vec2() * 0.5 / camera.scale).extend(1.0) * camera.far;
        // Points and lights are transformed from world space by a few 32-bit operations.
        let eye = camera.position().abs().max_element() + position.abs().max_element();
        let margin = 1e-5 * (eye + corner.length());
        let farthest = center.length() + corner.length();
        let radius = light.range().map_or(farthest, |range| range.min(farthest)) + margin;
        if !(center.is_finite() && radius.is_finite() && radius > 0.0) {
            return everywhere;
        }
        let mut planes = [[0; 4]; PLANES];
        if let Some((direction, angle)) = cone {
            let axis = camera.view_from_world.transform_vector3(direction) * down;
            // The cosine that shading compares is rounded, which is a large angle near 0.
            let cosine = ((angle * 0.5).cos() - 2e-6).clamp(0.0, 1.0);
            let sine = (1.0 - cosine * cosine).sqrt();
            let right = axis.any_orthonormal_vector();
            let up = axis.cross(right);
            // Rounding of the normal, half a unit of each coordinate over the unit cube, plus the margin in
            // units of the radius.
            let slack = (2.0 + UNIT * margin / radius).min(32767.0).ceil();
            for (k, plane) in planes.iter_mut().enumerate() {
                let turn = k as f32 * (std::f32::consts::TAU / PLANES as f32);
                let side = right * turn.cos() + up * turn.sin();
                let normal = ((side * cosine - axis * sine) * UNIT).round();
                *plane = [normal.x, normal.y, normal.z, slack].map(|v| v as i16);
            }
        }
        Self { center, per_radius: 1.0 / radius, planes }
    }
}
