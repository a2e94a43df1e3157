//! What filters light: materials, particles and triangles.
use crate::model::Pattern;
use glam::{Vec2, Vec3, Vec4};

/// How one hit of opacity `a` and colour `c` changes the light that passes, per channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "scene", derive(serde::Deserialize))]
#[cfg_attr(feature = "scene", serde(rename_all = "lowercase"))]
pub enum Transfer {
    /// `T = 1 - a(1 - c)`: a gel of coverage `a` (Recoil).
    #[default]
    Filter,
    /// `T = c(1 - a)` (Wicked Engine's meshes, Eagle).
    Stain,
    /// `T = (1 - a)(1 - a(1 - c))` (Wicked Engine's particles).
    Smoke,
    /// `L' = L(1 - a) + c a`, front to back from white: depends on order (`StarCraft` II).
    Over,
    /// `T = c`, up to 16: the caustics of water.
    Gain,
    /// `T = 1`: additive fire must not darken.
    None,
    /// Goes to the opaque depth, always.
    Opaque,
    /// Goes to the opaque depth where `a >= cutoff`.
    Cutout,
    /// Goes to the opaque depth where `a` exceeds the texel's dither threshold.
    Dither,
}

impl Transfer {
    /// Whether hits go to the opaque depth map instead of the filter.
    pub fn is_opaque(self) -> bool {
        matches!(self, Self::Opaque | Self::Cutout | Self::Dither)
    }

    /// The largest colour that is valid: light may be gathered by `gain` only.
    pub fn max_color(self) -> f32 {
        if self == Self::Gain { MAX_GAIN } else { 1.0 }
    }
}

/// The brightest that a `gain` caster makes the light.
pub const MAX_GAIN: f32 = 16.0;

/// The shape of a material's particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "scene", derive(serde::Deserialize))]
#[cfg_attr(feature = "scene", serde(rename_all = "lowercase"))]
pub enum Shape {
    /// A disc that faces the light.
    #[default]
    Disc,
    /// A rotated, textured square that faces the light.
    Quad,
    /// A sphere that absorbs along the chord of the ray.
    Puff,
}

/// How a disc's opacity falls off at distance `q` from the centre of a disc of radius `r`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "scene", derive(serde::Deserialize))]
#[cfg_attr(feature = "scene", serde(rename_all = "lowercase"))]
pub enum Profile {
    /// `1`
    Flat,
    /// `(1 - (q/r)^2)^2`
    #[default]
    Soft,
}

/// Which translucent casters tint what is made of a material. Opaque ones always shade it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "scene", derive(serde::Deserialize))]
#[cfg_attr(feature = "scene", serde(rename_all = "lowercase"))]
pub enum Receives {
    /// Those in front of it, as the receiver mode of the shadow settings knows them.
    #[default]
    Curve,
    /// All of a texel, where the nearest of them is in front of it.
    Nearest,
    /// None.
    Opaque,
    /// As `Nearest`, but not where the nearest one is part of the same object.
    Others,
}

/// What the casters of one kind share.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// For people.
    pub name: String,
    /// What a hit does to the light.
    pub transfer: Transfer,
    /// Shape of its particles.
    pub shape: Shape,
    /// Profile of its discs.
    pub profile: Profile,
    /// Linear rgba. For an opaque material the rgb is the albedo.
    pub tint: Vec4,
    /// Index into [`crate::model::Scene::textures`].
    pub texture: Option<u32>,
    /// `r` in `a = 1 - (1 - alpha)(1 - r)`, 0..=1.
    pub reflectivity: f32,
    /// Opacity from which a `cutout` is solid.
    pub cutoff: f32,
    /// Pattern of the thresholds of `dither`.
    pub pattern: Pattern,
    /// Edge of a cell of the pattern, 1..=64 [texels].
    pub pattern_scale: u32,
    /// What shines by itself (additive fire) in the picture: linear rgb.
    pub emission: Vec3,
    /// Index into [`crate::model::Scene::textures`]: its rgb multiplies the emission of triangles.
    pub emissive_texture: Option<u32>,
    /// 0: a surface that scatters light where it covers. 1: clear glass, which only filters.
    pub transmission: f32,
    /// 0..=1, of the highlight in the picture.
    pub roughness: f32,
    /// 0..=1, of what is solid: 1 mirrors in its own colour and scatters nothing.
    pub metallic: f32,
    /// What is left of light after [`Self::attenuation_distance`] in a closed mesh.
    pub attenuation_color: Vec3,
    /// [m]; infinite for what is no volume. Triangles of a volume are counterclockwise from outside.
    pub attenuation_distance: f32,
    /// Which casters tint it.
    pub receives: Receives,
    /// Whether the picture shows it; without it, a shadow without its caster.
    pub visible: bool,
    /// Whether it blocks or filters light; without it, a caster without its shadow.
    pub casts: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            transfer: Transfer::Filter,
            shape: Shape::Disc,
            profile: Profile::Soft,
            tint: Vec4::ONE,
            texture: None,
            reflectivity: 0.0,
            cutoff: 0.5,
            pattern: Pattern::default(),
            pattern_scale: 1,
            emission: Vec3::ZERO,
            emissive_texture: None,
            transmission: 0.0,
            roughness: 0.6,
            metallic: 0.0,
            attenuation_color: Vec3::ONE,
            attenuation_distance: f32::INFINITY,
            receives: Receives::default(),
            visible: true,
            casts: true,
        }
    }
}

