//! CPU reference of `wgsl/shade/air_*.wgsl` and `crates/gobo-picture/wgsl/shade/air.wgsl`: single scattering
//! towards the eye, as a volume of columns of pixels and slices of depth.
use super::{caster_hit::metres_per_depth, shading::Lighting, threads::each};
use crate::records::{AIR_CELL, AirParams, air_columns};
use glam::{Mat4, UVec2, Vec2, Vec3};
use gobo::{
    model::within_pixel,
    records::{GpuLight, GpuView, LIGHT_DIRECTIONAL, LIGHT_SPOT, SHAFTS_BIT},
};
use std::f32::consts::FRAC_1_PI;

/// Light scattered between the eye and the end of each slice.
#[derive(Clone, Debug)]
pub struct AirVolume {
    view: GpuView,
    extinction: Vec3,
    size: UVec2,
    slices: u32,
    /// First column \[pixels\].
    shift: Vec2,
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
    /// No air.
    pub const CLEAR: Self = Self { light: Vec3::ZERO, left: Vec3::ONE };
}

/// Optical depth of a slice below which a series avoids 0/0; its next term is a sixth of the square.
pub const THIN: f32 = 1e-3;

/// Angle at a lamp between two samples \[radians\]: half a degree.
pub const SAMPLE_ANGLE: f32 = 0.008_726_6;
/// Fewest samples of a light in a slice: the edge of a shaft across the slice is then no step.
pub const MIN_AIR_SAMPLES: u32 = 2;
/// Most samples of a light in a slice.
pub const MAX_AIR_SAMPLES: u32 = 16;
/// Most samples of all lights in a slice, unless each light has the minimum: the loops of an invocation share
/// llvmpipe's 65,535 iterations.
pub const MAX_LIT_SAMPLES: u32 = 256;
/// Distance from a lamp below which its light no longer rises \[m\].
pub const NEAREST: f32 = 0.01;
/// Replaces 0 in a divisor.
pub const TINY: f32 = 1e-20;

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

/// Middle of a column: `eye + direction t`, where t is the distance along the camera's axis, world space.
struct ColumnRay {
    eye: Vec3,
    direction: Vec3,
    /// Offset of the samples in a slice, in their distances, -0.5 to 0.5.
    phase: f32,
}

/// Offset of a picture's sample from the middles of its pixels \[pixels\]: the shear of the camera's axis.
fn sample_offset(view: &GpuView, world_from_view: &Mat4) -> Vec2 {
    let back = world_from_view.z_axis;
    let shear = Vec2::new(-back.dot(world_from_view.x_axis), back.dot(world_from_view.y_axis));
    within_pixel(shear * view.scale)
}

impl ColumnRay {
    /// Mean radiance that the air between two distances `ends` scatters back along the ray, per unit of
    /// scattering optical depth. Samples of a lamp are at even angles seen from it (Kulla and Fajardo 2012,
    /// section 4), as many as its light needs, and only inside the cone of a spot.
    fn scattered(
        &self,
        lighting: &Lighting<'_>,
        index: usize,
        params: &AirParams,
        ends: Vec2,
    ) -> Vec3 {
        let light = &lighting.lights()[index];
        let (ray, metres) = (self.direction.normalize(), self.direction.length());
        let origin = self.eye - light.position;
        let lit = match light.kind {
            LIGHT_SPOT => in_cone(light, origin, self.direction, ends),
            _ => ends,
        };
        if lit.x >= lit.y {
            return Vec3::ZERO;
        }
        // Distance along the ray from the point nearest to the lamp [m].
        let nearest = origin.dot(ray);
        let (low, high) = (lit.x * metres + nearest, lit.y * metres + nearest);
        let apart = (origin - ray * nearest).length().max(NEAREST);
        let is_local = light.kind != LIGHT_DIRECTIONAL;
        let seen = (apart * (high - low)).atan2(apart * apart + low * high);
        let angle = if is_local { seen } else { 0.0 };
        let most = (MAX_LIT_SAMPLES / lighting.lights().len() as u32)
            .clamp(MIN_AIR_SAMPLES, MAX_AIR_SAMPLES);
        let wanted = ((angle / SAMPLE_ANGLE).ceil() as u32).min(most);
        // Those of the pictures through all samples of a pixel interleave.
        let count = wanted.div_ceil(params.pictures).max(MIN_AIR_SAMPLES);
        let sample = |i: u32| {
            let part = (i as f32 + 0.5 + self.phase) / count as f32;
            let (at, share) = if is_local {
                let turn = Vec2::new((angle * part).cos(), (angle * part).sin());
                let turned =
                    apart * Vec2::new(low, apart).dot(turn) / Vec2::new(apart, -low).dot(turn);
                let at = turned.clamp(low, high);
                (at, (apart + at * at / apart) * angle)
            } else {
                (low + (high - low) * part, high - low)
            };
            // Length of ray per sample, in slices.
            let share = share / (metres * (ends.y - ends.x) * count as f32);
            let point = self.eye + ray * (at - nearest);
            lighting.scattered(index, point, ray, params.anisotropy) * share
        };
        (0..count).map(sample).sum()
    }
}

