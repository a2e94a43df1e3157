//! Casters: materials, particles and triangles.
use crate::model::{
    FARTHEST, Fresnel, Gaussian, GaussianOpacity, Grid, Pattern, Strand, VertexColor,
};
use glam::{Vec2, Vec3, Vec4};

/// Transfer function: how one hit of opacity `a` and colour `c` changes the light that passes, per channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
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
    /// Writes the opaque depth, always.
    Opaque,
    /// Writes the opaque depth where `a >= cutoff`.
    Cutout,
    /// Writes the opaque depth where `a` exceeds the texel's dither threshold.
    Dither,
}

impl Transfer {
    /// Whether hits write the opaque depth map instead of the filter map.
    pub fn is_opaque(self) -> bool {
        matches!(self, Self::Opaque | Self::Cutout | Self::Dither)
    }

    /// Whether the colour of clear texels counts; elsewhere, means of an image are weighted by alpha.
    pub fn shows_clear(self) -> bool {
        matches!(self, Self::Stain | Self::Gain | Self::Opaque)
    }

    /// Largest valid colour: only `gain` may amplify light.
    pub fn max_color(self) -> f32 {
        if self == Self::Gain { MAX_GAIN } else { 1.0 }
    }
}

/// Largest colour of a `gain` caster.
pub const MAX_GAIN: f32 = 16.0;

/// The shape of a material's particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Shape {
    /// A disc that faces the light.
    #[default]
    Disc,
    /// A rotated, textured square that faces the light.
    Quad,
    /// A sphere that absorbs along the chord of the ray.
    Puff,
    /// An anisotropic [`Gaussian`]. Not for particles, which have one radius.
    #[cfg_attr(feature = "serde", serde(skip))]
    Gaussian,
    /// A box of a [`Grid`], which absorbs by its density. Not for particles.
    #[cfg_attr(feature = "serde", serde(skip))]
    Brick,
    /// A segment of a [`Strand`]: part of a cone. Not for particles.
    #[cfg_attr(feature = "serde", serde(skip))]
    Capsule,
}

/// Falloff of a disc's opacity at distance `q` from its centre, for radius `r`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Profile {
    /// `1`
    Flat,
    /// `(1 - (q/r)^2)^2`
    #[default]
    Soft,
}

/// Which translucent casters tint a receiver of this material. Opaque ones always shade it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Receives {
    /// The casters in front of it, by the receiver mode of the shadow settings.
    #[default]
    Curve,
    /// All casters of a texel, if the nearest of them is in front of the receiver.
    Nearest,
    /// No casters.
    Opaque,
    /// Like `Nearest`, except where the nearest caster belongs to the receiver's own object; like `Curve`
    /// where receivers read curves.
    Others,
}

