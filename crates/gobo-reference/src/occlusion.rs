//! CPU reference of `wgsl/occlusion/*.wgsl`: ambient occlusion by the surfaces visible around a pixel
//! (Jimenez et al. 2016, "Practical Real-Time Strategies for Accurate Indirect Occlusion", section 4).
use super::{air::TINY, threads::each};
use crate::records::OcclusionRadius;
use glam::{IVec2, Mat4, UVec2, Vec2, Vec3};
use gobo::records::GpuView;
use std::f32::consts::{FRAC_PI_2, PI};

/// Directions of a pixel; the next three pixels have others between them.
pub const OCCLUDER_DIRECTIONS: u32 = 3;
/// Samples along a direction, to either side; 4x4 pixels have others between them.
pub const OCCLUDER_STEPS: u32 = 6;
/// Offset of each of four pixels' samples within a step \[quarters\].
pub const PLACES: u32 = 0x2431;
/// Distance of the farthest sample \[heights of the picture\].
pub const OCCLUDER_REACH: f32 = 0.25;
/// Least length of a normal's projection into a slice.
pub const SLICE_FACING: f32 = 1e-3;
/// Square of the slope up to which the surroundings count as flat: depths are rounded.
pub const FLAT_SQUARE: f32 = 4e-6;
/// Distance of the sky, which lies on no surface's plane \[m\].
pub const SKY_DISTANCE: f32 = 1e20;
/// Distance from a pixel's plane at which another surface no longer counts \[radii\].
pub const OFF_PLANE: f32 = 0.1;
/// Weight of surfaces that do not count, for pixels without a neighbour on their own surface.
pub const OFF_PLANE_WEIGHT: f32 = 1e-4;
/// A pixel's opaque surface and the ambient light that it sends to the eye.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings {
    /// Light depth; 1 without a surface.
    pub depth: f32,
    /// Unit, world space; zero for a surface that faces the eye.
    pub normal: Vec3,
    /// Ambient light that reaches the eye.
    pub light: Vec3,
}

impl Surroundings {
    /// A pixel without a surface.
    pub const NONE: Self = Self { depth: 1.0, normal: Vec3::ZERO, light: Vec3::ZERO };
}

/// Search of occluders around all pixels of a picture.
struct Search<'a> {
    view: &'a GpuView,
    world_from_view: &'a Mat4,
    radius: OcclusionRadius,
    pixels: &'a [Surroundings],
    size: UVec2,
}

/// The plane of a search, through the eye's ray and a direction on the screen.
struct Slice {
    /// The surface's normal, divided by its length in the plane.
    above: Vec3,
    /// Tangent of the surface in the plane, unit.
    along: Vec3,
    /// Length of the normal in the plane.
    facing: f32,
    /// Angle from the direction to the eye to the normal \[radians\].
    tilt: f32,
}

impl Slice {
    fn new(direction: Vec2, normal: Vec3, to_eye: Vec3) -> Self {
        let across = Vec3::new(direction.x, -direction.y, 0.0).cross(to_eye).normalize();
        let inside = normal - across * normal.dot(across);
        let facing = inside.length().max(SLICE_FACING);
        let up = inside / facing;
        let along = up.cross(across);
        let tilt = (-along.dot(to_eye)).atan2(up.dot(to_eye));
        Self { above: normal / facing, along, facing, tilt }
    }

    /// Integral of the cosine from the direction to the eye up to a horizon \[radians\].
    fn arc(&self, horizon: f32) -> f32 {
        let tilt = self.tilt;
        0.25 * (tilt.cos() - (2.0 * horizon - tilt).cos() + 2.0 * horizon * tilt.sin())
    }
}

/// A picture's light, less the occluded part of its ambient light.
pub fn occluded(
    view: &GpuView,
    world_from_view: &Mat4,
    radius: OcclusionRadius,
    pixels: &[Surroundings],
    light: &[Vec3],
) -> Vec<Vec3> {
    let size = view.size.as_uvec2();
    let search = Search { view, world_from_view, radius, pixels, size };
    let half = (size + 1) / 2;
    let texel = |i: usize, width: u32| UVec2::new(i as u32 % width, i as u32 / width);
    let shares = each((half.x * half.y) as usize, |i| search.seen(texel(i, half.x)));
    each(pixels.len(), |i| {
        let share = search.share(&shares, half, texel(i, size.x));
        (light[i] - pixels[i].light * (1.0 - share)).max(Vec3::ZERO)
    })
}

