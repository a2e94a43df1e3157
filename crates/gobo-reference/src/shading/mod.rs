//! CPU reference of `wgsl/records/light.wgsl`, `shading.wgsl`, `surface.wgsl` and `pane.wgsl`: light at a
//! point, and its reflection to the camera.
mod coat;
pub(crate) mod incoming;
pub mod receive;
mod reflectance;
pub mod seen_plane;
pub mod taps;
mod thrown;
mod tone;

pub use coat::Coat;
pub use incoming::incoming;
pub use reflectance::{DARKEST, HEAD_ON, ORDERS, SHEEN};
use reflectance::{
    highlight, mirrored_solid, phase_of_orders, rising, scattered, strand_scattered,
};
pub use tone::{FILM_WHITE, shown, to_screen, to_srgb};

use super::{
    air::phase,
    area::LightPoints,
    bounce::{Bounce, bounced, bounces},
    mask::Masks,
};
use glam::{Mat4, UVec2, Vec2, Vec3, Vec4Swizzles as _};
use gobo::{
    model::{
        Environment, IRRADIANCE, LEVELS, Light, Material, ROUGH_SIZE, ReceiverPoint, Receives,
        Scene, View, irradiance_at, octahedral,
    },
    records::{GpuLight, GpuView, LIGHT_DIRECTIONAL, LightRecords, ViewMaps, owner_tag},
};
use std::f32::consts::FRAC_1_PI;

/// Lights, shadow maps and environment of a picture.
#[derive(Clone, Debug)]
pub struct Lighting<'a> {
    lights: Vec<GpuLight>,
    /// The point of each light from which its maps are rendered.
    points: Vec<GpuLight>,
    views: Vec<GpuView>,
    maps: Vec<&'a ViewMaps>,
    /// Points that send light on.
    bounces: Vec<Bounce>,
    /// Mean ambient radiance over all directions.
    ambient: Vec3,
    irradiance: [Vec3; IRRADIANCE],
    background: Vec3,
    environment: Option<&'a Environment>,
}

/// A receiver as data: visible surfaces make points, and [`Lighting::light`] evaluates the light that they
/// send to the eye.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Which rules of a receiver hold for it.
    pub kind: PointKind,
    /// Position, world space \[m\].
    pub position: Vec3,
    /// Pixel of the picture; (0, 0) for a particle's centre.
    pub pixel: UVec2,
    /// Normal of the plane, unit, on the eye's side; zero without one.
    pub face: Vec3,
    /// Interpolated normal, unit, on the eye's side; zero without one.
    pub normal: Vec3,
    /// Direction to the eye, unit.
    pub to_eye: Vec3,
    /// Largest distance of the point's own caster in the map, added to the bias \[m\].
    pub reach: f32,
    /// Which casters tint it.
    pub receiver: Receiver,
    /// Scattered share of the light.
    pub albedo: Vec3,
    /// Roughness of its highlights, 0 to 1.
    pub roughness: f32,
    /// Share of the light that it mirrors.
    pub gloss: Gloss,
    /// Emitted light, and light mirrored from the environment.
    pub emission: Vec3,
    /// 1: mirrors in its own colour and scatters nothing.
    pub metallic: f32,
    /// Scattered share of the light from the far side of a leaf.
    pub far: Vec3,
    /// Clear coat of an opaque surface.
    pub coat: Coat,
}

/// Scattering of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointKind {
    /// Scatters light from its face's side.
    Solid,
    /// A thin pane that scatters light from both sides.
    Pane,
    /// A thin layer that covers its background, and scatters light from its face's side.
    Cover,
    /// Scatters light from its face's side, and other light from its far side.
    Leaf,
    /// Scatters without a normal.
    Particle,
    /// Around an axis in place of the normal: scatters as a cylinder, and mirrors.
    Strand,
    /// In a brick of voxels, with multiple scattering.
    Brick {
        /// `g` of its phase function.
        anisotropy: f32,
    },
}

/// Properties of a receiver that decide which casters tint it.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    receives: Receives,
    /// Owner tag of its object.
    tag: u16,
    /// Whether it is opaque: it is then in no filter map, so no translucent caster is its own.
    solid: bool,
    /// Whether it is in the filter map itself.
    leaf: bool,
    /// Direction to the first texel of a disc, unit.
    turn: Vec2,
}

impl Receiver {
    /// A receiver tinted by all casters in front of it.
    pub const AIR: Self =
        Self { receives: Receives::Curve, tag: 0, solid: false, leaf: false, turn: Vec2::X };