/// Properties that casters of one kind share.
///
/// A change of a field that light depends on renders the views anew that see its casters. Another
/// [`Self::transfer`], [`Self::shape`], [`Self::profile`] or a first [`Self::texture`] may need kernels to be
/// compiled first (`Shadows::pending`). A change that only the picture shows costs the maps nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name for people. Default empty.
    pub name: String,
    /// Transfer function of a hit. Default [`Transfer::Filter`].
    pub transfer: Transfer,
    /// Shape of its particles. Default [`Shape::Disc`].
    pub shape: Shape,
    /// Profile of its discs. Default [`Profile::Soft`].
    pub profile: Profile,
    /// Meaning of its Gaussians' opacity. Default [`GaussianOpacity::Splat`].
    pub gaussian: GaussianOpacity,
    /// Whether its Gaussians filter light as if they were black, with a neutral shadow. Default false.
    pub neutral: bool,
    /// Linear rgba, 0..=1; rgb up to [`MAX_GAIN`] with `gain`; for an opaque material, the albedo. Default 1.
    pub tint: Vec4,
    /// Index into [`crate::model::Scene::textures`]; multiplies the tint's colour and alpha. Default none.
    pub texture: Option<u32>,
    /// `r` in `a = 1 - (1 - alpha)(1 - r)`, 0..=1. Default 0.
    pub reflectivity: f32,
    /// Opacity from which a `cutout` is solid, 0..=1. Default 0.5.
    pub cutoff: f32,
    /// Pattern of the thresholds of `dither`. Default [`Pattern::default`].
    pub pattern: Pattern,
    /// Edge of a cell of the pattern, 1..=64 \[texels\]. Default 1.
    pub pattern_scale: u32,
    /// Emission (additive fire) in the picture: linear rgb, 0 or more. Default 0.
    pub emission: Vec3,
    /// Index into [`crate::model::Scene::textures`]; multiplies the emission of triangles. Default none.
    pub emissive_texture: Option<u32>,
    /// 0, the default: a surface that scatters light where it covers. 1: clear glass, which only filters.
    pub transmission: f32,
    /// Roughness of the highlight in the picture, 0..=1. Default 0.6.
    pub roughness: f32,
    /// Metalness of an opaque surface, 0..=1: 1 mirrors in its own colour and scatters nothing. Default 0.
    pub metallic: f32,
    /// Refractive index of its bodies for the picture, 1..=3; shadows are cast straight. Default 1: none.
    pub ior: f32,
    /// Reflection of its triangles. Default [`Fresnel::None`].
    pub fresnel: Fresnel,
    /// 20 over the Abbe number, 0..=20 (glTF `KHR_materials_dispersion`): how far apart red and blue light
    /// are refracted in [caustics](crate::Light::caustics). Default 0: not at all.
    pub dispersion: f32,
    /// Index into [`crate::model::Scene::materials`] for light that its triangles scatter to their far side
    /// (a leaf, a lampshade) in the picture, in that material's colour; on the light's side, its transmission
    /// is missing. Maps ignore it: add triangles of that material for the shadow. Default none.
    pub far_side: Option<u32>,
    /// Index into [`crate::model::Scene::materials`] of what the picture shows of its opaque triangles texel
    /// by texel: that material's texture has the share of the ambient light that gets there in red, the
    /// roughness in green and the metalness in blue, its emissive texture normals as of glTF (a channel of
    /// 0.5 is 0; red along u, green against v, blue off the surface). All are linear where the texture is
    /// sampled. Its own details are a clear coat over the surface: that material's reflectivity is the share
    /// that is covered and its roughness that of the coat, or else red and green of its texture, and its
    /// emissive texture has the coat's normals. Default none.
    pub details: Option<u32>,
    /// Blur of the scene behind a pane, as a radius per distance, 0..=1: frosted glass. Default 0.
    pub frost: f32,
    /// Transmittance over [`Self::attenuation_distance`] in a closed mesh: rgb, above 0 up to 1. Default 1.
    pub attenuation_color: Vec3,
    /// Distance of [`Self::attenuation_color`], above 0 \[m\]. Default infinite: the material is no volume.
    /// Triangles of a volume are counterclockwise from outside.
    pub attenuation_distance: f32,
    /// Casters that tint it. Default [`Receives::Curve`].
    pub receives: Receives,
    /// Whether the picture shows it; if not, it casts a shadow without being seen. Default true.
    pub visible: bool,
    /// Whether its solid surfaces show the surroundings behind them, times the share of light that reaches
    /// them: a floor of which a picture shows only the shadows. Default false.
    pub catcher: bool,
    /// Whether triangles show their colour in the picture, whatever the light. Default false.
    pub unlit: bool,
    /// Whether it blocks or filters light; if not, it is seen but casts no shadow. Default true.
    pub casts: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            transfer: Transfer::Filter,
            shape: Shape::Disc,
            profile: Profile::Soft,
            gaussian: GaussianOpacity::Splat,
            neutral: false,
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
            ior: 1.0,
            fresnel: Fresnel::None,
            dispersion: 0.0,
            far_side: None,
            details: None,
            frost: 0.0,
            attenuation_color: Vec3::ONE,
            attenuation_distance: f32::INFINITY,
            receives: Receives::default(),
            visible: true,
            catcher: false,
            unlit: false,
            casts: true,
        }
    }
}