impl Material {
    /// Whether its particles are soft discs of the `filter` transfer and nothing else.
    pub fn is_plain_disc(&self) -> bool {
        self.shape == Shape::Disc
            && self.profile == Profile::Soft
            && self.transfer == Transfer::Filter
            && self.reflectivity == 0.0
            && self.texture.is_none()
    }

    /// Whether closed meshes of it absorb along the way through them.
    pub fn is_volume(&self) -> bool {
        self.absorption() != Vec3::ZERO
    }

    /// Optical depth of the way through its volumes [1/m].
    pub fn absorption(&self) -> Vec3 {
        /// 20 halvings; powers of 0 differ between adapters.
        const LEAST: f32 = 1e-6;
        if !self.attenuation_distance.is_finite() {
            return Vec3::ZERO;
        }
        -self.attenuation_color.clamp(Vec3::splat(LEAST), Vec3::ONE).map(f32::ln)
            / self.attenuation_distance
    }
}

/// A caster that faces the light: disc, quad or puff, by its material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// World space [m].
    pub center: Vec3,
    /// Radius of the disc or puff; half the side of the quad [m].
    pub radius: f32,
    /// Linear rgba; multiplies the material's tint.
    pub color: Vec4,
    /// Rotation of a quad about the ray from the light [radians].
    pub rotation: f32,
    /// Index into [`crate::model::Scene::materials`].
    pub material: u32,
    /// Decorrelates dither patterns; unique where the file gives it.
    pub id: u32,
}

impl Default for Particle {
    /// White, of a decimetre, at the origin.
    fn default() -> Self {
        Self {
            center: Vec3::ZERO,
            radius: 0.1,
            color: Vec4::ONE,
            rotation: 0.0,
            material: 0,
            id: 0,
        }
    }
}

impl Particle {
    /// White and opaque; centre in world space [m], radius [m].
    pub fn new(center: impl Into<[f32; 3]>, radius: f32) -> Self {
        Self { center: center.into().into(), radius, ..Self::default() }
    }

    /// With a linear rgba, which multiplies the material's tint.
    #[must_use]
    pub fn with_color(self, color: impl Into<[f32; 4]>) -> Self {
        Self { color: color.into().into(), ..self }
    }
}

/// A triangle of a mesh, two-sided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// World space [m].
    pub positions: [Vec3; 3],
    /// World space, unit.
    pub normals: [Vec3; 3],
    /// Row 0 of the texture at v = 0.
    pub uvs: [Vec2; 3],
    /// Index into [`crate::model::Scene::materials`].
    pub material: u32,
    /// Decorrelates dither patterns: one per object.
    pub id: u32,
}

impl Triangle {
    /// A flat one, of a material; corners in world space [m], counter-clockwise from its front.
    pub fn flat(corners: [impl Into<[f32; 3]>; 3], material: u32) -> Self {
        let positions = corners.map(|corner| Vec3::from(corner.into()));
        let [a, b, c] = positions;
        let normals = [(b - a).cross(c - a).normalize_or(Vec3::Y); 3];
        Self { positions, normals, uvs: [Vec2::ZERO; 3], material, id: 0 }
    }
}

/// An image that materials sample, bilinear and repeating.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    /// For people.
    pub name: String,
    /// [texels]
    pub width: u32,
    /// [texels]
    pub height: u32,
    /// `width * height` rgba bytes, rows from the top; rgb is sRGB, alpha is linear.
    pub rgba: Vec<u8>,
}

/// What casts, in world space. Positions have 24 bits: a host with a large world gives them, and the
/// views, relative to a place near the camera (10 km away a millimetre is lost). Particles and triangles name their material by its index, and
/// materials their texture.
#[derive(Clone, Copy, Debug, Default)]
pub struct Casters<'a> {
    /// Discs, quads and puffs.
    pub particles: &'a [Particle],
    /// Triangles of meshes.
    pub triangles: &'a [Triangle],
    /// At most 512.
    pub materials: &'a [Material],
    /// What materials sample.
    pub textures: &'a [Texture],
    /// Particles stay in the order that they are given in, which counts where several are at the same
    /// depth. Otherwise neighbours are put together, so that views need not look at all of them: a host
    /// whose particles lie together already saves that.
    pub in_order: bool,
}
