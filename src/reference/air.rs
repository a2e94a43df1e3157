//! Twin of `wgsl/shade/air_*.wgsl` and `wgsl/shade/air.wgsl`: single scattering towards the eye, as a
//! volume of columns of pixels and slices of depth.
use super::{caster_hit::metres_per_depth, shading::Lighting, threads::each};
use crate::records::{AIR_CELL, AirParams, GpuView, air_columns};
use glam::{Mat4, UVec2, Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Light scattered between the eye and the end of each slice.
#[derive(Clone, Debug)]
pub struct AirVolume {
    view: GpuView,
    extinction: Vec3,
    size: UVec2,
    slices: u32,
    columns: Vec<Vec<Vec3>>,
}

/// Scattering and transmittance of the air in front of a light depth.
#[derive(Clone, Copy, Debug)]
pub struct AirBefore {
    /// Light that it scatters to the eye.
    pub light: Vec3,
    /// Transmittance for the light from behind it.
    pub left: Vec3,
}

impl AirBefore {
    pub const CLEAR: Self = Self { light: Vec3::ZERO, left: Vec3::ONE };
}

/// Optical depth of a slice below which a series is used, which has no 0/0; its next term is a sixth of the
/// square.
pub const THIN: f32 = 1e-3;

/// Mean of `exp(-x)` from 0 to `tau`.
fn mean_left(tau: f32) -> f32 {
    if tau < THIN { 1.0 - 0.5 * tau } else { (1.0 - (-tau).exp()) / tau }
}

/// Phase function of Henyey and Greenstein 1941; `cosine` between the incoming and outgoing directions, `g`
/// in -1..1.
pub fn phase(cosine: f32, g: f32) -> f32 {
    let spread = (1.0 + g * g - 2.0 * g * cosine).max(1e-6);
    0.25 * FRAC_1_PI * (1.0 - g * g) / (spread * spread.sqrt())
}

impl AirVolume {
    /// `view`: the camera's.
    pub fn new(
        view: &GpuView,
        world_from_view: &Mat4,
        lighting: &Lighting<'_>,
        params: &AirParams,
    ) -> Self {
        let size = air_columns(view.size.as_uvec2());
        let column = |i: usize| {
            let cell = UVec2::new(i as u32 % size.x, i as u32 / size.x);
            let pixel = (cell.as_vec2() + 0.5) * AIR_CELL as f32;
            let slope = (pixel - view.size * 0.5) / view.scale;
            let way = Vec3::new(slope.x, -slope.y, -1.0);
            let ray = world_from_view.transform_vector3(way).normalize();
            let range = view.far - view.near;
            let length = range / params.slices as f32 * way.length();
            let tau = params.extinction * length;
            let passed = (-tau).map(f32::exp);
            let share = params.scattering * length * tau.map(mean_left);
            let (mut light, mut left) = (Vec3::ZERO, Vec3::ONE);
            let slice = |k: u32| {
                let mut sum = Vec3::ZERO;
                for i in 0..params.samples {
                    let along = k as f32 + (i as f32 + 0.5) / params.samples as f32;
                    let distance = view.near + along / params.slices as f32 * range;
                    let point = world_from_view.transform_point3(way * distance);
                    sum += params.ambient + lighting.scattered(point, ray, params.anisotropy);
                }
                light += sum / params.samples as f32 * (left * share);
                left *= passed;
                light
            };
            (0..params.slices).map(slice).collect()
        };
        let columns = each((size.x * size.y) as usize, column);
        let extinction = params.extinction;
        Self { view: *view, extinction, size, slices: params.slices, columns }
    }

    /// Air in front of light depth `depth` in the camera's view.
    pub fn at(&self, pixel: Vec2, depth: f32) -> AirBefore {
        let length = depth.clamp(0.0, 1.0) * metres_per_depth(&self.view, pixel);
        let left = (-self.extinction * length).map(f32::exp);
        AirBefore { light: self.light(pixel, depth), left }
    }

    fn light(&self, pixel: Vec2, depth: f32) -> Vec3 {
        let last = (self.size - 1).as_vec2();
        let at = (pixel / AIR_CELL as f32 - 0.5).clamp(Vec2::ZERO, last);
        let low = at.floor().as_uvec2();
        let high = (low + 1).min(self.size - 1);
        let part = at - at.floor();
        let along = depth.clamp(0.0, 1.0) * self.slices as f32 - 1.0;
        let slice = along.floor() as i32;
        let layer = |slice: i32| {
            let texel =
                |x: u32, y: u32| self.columns[(y * self.size.x + x) as usize][slice as usize];
            if slice < 0 {
                return Vec3::ZERO;
            }
            let top = texel(low.x, low.y).lerp(texel(high.x, low.y), part.x);
            let bottom = texel(low.x, high.y).lerp(texel(high.x, high.y), part.x);
            top.lerp(bottom, part.y)
        };
        let far = layer((slice + 1).min(self.slices as i32 - 1));
        layer(slice).lerp(far, along - along.floor())
    }
}