/// Opacity below which casters are faint. A product of `n` transmittances is off by `n` roundings of 2^-25,
/// in light that falls as `exp(-n a)`: by 2^-14 here.
pub(crate) const FAINTEST: f32 = 1.0 / 4096.0;

impl Material {
    /// Whether its particles are soft discs of the `filter` transfer, without texture or reflectivity.
    pub fn is_plain_disc(&self) -> bool {
        self.shape == Shape::Disc
            && self.profile == Profile::Soft
            && self.transfer == Transfer::Filter
            && self.reflectivity == 0.0
            && self.texture.is_none()
    }

    /// Whether its casters are splats of the `filter` transfer.
    pub fn is_plain_splat(&self) -> bool {
        self.shape == Shape::Gaussian && self.transfer == Transfer::Filter && !self.is_medium()
    }

    /// Whether the picture shows the scene behind it refracted or blurred.
    pub fn refracts(&self) -> bool {
        !self.transfer.is_opaque() && self.visible && (self.ior > 1.0 || self.frost > 0.0)
    }

    /// Whether its Gaussians absorb along the ray.
    pub fn is_medium(&self) -> bool {
        self.shape == Shape::Gaussian && matches!(self.gaussian, GaussianOpacity::Medium { .. })
    }

    /// Opacity of a caster of opacity `alpha`, without texture or profile.
    pub(crate) fn opacity(&self, alpha: f32) -> f32 {
        1.0 - (1.0 - alpha * self.tint.w) * (1.0 - self.reflectivity)
    }

    /// Whether products of the transmittances of many such casters lose their absorption to rounding.
    pub fn is_faint(&self, alpha: f32) -> bool {
        let opacity = self.opacity(alpha);
        opacity > 0.0 && opacity < FAINTEST
    }

    /// Whether closed meshes of it absorb light over the distance travelled inside.
    pub fn is_volume(&self) -> bool {
        self.absorption() != Vec3::ZERO
    }

    /// Absorption coefficient inside its volumes, per channel [1/m].
    pub fn absorption(&self) -> Vec3 {
        /// Least attenuation colour, 20 halvings; powers of 0 differ between adapters.
        const MIN: f32 = 1e-6;
        if !self.attenuation_distance.is_finite() {
            return Vec3::ZERO;
        }
        -self.attenuation_color.clamp(Vec3::splat(MIN), Vec3::ONE).map(f32::ln)
            / self.attenuation_distance
    }
}

/// A caster that faces the light: a disc, quad or puff by its material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// Centre, world space \[m\].
    pub center: Vec3,
    /// Radius of the disc or puff; half the side of the quad \[m\].
    pub radius: f32,
    /// Linear rgba; multiplies the material's tint.
    pub color: Vec4,
    /// Rotation of a quad about the ray from the light \[radians\].
    pub rotation: f32,
    /// Index into [`crate::model::Scene::materials`].
    pub material: u32,
    /// Seed of dither patterns; unique where the file gives one.
    pub id: u32,
}

impl Default for Particle {
    /// A white particle of 0.1 m radius at the origin.
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
    /// A white opaque particle; centre in world space \[m\], radius \[m\].
    pub fn new(center: impl Into<[f32; 3]>, radius: f32) -> Self {
        Self { center: center.into().into(), radius, ..Self::default() }
    }

    /// The particle with a linear rgba colour, which multiplies the material's tint.
    #[must_use]
    pub fn with_color(self, color: impl Into<[f32; 4]>) -> Self {
        Self { color: color.into().into(), ..self }
    }