    /// The receiver of a material; `id`: of its object.
    pub fn new(material: &Material, id: u32) -> Self {
        Self { receives: material.receives, tag: owner_tag(id), ..Self::AIR }
    }

    /// The receiver at a pixel of the picture.
    #[must_use]
    pub fn at_pixel(self, pixel: UVec2) -> Self {
        Self { turn: taps::turn(pixel), ..self }
    }

    /// The receiver as a point of a kind.
    #[must_use]
    pub fn of_kind(self, kind: PointKind) -> Self {
        Self { solid: kind == PointKind::Solid, leaf: kind == PointKind::Leaf, ..self }
    }
}

/// Mirrored share of light: the reflectivity, and a glass coating of the rest by polish.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gloss {
    /// Share that is mirrored in full, 0 to 1.
    pub reflectivity: f32,
    /// 1 for glass, 0 for a surface of no coverage.
    pub polish: f32,
}

impl Gloss {
    /// An opaque surface.
    pub const SOLID: Self = Self { reflectivity: 0.0, polish: 1.0 };

    /// `cosine` of the angle between the eye and the normal; `head_on`: reflectance at 0 degrees.
    pub fn mirrored(self, cosine: f32, head_on: Vec3) -> Vec3 {
        self.of(head_on + (Vec3::ONE - head_on) * rising(cosine))
    }

    /// Like [`Self::mirrored`], for light from the environment: rough surfaces have no grazing reflection
    /// (Lagarde 2011).
    pub fn mirrored_sky(self, cosine: f32, roughness: f32) -> f32 {
        let grazing = (1.0 - roughness).max(HEAD_ON);
        self.of(Vec3::splat(HEAD_ON + (grazing - HEAD_ON) * rising(cosine))).x
    }

    fn of(self, share: Vec3) -> Vec3 {
        self.reflectivity + (1.0 - self.reflectivity) * self.polish * share
    }
}

/// Share of the distance to a lamp at which the look-up from a body stops: a lamp has no direction to itself.
pub const SHORT_OF: f32 = 0.999;
/// Distance of a directional light \[m\].
pub const SUN_DISTANCE: f32 = 3.4e38;

impl<'a> Lighting<'a> {
    /// `maps` of `views`: the shadow views of the scene's lights.
    pub fn new(scene: &'a Scene, views: &'a [View], maps: &'a [ViewMaps]) -> Self {
        Self::of_points(scene, &LightPoints::centers(scene, views, maps))
    }

    /// Lights of a scene, with the shadows of one point of each.
    pub(super) fn of_points(scene: &'a Scene, points: &LightPoints<'a>) -> Self {
        let to_gpu = || points.views.iter().map(|view| view.to_gpu(0, UVec2::ZERO, 0)).collect();
        let records = |lights: &[Light]| {
            LightRecords::new(lights.iter().enumerate(), &points.views, to_gpu(), &scene.shadow)
        };
        Self {
            lights: records(&scene.lights).lights,
            points: records(&points.lights).lights,
            views: to_gpu(),
            maps: points.maps.clone(),
            bounces: bounces(scene, &points.lights, &points.views, &points.maps),
            ambient: scene.mean_ambient(),
            irradiance: scene.irradiance(),
            background: scene.background,
            environment: scene.environment.as_deref(),
        }
    }

    /// Whether maps are curves.
    pub fn has_curves(&self) -> bool {
        self.maps.iter().any(|map| map.curve.is_some())
    }

    /// Records of the lights.
    pub fn lights(&self) -> &[GpuLight] {
        &self.lights
    }

    /// Radiance of the background or environment from a unit direction, prefiltered for a roughness.
    pub fn radiance_around(&self, direction: Vec3, roughness: f32) -> Vec3 {
        let Some(environment) = self.environment else {
            return self.background;
        };
        let point = octahedral(direction) * 0.5 + 0.5;
        let level = roughness.clamp(0.0, 1.0) * (LEVELS - 1) as f32;
        let low = level as u32;
        let sharp = level_around(environment, low, point);
        if level == low as f32 {
            return sharp;
        }
        sharp.lerp(level_around(environment, low + 1, point), level - low as f32)
    }

    /// Reflection of the environment by an opaque surface, by its material and its own colour. If the
    /// surroundings are two colours, only metal mirrors them.
    pub fn mirrored_around(
        &self,
        (roughness, metallic): (f32, f32),
        albedo: Vec3,
        normal: Vec3,
        to_eye: Vec3,
    ) -> Vec3 {
        let shown = if self.environment.is_some() { 1.0 } else { metallic };
        let share = mirrored_solid(albedo, metallic, normal.dot(to_eye), roughness);
        share * shown * self.radiance_around((-to_eye).reflect(normal), roughness)
    }

