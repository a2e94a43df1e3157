//! CPU reference of `wgsl/mask/*.wgsl`: the share of each light that reaches each pixel.
use super::{
    shading::{Lighting, Point, PointKind},
    threads::each,
};
use glam::{IVec2, UVec2, Vec2, Vec3, Vec4};
use gobo::{
    model::{MaskSettings, View},
    records::{COLORED_BIT, GpuView, MaskSlots, SLOTS, mask_size},
};

/// Depths that differ by less count as equal: neighbouring pixels of a floor differ only by rounding.
pub const TIED: f32 = 1e-6;
/// Sum of four neighbours' weights below which only the best neighbour is used.
pub const MIN_WEIGHT: f32 = 1e-3;
/// Error of a right angle between two normals, in units of the blur's depth tolerance.
pub const TURNED: f32 = 8.0;
/// Distance of the last tap from the centre, in standard deviations.
pub const WIDTHS: f32 = 2.0;

/// Cosine of the steepest slant that counts, times the length of the pixel's ray; negative towards the eye.
pub const MIN_FACING: f32 = -1e-3;

/// Surface that the camera sees in a pixel of the picture.
#[derive(Clone, Copy, Debug)]
pub struct SeenSurface {
    /// Id of its object, if it is a triangle.
    pub object: Option<u32>,
    /// Light depth in the camera's view; 1 without a surface.
    pub depth: f32,
    /// The surface as a receiver; `None` without one.
    pub point: Option<Point>,
}

/// A pixel of the masks, and its pixel in the picture.
#[derive(Clone, Copy, Debug)]
struct MaskedPixel {
    depth: f32,
    point: Option<Point>,
    pixel: UVec2,
}

/// Masks of a picture, at the picture's size.
#[derive(Clone, Debug)]
pub struct Masks {
    slots: MaskSlots,
    size: UVec2,
    /// Values layer by layer, row by row.
    values: Vec<Vec<Vec4>>,
}

impl Masks {
    /// Share of a light at a pixel; `None` if the light has no mask.
    pub fn share(&self, light: usize, point: &Point) -> Option<Vec3> {
        let slot = self.slots.of_lights[light];
        if slot == 0 || point.kind != PointKind::Solid {
            return None;
        }
        let (mask, channel) = texel(slot);
        let value = self.values[mask][(point.pixel.y * self.size.x + point.pixel.x) as usize];
        let is_colored = slot & COLORED_BIT != 0;
        Some(if is_colored { value.truncate() } else { Vec3::splat(value[channel]) })
    }

    /// Four bytes a pixel, layer by layer.
    pub fn bytes(&self) -> Vec<[u8; 4]> {
        let bytes = |value: &Vec4| value.to_array().map(|v| (v * 255.0).round() as u8);
        self.values.iter().flatten().map(bytes).collect()
    }
}

/// Mask and channel of a slot.
fn texel(slot: u32) -> (usize, usize) {
    let at = (slot & !COLORED_BIT) - 1;
    ((at / SLOTS) as usize, (at % SLOTS) as usize)
}

/// Value rounded to the format of masks.
fn stored(value: Vec4) -> Vec4 {
    (value.clamp(Vec4::ZERO, Vec4::ONE) * 255.0).round() / 255.0
}

/// Camera, and its visible surfaces row by row.
#[derive(Debug)]
pub struct MaskInput<'a> {
    /// Size and blur of the masks.
    pub settings: &'a MaskSettings,
    /// The camera.
    pub camera: &'a View,
    /// Lights and their maps.
    pub lighting: &'a Lighting<'a>,
    /// Surfaces of all pixels, row by row.
    pub seen: &'a [SeenSurface],
}

/// A grid of surfaces, row by row.
struct Grid {
    size: UVec2,
    surfaces: Vec<MaskedPixel>,
}

impl Grid {
    fn at(&self, at: UVec2) -> &MaskedPixel {
        &self.surfaces[(at.y * self.size.x + at.x) as usize]
    }
}

struct Filter<'a> {
    settings: &'a MaskSettings,
    view: GpuView,
}

/// Tangent plane of a pixel. A point at distance d along the axis, in a pixel at offset o, is `d (here + turn
/// . o) - off` from the plane, in units of the blur's depth tolerance.
struct PixelPlane {
    pixel: Vec2,
    /// Interpolated normal, world space.
    normal: Vec3,
    /// Distance of the pixel's surface along the camera's axis \[m\].
    distance: f32,
    here: f32,
    turn: Vec2,
    off: f32,
}

