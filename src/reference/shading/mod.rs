//! Twin of `wgsl/records/light.wgsl`, `shading.wgsl`, `surface.wgsl` and `sheet.wgsl`: the light that
//! reaches a point, and what of it the camera sees.
mod receive;
mod tone;

pub use tone::to_screen;

use super::air::phase;
use crate::{
    model::Scene,
    model::{Material, Receives, View},
    records::{GpuView, ViewMaps, owner_tag},
    stage::shade::GpuLight,
};
use glam::{Mat4, UVec2, Vec2, Vec3, Vec4Swizzles as _};
use std::f32::consts::FRAC_1_PI;

/// Numbers of [`GpuLight::kind`].
const DIRECTIONAL: u32 = 0;
const SPOT: u32 = 1;
/// What lights the picture.
#[derive(Clone, Debug)]
pub struct Lighting<'a> {
    pub lights: Vec<GpuLight>,
    views: Vec<GpuView>,
    maps: &'a [ViewMaps],
    pub ambient: Vec3,
    background: Vec3,
    /// [m]
    bias: f32,
    /// [texels]
    normal_bias: f32,
}

/// A point of what the camera sees.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    pub point: Vec3,
    /// Interpolated, on the eye's side.
    pub normal: Vec3,
    /// Of the plane, on the eye's side.
    pub face: Vec3,
    pub to_eye: Vec3,
    pub albedo: Vec3,
    pub roughness: f32,
    /// How far what is in the map may lie off the point [m].
    pub reach: f32,
    pub receiver: Receiver,
}

/// Who receives light.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    receives: Receives,
    /// Of its object.
    tag: u16,
}

impl Receiver {
    /// Tinted by all that is before it.
    pub const AIR: Self = Self { receives: Receives::Curve, tag: 0 };

    pub fn new(material: &Material, id: u32) -> Self {
        Self { receives: material.receives, tag: owner_tag(id) }
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
    const SOLID: Self = Self { reflectivity: 0.0, polish: 1.0 };

    /// `cosine` of the angle between the eye and the normal.
    pub fn mirrored(self, cosine: f32) -> f32 {
        self.reflectivity + (1.0 - self.reflectivity) * self.polish * fresnel(cosine)
    }
}

/// What a pane scatters and what it mirrors of the lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lit {
    pub diffuse: Vec3,
    pub shine: Vec3,
}

impl<'a> Lighting<'a> {
    /// `maps` of `views`: the shadow views of the scene's lights.
    pub fn new(scene: &Scene, views: &[View], maps: &'a [ViewMaps]) -> Self {
        let lights = scene.lights.iter().enumerate();
        Self {
            lights: lights.map(|(index, light)| GpuLight::new(light, index, views)).collect(),
            views: views.iter().map(|view| view.to_gpu(0, UVec2::ZERO, 0)).collect(),
            maps,
            ambient: scene.ambient,
            background: scene.background,
            bias: scene.shadow.bias,
            normal_bias: scene.shadow.normal_bias,
        }
    }

    /// What is seen, and mirrored, where there is nothing: brighter above.
    pub fn sky(&self, direction: Vec3) -> Vec3 {
        self.background * (1.0 + 0.35 * direction.y)
    }

    fn ambient_light(&self, normal: Vec3) -> Vec3 {
        self.ambient * (0.85 + 0.15 * normal.y)
    }

    pub fn shade_solid(&self, surface: &Surface) -> Vec3 {
        let mut sum = surface.albedo * self.ambient_light(surface.normal);
        for light in &self.lights {
            let (toward, color) = incoming(light, surface.point);
            let cosine = surface.normal.dot(toward);
            if cosine > 0.0 && surface.face.dot(toward) > 0.0 && color.cmpgt(Vec3::ZERO).any() {
                let bias = self.bias + surface.reach;
                let passed =
                    self.shadow(light, surface.point, surface.face, toward, bias, surface.receiver);
                let shine = highlight(surface, toward, Gloss::SOLID);
                sum += color * passed * (cosine * (surface.albedo * FRAC_1_PI + shine));
            }
        }
        sum
    }

    /// A thin sheet, lit from both sides.
    pub fn light_sheet(&self, surface: &Surface, gloss: Gloss) -> Lit {
        let mut lit = Lit { diffuse: self.ambient_light(surface.normal), shine: Vec3::ZERO };
        for light in &self.lights {
            let (toward, color) = incoming(light, surface.point);
            let cosine = surface.normal.dot(toward);
            let side = if surface.face.dot(toward) > 0.0 { surface.face } else { -surface.face };
            let passed = color
                * self.shadow(light, surface.point, side, toward, self.bias, surface.receiver);
            lit.diffuse += passed * (cosine.abs() * FRAC_1_PI);
            if cosine > 0.0 {
                let shine = highlight(surface, toward, gloss);
                lit.shine += passed * (cosine * shine);
            }
        }
        lit
    }

    /// Radiance that a point of the air sends back along `ray`, were it to scatter all it takes.
    pub fn scattered(&self, point: Vec3, ray: Vec3, anisotropy: f32) -> Vec3 {
        let mut sum = self.ambient;
        for light in self.lights.iter().filter(|light| light.shafts != 0) {
            let (toward, color) = incoming(light, point);
            if color.cmpgt(Vec3::ZERO).any() {
                let passed =
                    self.shadow(light, point, Vec3::ZERO, toward, self.bias, Receiver::AIR);
                sum += color * passed * phase(toward.dot(ray), anisotropy);
            }
        }
        sum
    }

    /// A particle of colour 1, by the light at its middle.
    pub fn light_particle(&self, point: Vec3, radius: f32, receiver: Receiver) -> Vec3 {
        let mut sum = self.ambient;
        for light in &self.lights {
            let (toward, color) = incoming(light, point);
            let passed =
                self.shadow(light, point, Vec3::ZERO, toward, self.bias + radius, receiver);
            sum += color * passed * (0.5 * FRAC_1_PI);
        }
        sum
    }
}

/// The way to the light, and the irradiance of what faces it, before shadows.
fn incoming(light: &GpuLight, point: Vec3) -> (Vec3, Vec3) {
    if light.kind == DIRECTIONAL {
        return (-light.direction, light.color);
    }
    let away = point - light.position;
    let square = away.length_squared().max(1e-4);
    let ray = away / square.sqrt();
    let part = square * light.per_range2;
    let window = (1.0 - part * part).max(0.0);
    let mut color = light.color / square * (window * window);
    if light.kind == SPOT {
        let (outer, inner) = (light.cone_outer, light.cone_inner);
        let t = ((ray.dot(light.direction) - outer) / (inner - outer)).clamp(0.0, 1.0);
        color *= t * t * (3.0 - 2.0 * t);
    }
    (-ray, color)
}

/// Schlick 1994, of glass and most that is no metal.
fn fresnel(cosine: f32) -> f32 {
    0.04 + 0.96 * (1.0 - cosine).clamp(0.0, 1.0).powi(5)
}

/// Blinn 1977, normalised; the exponent from the roughness as Walter et al. 2007, section 6.
fn highlight(surface: &Surface, toward: Vec3, gloss: Gloss) -> f32 {
    let Surface { normal, to_eye, roughness, .. } = *surface;
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