    fn ambient_at(&self, point: &Point) -> Vec3 {
        match point.kind {
            PointKind::Particle | PointKind::Strand | PointKind::Brick { .. } => self.ambient,
            PointKind::Solid | PointKind::Pane | PointKind::Cover | PointKind::Leaf => {
                irradiance_at(&self.irradiance, point.normal)
            }
        }
    }

    /// Ambient light that a point scatters to the eye; an opaque surface scatters what it does not mirror. If
    /// the surroundings are two colours, only metal mirrors them, and the rest is scattered.
    pub fn ambient_of(&self, point: &Point) -> Vec3 {
        let is_solid = matches!(point.kind, PointKind::Solid | PointKind::Leaf);
        let mirrors = is_solid && self.environment.is_some();
        let mirror = point.gloss.mirrored_sky(point.normal.dot(point.to_eye), point.roughness);
        let kept = if mirrors { 1.0 - mirror } else { 1.0 };
        let past = 1.0 - point.coat.mirrored(point.to_eye);
        past * point.albedo * (1.0 - point.metallic) * kept * self.ambient_at(point)
    }

    /// Ambient light that a leaf scatters from its far side.
    pub fn ambient_behind(&self, point: &Point) -> Vec3 {
        point.far * irradiance_at(&self.irradiance, -point.normal)
    }

    /// Light that a point sends to the eye. `masks`: those of its picture.
    pub fn light(&self, point: &Point, masks: Option<&Masks>) -> Vec3 {
        self.light_through(point, |index, _, face| {
            let receiver = point.receiver.of_kind(point.kind);
            let masked = masks.and_then(|masks| masks.share(index, point));
            masked
                .unwrap_or_else(|| self.shadow(index, point.position, face, point.reach, receiver))
        })
    }

    /// Light that a point in a body sends to the eye. `own`: given the direction to a light and its distance
    /// \[m\], the point at which the path leaves the body and the transmittance up to there; from that point
    /// on the maps shadow it without a bias.
    pub fn light_in_body(&self, point: &Point, own: impl Fn(Vec3, f32) -> (Vec3, Vec3)) -> Vec3 {
        self.light_through(point, |index, toward, face| {
            let light = &self.lights()[index];
            let away = light.position.distance(point.position);
            let end = if light.kind == LIGHT_DIRECTIONAL { SUN_DISTANCE } else { SHORT_OF * away };
            let (outside, passed) =
                if light.view_count == 0 { (Vec3::ZERO, Vec3::ONE) } else { own(toward, end) };
            passed * self.shadow(index, outside, face, -1.0, point.receiver)
        })
    }

    /// `through`: share of light number `index` that comes from a direction, with the normal on its side.
    fn light_through(&self, point: &Point, through: impl Fn(usize, Vec3, Vec3) -> Vec3) -> Vec3 {
        // A highlight never sends more light than it does head-on.
        let once = |cosine: f32| match point.kind {
            PointKind::Solid | PointKind::Leaf => {
                scattered(point.kind, cosine) * (1.0 - HEAD_ON * point.gloss.polish)
            }
            kind => scattered(kind, cosine),
        };
        let mut diffuse = bounced(&self.bounces, point.position, point.normal, once);
        let mut shine = Vec3::ZERO;
        // Shares of the light that a coat mirrors, and that passes it.
        let coat = point.coat.mirrored(point.to_eye);
        let past = 1.0 - coat;
        for (index, light) in self.lights().iter().enumerate() {
            let (toward, color) = incoming(light, point.position);
            let (cosine, side) = (point.normal.dot(toward), point.face.dot(toward));
            let is_solid = point.kind == PointKind::Solid;
            let is_behind = is_solid && cosine <= 0.0;
            if is_behind || !color.cmpgt(Vec3::ZERO).any() {
                continue;
            }
            // Normal on the light's side. A facet that points away although its interpolated normal does not
            // is part of a round surface.
            let face = match (side > 0.0, is_solid) {
                (true, _) => point.face,
                (false, true) => point.normal,
                (false, false) => -point.face,
            };
            let through = through(index, toward, face);
            let passed = color * through;
            diffuse += match point.kind {
                PointKind::Brick { anisotropy } => {
                    let ahead = toward.dot(-point.to_eye);
                    color * phase_of_orders(through, ahead, anisotropy, point.albedo)
                }
                PointKind::Strand => passed * strand_scattered(point, toward),
                _ => passed * once(cosine),
            };
            let has_face = matches!(
                point.kind,
                PointKind::Solid | PointKind::Pane | PointKind::Cover | PointKind::Leaf
            );
            shine += point.far * passed * ((-cosine).max(0.0) * FRAC_1_PI);
            if has_face && cosine > 0.0 {
                shine += passed * (cosine * past * highlight(point, toward));
            }
            shine += passed * (coat * point.coat.shine(toward, point.to_eye));
        }
        let scattered = past * point.albedo * (1.0 - point.metallic) * diffuse;
        point.emission + self.ambient_of(point) + scattered + shine
    }

