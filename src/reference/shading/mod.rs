//! Twin of `wgsl/records/light.wgsl`, `shading.wgsl`, `surface.wgsl` and `sheet.wgsl`: the light that
//! reaches a point, and what of it the camera sees.
mod levels;
mod receive;
pub mod soft;
mod tone;

pub use tone::to_screen;

use levels::Levels;

use super::air::phase;
use crate::{
    model::{Material, ReceiverPoint, Receives, Scene, View},
    records::{
        GpuLight, GpuView, LIGHT_DIRECTIONAL, LIGHT_SPOT, LightRecords, SHAFTS_BIT, ViewMaps,
        owner_tag,
    },
};
use glam::{Mat4, UVec2, Vec2, Vec3, Vec4Swizzles as _};
use std::f32::consts::FRAC_1_PI;

/// What lights the picture.
#[derive(Clone, Debug)]
pub struct Lighting<'a> {
    records: LightRecords,
    /// Of lights that have a size.
    levels: Levels,
    maps: &'a [ViewMaps],
    pub ambient: Vec3,
    background: Vec3,
    /// [m]
    bias: f32,
    /// [texels]
    normal_bias: f32,
}

/// A receiver as data: what is seen makes points, [`Lighting::light`] looks up the light that they send
/// to the eye.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    pub kind: PointKind,
    /// World space [m].
    pub position: Vec3,
    /// Of the plane, unit, on the eye's side; zero for none.
    pub face: Vec3,
    /// Interpolated, unit, on the eye's side; zero for none.
    pub normal: Vec3,
    /// Unit.
    pub to_eye: Vec3,
    /// How far what is in the map may lie off the point [m].
    pub reach: f32,
    pub receiver: Receiver,
    /// What it scatters of the light.
    pub albedo: Vec3,
    pub roughness: f32,
    pub gloss: Gloss,
    /// Light that it sends by itself.
    pub emission: Vec3,
}

/// How a point scatters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointKind {
    /// What comes from its face's side.
    Solid,
    /// What comes from both sides: a thin sheet.
    Sheet,
    /// It has no normal.
    Particle,
}

/// Who receives light.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    receives: Receives,
    /// Of its object.
    tag: u16,
    /// It is in no filter, so that none of what is translucent is its own.
    solid: bool,
}

impl Receiver {
    /// Tinted by all that is before it.
    pub const AIR: Self = Self { receives: Receives::Curve, tag: 0, solid: false };

    pub fn new(material: &Material, id: u32) -> Self {
        Self { receives: material.receives, tag: owner_tag(id), solid: false }
    }

    #[must_use]
    pub fn of_kind(self, kind: PointKind) -> Self {
        Self { solid: kind == PointKind::Solid, ..self }
    }
}

/// How much is mirrored: all of what reflects by itself, of the rest what shines like glass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gloss {
    pub reflectivity: f32,
    /// 1 of glass, 0 of what is not there.
    pub polish: f32,
}

impl Gloss {
    pub const SOLID: Self = Self { reflectivity: 0.0, polish: 1.0 };

    /// `cosine` of the angle between the eye and the normal.
    pub fn mirrored(self, cosine: f32) -> f32 {
        self.of(fresnel(cosine, 1.0))
    }

    /// As [`Self::mirrored`], of light from all around: what is rough has no grazing shine (Lagarde
    /// 2011).
    pub fn mirrored_sky(self, cosine: f32, roughness: f32) -> f32 {
        self.of(fresnel(cosine, (1.0 - roughness).max(HEAD_ON)))
    }

    fn of(self, share: f32) -> f32 {
        self.reflectivity + (1.0 - self.reflectivity) * self.polish * share
    }
}

impl<'a> Lighting<'a> {
    /// `maps` of `views`: the shadow views of the scene's lights.
    pub fn new(scene: &Scene, views: &[View], maps: &'a [ViewMaps]) -> Self {
        let of_views = views.iter().map(|view| view.to_gpu(0, UVec2::ZERO, 0)).collect();
        let records = LightRecords::new(scene.lights.iter().enumerate(), views, of_views);
        Self {
            levels: Levels::new(&records, maps),
            records,
            maps,
            ambient: scene.ambient,
            background: scene.background,
            bias: scene.shadow.bias,
            normal_bias: scene.shadow.normal_bias,
        }
    }

    pub fn lights(&self) -> &[GpuLight] {
        &self.records.lights
    }

    /// What is seen, and mirrored, where there is nothing: brighter above.
    pub fn sky(&self, direction: Vec3) -> Vec3 {
        self.background * (1.0 + 0.35 * direction.y)
    }

    fn ambient_at(&self, point: &Point) -> Vec3 {
        match point.kind {
            PointKind::Particle => self.ambient,
            PointKind::Solid | PointKind::Sheet => self.ambient * (0.85 + 0.15 * point.normal.y),
        }
    }