impl MaskInput<'_> {
    /// Masks of the lights that have `slots`, blurred.
    pub fn masks(&self, slots: MaskSlots) -> Masks {
        let view = self.camera.to_gpu(0, UVec2::ZERO, 0);
        let filter = Filter { settings: self.settings, view };
        let size = self.camera.size;
        let pixel = |i: u32| UVec2::new(i % size.x, i / size.x);
        let whole = |(i, seen): (u32, &SeenSurface)| MaskedPixel {
            depth: seen.depth,
            point: seen.point,
            pixel: pixel(i),
        };
        let whole = Grid { size, surfaces: (0..).zip(self.seen).map(whole).collect() };
        let half = self.settings.half.then(|| shrunk(&whole));
        let grid = half.as_ref().unwrap_or(&whole);
        let values = (0..slots.count as usize)
            .map(|mask| {
                let mut values = self.look_up(grid, &slots, mask);
                if self.settings.taps > 1 {
                    values = filter.blur(grid, &values, IVec2::X);
                    values = filter.blur(grid, &values, IVec2::Y);
                }
                match &half {
                    Some(half) => filter.enlarge(&whole, half, &values),
                    None => values,
                }
            })
            .collect();
        Masks { slots, size, values }
    }

    /// Look-up of one mask.
    fn look_up(&self, grid: &Grid, slots: &MaskSlots, mask: usize) -> Vec<Vec4> {
        each(grid.surfaces.len(), |i| {
            let surface = &grid.surfaces[i];
            let mut passed = Vec4::ONE;
            let Some(point) = surface.point.filter(|_| surface.depth < 1.0) else { return passed };
            for (light, &slot) in slots.of_lights.iter().enumerate() {
                if slot == 0 || texel(slot).0 != mask {
                    continue;
                }
                let share = self.lighting.mask_share(light, &point);
                if slot & COLORED_BIT != 0 {
                    passed = passed.min(share.extend(1.0));
                } else {
                    let channel = texel(slot).1;
                    passed[channel] = passed[channel].min(share.y);
                }
            }
            stored(passed)
        })
    }
}