/// Part of the ray `origin + direction t`, with t within `ends`, inside the cone of a spot at the origin;
/// empty where x > y.
fn in_cone(light: &GpuLight, origin: Vec3, direction: Vec3, ends: Vec2) -> Vec2 {
    // A point x is in it where dot(x, light.direction) >= cosine |x|; squared, a t^2 + 2 b t + c >= 0.
    let (along, start) = (direction.dot(light.direction), origin.dot(light.direction));
    let square = light.cone_outer * light.cone_outer;
    let curved = along * along - square * direction.length_squared();
    let a = if curved.abs() < TINY { TINY } else { curved };
    let b = along * start - square * direction.dot(origin);
    let c = start * start - square * origin.length_squared();
    let inner = b * b - a * c;
    let root = inner.max(0.0).sqrt();
    let q = if b < 0.0 { root - b } else { -(b + root) };
    let (first, second) = (q / a, c / if q.abs() < TINY { TINY } else { q });
    let (low, high) = (first.min(second), first.max(second));
    // Across the cone the part is between the roots, unless they belong to its mirror image. Along the cone,
    // the ray leaves one of the two at one root and enters the other at the other root.
    if a < 0.0 {
        let is_missed = inner < 0.0 || start - along * b / a < 0.0;
        let lit = Vec2::new(ends.x.max(low), ends.y.min(high));
        if is_missed { Vec2::X } else { lit }
    } else if along > 0.0 {
        Vec2::new(ends.x.max(high), ends.y)
    } else {
        Vec2::new(ends.x, ends.y.min(low))
    }
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
        let offset = sample_offset(view, world_from_view);
        let shift = offset * AIR_CELL as f32;
        let column = |i: usize| {
            let cell = UVec2::new(i as u32 % size.x, i as u32 / size.x);
            let pixel = (cell.as_vec2() + 0.5) * AIR_CELL as f32 + shift;
            let slope = (pixel - view.size * 0.5) / view.scale;
            let direction = Vec3::new(slope.x, -slope.y, -1.0);
            let eye = world_from_view.transform_point3(Vec3::ZERO);
            let direction = world_from_view.transform_vector3(direction);
            let ray = ColumnRay { eye, direction, phase: offset.x };
            let range = view.far - view.near;
            let length = range / params.slices as f32 * direction.length();
            let tau = params.extinction * length;
            let passed = (-tau).map(f32::exp);
            let share = params.scattering * length * tau.map(mean_left);
            let (mut light, mut left) = (Vec3::ZERO, Vec3::ONE);
            let slice = |k: u32| {
                let parts = Vec2::new(k as f32, k as f32 + 1.0) / params.slices as f32;
                let ends = view.near + parts * range;
                let lights = (0..lighting.lights().len())
                    .filter(|&light| lighting.lights()[light].traits & SHAFTS_BIT != 0);
                let of_lights = lights.map(|light| ray.scattered(lighting, light, params, ends));
                light += (params.ambient + of_lights.sum::<Vec3>()) * (left * share);
                left *= passed;
                light
            };
            (0..params.slices).map(slice).collect()
        };
        let columns = each((size.x * size.y) as usize, column);
        let extinction = params.extinction;
        Self { view: *view, extinction, size, slices: params.slices, shift, columns }
    }

    /// Air in front of light depth `depth` in the camera's view.
    pub fn at(&self, pixel: Vec2, depth: f32) -> AirBefore {
        let length = depth.clamp(0.0, 1.0) * metres_per_depth(&self.view, pixel);
        let left = (-self.extinction * length).map(f32::exp);
        AirBefore { light: self.light(pixel, depth), left }
    }

    fn light(&self, pixel: Vec2, depth: f32) -> Vec3 {
        let last = (self.size - 1).as_vec2();
        let at = ((pixel - self.shift) / AIR_CELL as f32 - 0.5).clamp(Vec2::ZERO, last);
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