    /// Short reason why it cannot be used; `None` if it can. `max_color`: its [`Transfer::max_color`].
    pub fn problem(&self, max_color: f32) -> Option<&'static str> {
        let Self { center, radius, color, rotation, .. } = *self;
        let is_finite =
            center.is_finite() && radius.is_finite() && color.is_finite() && rotation.is_finite();
        let rgb = color.truncate();
        if !is_finite {
            Some("not finite")
        } else if center.abs().max_element() > FARTHEST || radius > FARTHEST {
            Some("too far")
        } else if radius <= 0.0 {
            Some("radius not positive")
        } else if rgb.min_element() < 0.0 || rgb.max_element() > max_color {
            Some("colour out of range")
        } else if !(0.0..=1.0).contains(&color.w) {
            Some("alpha out of range")
        } else {
            None
        }
    }
}

/// A triangle of a mesh, two-sided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// Corners, world space \[m\].
    pub positions: [Vec3; 3],
    /// Unit normals of the corners, world space.
    pub normals: [Vec3; 3],
    /// Texture coordinates of the corners; row 0 of the texture is at v = 0.
    pub uvs: [Vec2; 3],
    /// Colours of the corners, which multiply the material's tint.
    pub colors: [VertexColor; 3],
    /// Index into [`crate::model::Scene::materials`].
    pub material: u32,
    /// Seed of dither patterns, one per object.
    pub id: u32,
}

impl Triangle {
    /// A flat-shaded triangle of a material; corners in world space \[m\], counterclockwise from its front.
    pub fn flat(corners: [impl Into<[f32; 3]>; 3], material: u32) -> Self {
        let positions = corners.map(|corner| Vec3::from(corner.into()));
        let [a, b, c] = positions;
        let normals = [(b - a).cross(c - a).normalize_or(Vec3::Y); 3];
        let colors = [VertexColor::WHITE; 3];
        Self { positions, normals, uvs: [Vec2::ZERO; 3], colors, material, id: 0 }
    }

    /// Whether its corners have colours of their own.
    pub fn is_colored(&self) -> bool {
        self.colors != [VertexColor::WHITE; 3]
    }
}

/// An image that materials sample, bilinear and repeating. Colours are weighted by alpha, so that clear
/// texels have none, except in `opaque`, `stain` and `gain`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Name for people.
    pub name: String,
    /// Width \[texels\].
    pub width: u32,
    /// Height \[texels\].
    pub height: u32,
    /// `width * height` rgba bytes, rows from the top; rgb is sRGB, alpha is linear.
    pub rgba: Vec<u8>,
}

/// The casters, in world space. Positions are 32-bit floats with 24 bits of precision: a host with a large
/// world gives them and the views relative to a point near the camera (10 km away, rounding is 1 mm). Casters
/// name their material by its index, and materials their texture.
#[derive(Clone, Copy, Debug, Default)]
pub struct Casters<'a> {
    /// Discs, quads and puffs.
    pub particles: &'a [Particle],
    /// Anisotropic Gaussians.
    pub gaussians: &'a [Gaussian],
    /// Triangles of meshes.
    pub triangles: &'a [Triangle],
    /// Grids of voxels.
    pub grids: &'a [Grid],
    /// Hair, ribbons and trails.
    pub strands: &'a [Strand],
    /// Materials, at most 512.
    pub materials: &'a [Material],
    /// Textures that materials sample.
    pub textures: &'a [Texture],
    /// Keeps particles in the given order, which matters where several have the same depth. Otherwise they
    /// are sorted so that neighbours share a group, and views cull whole groups. A host whose particles are
    /// already spatially coherent saves that sort.
    pub in_order: bool,
}

impl Casters<'_> {
    /// Particles, Gaussians, triangles, bricks and capsules.
    pub fn count(&self) -> u64 {
        let bricks: usize = self.grids.iter().map(|grid| grid.bricks.len()).sum();
        let capsules: usize = self.strands.iter().map(|s| s.vertices.len().saturating_sub(1)).sum();
        (self.particles.len() + self.gaussians.len() + self.triangles.len() + bricks + capsules)
            as u64
    }
}