impl Filter<'_> {
    /// Distance along the camera's axis \[m\].
    fn distance(&self, depth: f32) -> f32 {
        self.view.near + depth * (self.view.far - self.view.near)
    }

    fn plane(&self, surface: &MaskedPixel, seen: &Point) -> PixelPlane {
        let view = &self.view;
        let pixel = surface.pixel.as_vec2() + 0.5;
        let slope = (pixel - view.size * 0.5) / view.scale;
        let face = view.view_from_world.transform_vector3(seen.face);
        let distance = self.distance(surface.depth);
        let tolerated = self.settings.sensitivity / distance;
        let here = (face.x * slope.x - face.y * slope.y - face.z) * tolerated;
        let turn = Vec2::new(face.x, -face.y) / view.scale * tolerated;
        PixelPlane { pixel, normal: seen.normal, distance, here, turn, off: distance * here }
    }

    /// Distance of a surface from the plane, in units of the blur's depth tolerance.
    fn error(&self, plane: &PixelPlane, surface: &MaskedPixel) -> f32 {
        let pixel = surface.pixel.as_vec2() + 0.5;
        let ray = plane.here + plane.turn.dot(pixel - plane.pixel);
        (self.distance(surface.depth) * ray - plane.off).abs()
    }

    /// Weight of a surface for the pixel of a plane; 0 without a surface.
    fn weight(&self, plane: &PixelPlane, surface: &MaskedPixel) -> f32 {
        let Some(seen) = surface.point.filter(|_| surface.depth < 1.0) else { return 0.0 };
        let facing = plane.normal.dot(seen.normal).max(0.0);
        (1.0 - self.error(plane, surface)).max(0.0) * facing.powi(8)
    }

    /// Lengths of a pixel's step to the right and down on a surface parallel to the screen, relative to those
    /// on the plane's surface; at most 1.
    fn upright_shares(&self, plane: &PixelPlane, seen: &Point) -> Vec2 {
        let slope = (plane.pixel - self.view.size * 0.5) / self.view.scale;
        let ray = Vec3::new(slope.x, -slope.y, -1.0);
        let normal = self.view.view_from_world.transform_vector3(seen.face);
        // Change of the distance along the axis per step.
        let turn = normal.truncate() / normal.dot(ray).min(MIN_FACING);
        let square = 1.0 - 2.0 * turn * ray.truncate() + turn * turn * ray.length_squared();
        square.max(Vec2::ONE).map(|square| 1.0 / square.sqrt())
    }

    fn blur(&self, grid: &Grid, values: &[Vec4], along: IVec2) -> Vec<Vec4> {
        let side = (self.settings.taps / 2) as i32;
        each(values.len(), |i| {
            let middle = &grid.surfaces[i];
            let Some(seen) = middle.point.filter(|_| middle.depth < 1.0) else { return values[i] };
            let plane = self.plane(middle, &seen);
            let scale = self.settings.depth_scale;
            let nearer = if scale > 0.0 { (scale / plane.distance).min(1.0) } else { 1.0 };
            let upright = match self.settings.anisotropic {
                true => self.upright_shares(&plane, &seen).dot(along.as_vec2()),
                false => 1.0,
            };
            let width = (side as f32 / WIDTHS * nearer * upright).max(0.01);
            let at = UVec2::new(i as u32 % grid.size.x, i as u32 / grid.size.x).as_ivec2();
            let (mut sum, mut weights) = (Vec4::ZERO, 0.0);
            for step in -side..=side {
                let texel = at + along * step;
                if texel.cmplt(IVec2::ZERO).any() || texel.cmpge(grid.size.as_ivec2()).any() {
                    continue;
                }
                let texel = texel.as_uvec2();
                let gaussian = (-0.5 * (step as f32 / width).powi(2)).exp();
                // A surface always counts for itself, whatever its facet's orientation.
                let near = if step == 0 { 1.0 } else { self.weight(&plane, grid.at(texel)) };
                sum += values[(texel.y * grid.size.x + texel.x) as usize] * gaussian * near;
                weights += gaussian * near;
            }
            stored(sum / weights)
        })
    }

    fn enlarge(&self, whole: &Grid, half: &Grid, values: &[Vec4]) -> Vec<Vec4> {
        each(whole.surfaces.len(), |i| {
            let surface = &whole.surfaces[i];
            let Some(seen) = surface.point.filter(|_| surface.depth < 1.0) else {
                return Vec4::ONE;
            };
            let plane = self.plane(surface, &seen);
            let middle = (surface.pixel.as_vec2() + 0.5) * 0.5 - 0.5;
            let (first, share) = (middle.floor(), middle - middle.floor());
            let (mut sum, mut weights) = (Vec4::ZERO, 0.0);
            let (mut best, mut least) = (Vec4::ONE, 1e30);
            for step in [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| IVec2::new(x, y)) {
                let texel = first.as_ivec2() + step;
                let texel = texel.clamp(IVec2::ZERO, half.size.as_ivec2() - 1).as_uvec2();
                let other = half.at(texel);
                let near = Vec2::select(step.cmpeq(IVec2::ONE), share, 1.0 - share);
                let weight = near.element_product() * self.weight(&plane, other);
                let value = values[(texel.y * half.size.x + texel.x) as usize];
                let is_seen = other.depth < 1.0;
                let turned = other.point.map_or(0.0, |other| 1.0 - plane.normal.dot(other.normal));
                let off = self.error(&plane, other) + TURNED * turned;
                let error = if is_seen { off } else { 1e20 };
                sum += value * weight;
                weights += weight;
                if error < least {
                    (best, least) = (value, error);
                }
            }
            stored(if weights > MIN_WEIGHT { sum / weights.max(1e-9) } else { best })
        })
    }
}

/// Keeps one of each 2 x 2 pixels, alternately the nearest and the farthest; the first of equal ones.
fn shrunk(whole: &Grid) -> Grid {
    let size = mask_size(whole.size, true);
    let chosen = |i: u32| {
        let at = UVec2::new(i % size.x, i / size.x);
        let is_near = (at.x + at.y).is_multiple_of(2);
        let rank = |depth: f32| match depth {
            1.0.. => -1.0,
            _ if is_near => 1.0 - depth,
            _ => depth,
        };
        let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| at * 2 + UVec2::new(x, y));
        let four = four.map(|pixel| *whole.at(pixel.min(whole.size - 1)));
        let best = four.iter().map(|surface| rank(surface.depth)).fold(-1.0, f32::max);
        let tied = four.iter().find(|surface| rank(surface.depth) >= best - TIED);
        *tied.unwrap_or(&four[0])
    };
    Grid { size, surfaces: (0..size.element_product()).map(chosen).collect() }
}