    /// The light that a point sends to the eye.
    pub fn light(&self, point: &Point) -> Vec3 {
        let bias = self.bias + point.reach;
        let (mut diffuse, mut shine) = (self.ambient_at(point), Vec3::ZERO);
        for light in self.lights() {
            let (toward, color) = incoming(light, point.position);
            let (cosine, side) = (point.normal.dot(toward), point.face.dot(toward));
            let is_solid = point.kind == PointKind::Solid;
            let is_behind = is_solid && cosine <= 0.0;
            if is_behind || !color.cmpgt(Vec3::ZERO).any() {
                continue;
            }
            // Off itself, on the light's side. A facet that looks away while its normal does not is
            // part of a round surface.
            let face = match (side > 0.0, is_solid) {
                (true, _) => point.face,
                (false, true) => point.normal,
                (false, false) => -point.face,
            };
            let receiver = point.receiver.of_kind(point.kind);
            let through = self.shadow(light, point.position, face, toward, bias, receiver);
            let passed = color * through;
            diffuse += passed * scattered(point.kind, cosine);
            if point.kind != PointKind::Particle && cosine > 0.0 {
                shine += passed * (cosine * highlight(point, toward));
            }
        }
        point.emission + point.albedo * diffuse + shine
    }

    /// The share of a light that reaches a point: 1 where nothing is between, without falloff and
    /// cosine.
    pub fn share(&self, light: &GpuLight, point: &ReceiverPoint) -> Vec3 {
        let (toward, _) = incoming(light, point.position);
        // Off itself, on the light's side.
        let face = if point.normal.dot(toward) > 0.0 { point.normal } else { -point.normal };
        self.shadow(light, point.position, face, toward, self.bias, Receiver::AIR)
    }

    /// Radiance that a point of the air sends back along `ray`, were it to scatter all it takes.
    pub fn scattered(&self, point: Vec3, ray: Vec3, anisotropy: f32) -> Vec3 {
        let mut sum = self.ambient;
        for light in self.lights().iter().filter(|light| light.traits & SHAFTS_BIT != 0) {
            let (toward, color) = incoming(light, point);
            if color.cmpgt(Vec3::ZERO).any() {
                let passed =
                    self.shadow(light, point, Vec3::ZERO, toward, self.bias, Receiver::AIR);
                sum += color * passed * phase(toward.dot(ray), anisotropy);
            }
        }
        sum
    }
}

/// The way to the light, and the irradiance of what faces it, before shadows.
fn incoming(light: &GpuLight, point: Vec3) -> (Vec3, Vec3) {
    if light.kind == LIGHT_DIRECTIONAL {
        return (-light.direction, light.color);
    }
    let away = point - light.position;
    let square = away.length_squared().max(1e-4);
    let ray = away / square.sqrt();
    let part = square * light.per_range2;
    let window = (1.0 - part * part).max(0.0);
    let mut color = light.color / square * (window * window);
    if light.kind == LIGHT_SPOT {
        let (outer, inner) = (light.cone_outer, light.cone_inner);
        let t = ((ray.dot(light.direction) - outer) / (inner - outer)).clamp(0.0, 1.0);
        color *= t * t * (3.0 - 2.0 * t);
    }
    (-ray, color)
}

/// Share of the light that a point of albedo 1 sends to the eye.
fn scattered(kind: PointKind, cosine: f32) -> f32 {
    match kind {
        PointKind::Solid => cosine.max(0.0) * FRAC_1_PI,
        PointKind::Sheet => cosine.abs() * FRAC_1_PI,
        // Alike in all directions; smoke is thick enough to scatter more than once, so that it is
        // half as bright as paper that faces the light.
        PointKind::Particle => 0.5 * FRAC_1_PI,
    }
}

/// What glass mirrors that is looked at straight.
const HEAD_ON: f32 = 0.04;

/// Schlick 1994, of glass and most that is no metal; `grazing`: what is mirrored at 90 degrees.
fn fresnel(cosine: f32, grazing: f32) -> f32 {
    HEAD_ON + (grazing - HEAD_ON) * (1.0 - cosine).clamp(0.0, 1.0).powi(5)
}

/// Blinn 1977, normalised; the exponent from the roughness as Walter et al. 2007, section 6.
fn highlight(point: &Point, toward: Vec3) -> f32 {
    let Point { normal, to_eye, roughness, gloss, .. } = *point;
    let middle = (toward + to_eye).normalize();
    let width = (roughness * roughness).max(0.04);
    let exponent = 2.0 / (width * width) - 1.0;
    let lobe = normal.dot(middle).max(1e-6).powf(exponent);
    (exponent + 8.0) * (FRAC_1_PI / 8.0) * lobe * gloss.mirrored(to_eye.dot(middle))
}

/// World space, of a point of the camera's map at light depth `depth`.
pub fn world_point(view: &GpuView, world_from_view: &Mat4, pixel: Vec2, depth: f32) -> Vec3 {
    let slope = (pixel - view.size * 0.5) / view.scale;
    let distance = view.near + depth * (view.far - view.near);
    let point = Vec3::new(slope.x, -slope.y, -1.0) * distance;
    (*world_from_view * point.extend(1.0)).xyz()
}