    /// A surface that shows the surroundings behind it, times the share of its light that reaches it: its
    /// albedo is the surroundings over the whole light.
    pub fn caught(&self, point: &Point) -> Point {
        let of_light = |light: &GpuLight| {
            let (toward, color) = incoming(light, point.position);
            color * scattered(PointKind::Solid, point.normal.dot(toward))
        };
        let whole = self.ambient_at(point) + self.lights().iter().map(of_light).sum::<Vec3>();
        let behind = self.radiance_around(-point.to_eye, 0.0);
        let is_lit = whole.cmpgt(Vec3::ZERO);
        Point {
            albedo: Vec3::select(is_lit, behind / whole, Vec3::ZERO),
            emission: Vec3::select(is_lit, Vec3::ZERO, behind),
            gloss: Gloss { reflectivity: 0.0, polish: 0.0 },
            metallic: 0.0,
            coat: Coat::NONE,
            ..*point
        }
    }

    /// Share of a light that reaches a point: 1 if nothing is in between, without falloff and cosine; 0
    /// behind a given far plane (rule 1, with nothing in the map).
    pub fn share(&self, index: usize, point: &ReceiverPoint) -> Vec3 {
        let (toward, _) = incoming(&self.lights[index], point.position);
        // Normal on the light's side.
        let face = if point.normal.dot(toward) > 0.0 { point.normal } else { -point.normal };
        self.shadow(index, point.position, face, 0.0, Receiver::AIR)
    }

    /// Share of a light for the mask of an opaque surface: 1 where the light does not shine.
    pub fn mask_share(&self, index: usize, point: &Point) -> Vec3 {
        let (toward, color) = incoming(&self.lights[index], point.position);
        if !(point.normal.dot(toward) > 0.0 && color.cmpgt(Vec3::ZERO).any()) {
            return Vec3::ONE;
        }
        let face = if point.face.dot(toward) > 0.0 { point.face } else { point.normal };
        let receiver = point.receiver.of_kind(point.kind);
        self.shadow(index, point.position, face, point.reach, receiver)
    }

    /// Radiance of a light that a point of the air scatters back along `ray`, per unit of scattering optical
    /// depth.
    pub fn scattered(&self, index: usize, point: Vec3, ray: Vec3, anisotropy: f32) -> Vec3 {
        let (toward, color) = incoming(&self.lights[index], point);
        if !color.cmpgt(Vec3::ZERO).any() {
            return Vec3::ZERO;
        }
        let passed = self.shadow(index, point, Vec3::ZERO, 0.0, Receiver::AIR);
        color * passed * phase(toward.dot(ray), anisotropy)
    }
}

/// Bilinear sample of an environment's level at a point of the octahedral square, 0..1.
fn level_around(environment: &Environment, level: u32, point: Vec2) -> Vec3 {
    let fine = environment.size();
    let size = if level == 0 { fine } else { ROUGH_SIZE };
    let row = size + 2;
    let first = match level.checked_sub(1) {
        Some(rough) => (fine + 2) * (fine + 2) + rough * (ROUGH_SIZE + 2) * (ROUGH_SIZE + 2),
        None => 0,
    };
    // The centre of the border's texel is half a texel outside the square.
    let at = point * size as f32 + 0.5;
    let low = at.as_uvec2();
    let part = at - low.as_vec2();
    let corner = (first + low.y * row + low.x) as usize;
    let (texels, row) = (environment.texels(), row as usize);
    let top = texels[corner].lerp(texels[corner + 1], part.x);
    let bottom = texels[corner + row].lerp(texels[corner + row + 1], part.x);
    top.lerp(bottom, part.y)
}

/// World-space position of a point of the camera's map at light depth `depth`.
pub fn world_point(view: &GpuView, world_from_view: &Mat4, pixel: Vec2, depth: f32) -> Vec3 {
    let slope = (pixel - view.size * 0.5) / view.scale;
    let distance = view.near + depth * (view.far - view.near);
    let point = Vec3::new(slope.x, -slope.y, -1.0) * distance;
    (*world_from_view * point.extend(1.0)).xyz()
}