impl Search<'_> {
    fn of(&self, pixel: UVec2) -> &Surroundings {
        &self.pixels[(pixel.y * self.size.x + pixel.x) as usize]
    }

    /// Position in view space.
    fn point(&self, pixel: Vec2, depth: f32) -> Vec3 {
        let slope = (pixel + 0.5 - self.view.size * 0.5) / self.view.scale;
        let distance = self.view.near + depth * (self.view.far - self.view.near);
        Vec3::new(slope.x, -slope.y, -1.0) * distance
    }

    /// Normal in view space.
    fn normal(&self, around_pixel: &Surroundings, point: Vec3) -> Vec3 {
        if around_pixel.normal == Vec3::ZERO {
            return -point.normalize();
        }
        let world_from_view = self.world_from_view;
        let axes = [world_from_view.x_axis, world_from_view.y_axis, world_from_view.z_axis];
        Vec3::from_array(axes.map(|axis| axis.truncate().dot(around_pixel.normal)))
    }

    fn radius_at(&self, point: Vec3) -> f32 {
        self.radius.metres - self.radius.per_distance * point.z
    }

    /// Share of the ambient light at a texel of half the resolution, and the distance of its surface.
    fn seen(&self, texel: UVec2) -> (f32, f32) {
        let pixel = texel * 2;
        let around_pixel = self.of(pixel);
        if around_pixel.depth >= 1.0 {
            return (1.0, SKY_DISTANCE);
        }
        let point = self.point(pixel.as_vec2(), around_pixel.depth);
        let (normal, to_eye) = (self.normal(around_pixel, point), -point.normalize());
        let turn = ((texel.x + texel.y) & 3) as f32 * 0.25;
        let twice = (texel.y << 1) ^ (((texel.y >> 1) & 1) * 7);
        let part = ((PLACES >> (4 * ((texel.x ^ twice) & 3))) & 7) as f32 * 0.25;
        let (mut seen, mut whole) = (0.0, 0.0);
        for i in 0..OCCLUDER_DIRECTIONS {
            let (sin, cos) = ((i as f32 + turn) * (PI / OCCLUDER_DIRECTIONS as f32)).sin_cos();
            let step = Vec2::new(cos, sin);
            let slice = Slice::new(step, normal, to_eye);
            let risen = |side: f32| self.risen(pixel, point, &slice, step * side, [side, part]);
            let right = (slice.tilt + FRAC_PI_2 - risen(1.0)).max(0.0);
            let left = (slice.tilt - FRAC_PI_2 + risen(-1.0)).min(0.0);
            seen += slice.facing * (slice.arc(left) + slice.arc(right)).max(0.0);
            whole += slice.facing * (slice.tilt.cos() + slice.tilt * slice.tilt.sin());
        }
        (if whole > 0.0 { seen / whole } else { 1.0 }, -point.z)
    }

    /// Angle above the surface's plane below which no light comes, on one side of a slice. `step`: to that
    /// side; `part`: of a step, offset of the first sample. Beyond its border the picture continues at the
    /// border's depth.
    fn risen(
        &self,
        pixel: UVec2,
        point: Vec3,
        slice: &Slice,
        step: Vec2,
        [side, part]: [f32; 2],
    ) -> f32 {
        let radius = self.radius_at(point);
        let reach = (radius * self.view.scale / -point.z).min(OCCLUDER_REACH * self.view.size.y);
        let mut least = 1.0_f32;
        for i in 0..OCCLUDER_STEPS {
            let part = (i as f32 + part) / OCCLUDER_STEPS as f32;
            let far = (part * part * reach).max(i as f32 + 1.0);
            let texel = pixel.as_vec2() + (step * far).map(f32::round_ties_even);
            let inside = texel.clamp(Vec2::ZERO, self.view.size - 1.0);
            let depth = self.of(inside.as_uvec2()).depth;
            let seen = self.point(inside, depth) - point;
            let rises = seen.dot(slice.above) * slice.facing;
            if depth >= 1.0 || rises * rises.abs() <= FLAT_SQUARE * seen.length_squared() {
                continue;
            }
            let away = self.point(texel, depth) - point;
            let (above, along) = (away.dot(slice.above), away.dot(slice.along) * side);
            let cosine = along / (along * along + above * above).max(TINY).sqrt();
            let square = away.length_squared() / (radius * radius);
            let share = ((1.0 - square) * (4.0 / 3.0)).clamp(0.0, 1.0);
            least = least.min(1.0 + (cosine - 1.0) * share);
        }
        least.clamp(-1.0, 1.0).acos()
    }

    /// Share of the ambient light at a pixel.
    fn share(&self, shares: &[(f32, f32)], half: UVec2, pixel: UVec2) -> f32 {
        let around_pixel = self.of(pixel);
        if around_pixel.depth >= 1.0 {
            return 1.0;
        }
        let point = self.point(pixel.as_vec2(), around_pixel.depth);
        let normal = self.normal(around_pixel, point);
        let (mut sum, mut weights) = (0.0, 0.0);
        for i in 0..25 {
            let texel = (pixel / 2).as_ivec2() - 2 + IVec2::new(i % 5, i / 5);
            let inside = texel.clamp(IVec2::ZERO, half.as_ivec2() - 1);
            let (share, distance) = shares[(inside.y as u32 * half.x + inside.x as u32) as usize];
            let near = (2.5 - (pixel.as_vec2() * 0.5 - texel.as_vec2()).abs())
                .clamp(Vec2::ZERO, Vec2::ONE);
            let slope = self.point((inside * 2).as_vec2(), 0.0) / self.view.near;
            let off =
                (slope * distance - point).dot(normal).abs() / (OFF_PLANE * self.radius_at(point));
            let weight = near.x * near.y * (1.0 - off).max(OFF_PLANE_WEIGHT);
            sum += share * weight;
            weights += weight;
        }
        sum / weights
    }
}
