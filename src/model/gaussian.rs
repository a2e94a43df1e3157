//! Anisotropic Gaussians: captured scenes, and dust that is measured rather than drawn.
use super::bounds::{Bounds, FARTHEST};
use glam::{Mat3, Quat, Vec3};

/// Meaning of the opacity of a material's Gaussians. The two meanings are never converted into each other:
/// with equal opacity at the centre, the shadows' areas differ by a factor of 2.1 at 0.99
/// (docs/gaussians.md).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum GaussianOpacity {
    /// `alpha = opacity * exp(-q^2 / 2)` where the ray is closest to the centre in the Gaussian's own space,
    /// at distance `q` \[standard deviations\]: 3DGRT's maximum response, 3DGS's alpha for parallel rays.
    #[default]
    Splat,
    /// Extinction `density * opacity * exp(-q^2 / 2)` [1/m], whose integral along the ray up to the opaque
    /// surface is the optical depth.
    Medium {
        /// Extinction at the centre per unit of opacity [1/m].
        density: f32,
    },
}

impl GaussianOpacity {
    /// Largest opacity.
    pub(crate) fn most(self) -> f32 {
        match self {
            Self::Splat => 1.0,
            Self::Medium { density } => MAX_EXTINCTION / density,
        }
    }
}

/// Least value of `exp(-q^2 / 2)` times a Gaussian's opacity that counts in a shadow: cut there, hundreds of
/// overlapping Gaussians lose less than a step of a 16-bit map. Fainter Gaussians end at a 256th of their own
/// opacity, so that many of them lose less than 0.4 % of their shadow.
const FAINTEST: f32 = 1.0 / 8192.0;
const LEAST_SHARE: f32 = 1.0 / 256.0;
/// Squared distance at which the densest medium ends \[standard deviations\].
const MAX_REACH: f32 = 64.0;
/// Largest extinction at a medium's centre [1/m].
const MAX_EXTINCTION: f32 = 6e4;

/// Squared distance from the centre at which a Gaussian of opacity, or medium of optical depth, `opacity`
/// ends \[standard deviations\]. WGSL: `reach_squared` in `wgsl/project/conic.wgsl`.
pub fn reach_squared(opacity: f32) -> f32 {
    (2.0 * (opacity / FAINTEST).max(1.0 / LEAST_SHARE).ln()).min(MAX_REACH)
}

/// An anisotropic 3D Gaussian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian {
    /// Centre, world space \[m\].
    pub center: Vec3,
    /// Unit rotation of its axes, from its own space to the world.
    pub rotation: Quat,
    /// Standard deviations along its axes, above 0 \[m\].
    pub sigma: Vec3,
    /// Linear rgb, 0..=1 (16 with `gain`); multiplies the material's tint.
    pub color: Vec3,
    /// Opacity at the centre, 0..=1; for a medium, 0 or more. Multiplies the alpha of the material's tint.
    pub opacity: f32,
    /// Index into [`crate::model::Scene::materials`], of a material whose shape is
    /// [`super::Shape::Gaussian`].
    pub material: u32,
    /// Seed of dither patterns; unique where the file gives one.
    pub id: u32,
}

impl Default for Gaussian {
    /// A white opaque Gaussian of 0.1 m deviation at the origin.
    fn default() -> Self {
        Self {
            center: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            sigma: Vec3::splat(0.1),
            color: Vec3::ONE,
            opacity: 1.0,
            material: 0,
            id: 0,
        }
    }
}

impl Gaussian {
    /// Short reason why it cannot be used; `None` if it can. `max_color`: [`super::Transfer::max_color`] of
    /// its material; `opacity`: meaning of its opacity.
    pub fn problem(&self, max_color: f32, opacity: GaussianOpacity) -> Option<&'static str> {
        let Self { center, rotation, sigma, color, .. } = *self;
        let finite = center.is_finite()
            && rotation.is_finite()
            && sigma.is_finite()
            && color.is_finite()
            && self.opacity.is_finite();
        let in_range = |v: f32| (0.0..=opacity.most()).contains(&v);
        if !finite {
            Some("gaussian not finite")
        } else if center.abs().max_element() > FARTHEST || sigma.max_element() > FARTHEST {
            Some("gaussian too far")
        } else if sigma.min_element() <= 0.0 {
            Some("gaussian sigma not positive")
        } else if !rotation.is_normalized() {
            Some("gaussian rotation not of unit length")
        } else if color.min_element() < 0.0 || color.max_element() > max_color {
            Some("gaussian colour out of range")
        } else if !in_range(self.opacity) {
            Some("gaussian opacity out of range")
        } else {
            None
        }
    }

    /// Its standard deviations as vectors, world space \[m\]: columns.
    pub fn axes(&self) -> Mat3 {
        Mat3::from_quat(self.rotation) * Mat3::from_diagonal(self.sigma)
    }

    /// Optical depth of the ray along its longest axis, or the splat's opacity.
    pub fn most_opacity(&self, opacity: GaussianOpacity) -> f32 {
        match opacity {
            GaussianOpacity::Splat => self.opacity,
            GaussianOpacity::Medium { density } => {
                density * self.opacity * self.sigma.max_element() * std::f32::consts::TAU.sqrt()
            }
        }
    }

    /// Upper bound of the distance from the centre at which it ends \[standard deviations\].
    pub fn reach(&self, opacity: GaussianOpacity) -> f32 {
        reach_squared(self.most_opacity(opacity)).sqrt()
    }

    /// Radius of the sphere around it \[m\].
    pub fn radius(&self, opacity: GaussianOpacity) -> f32 {
        self.sigma.max_element() * self.reach(opacity)
    }

    /// Box around it, world space \[m\].
    pub fn bounds(&self, opacity: GaussianOpacity) -> Bounds {
        let axes = self.axes();
        let half = [0, 1, 2].map(|i| axes.row(i).length() * self.reach(opacity));
        let half = Vec3::from_array(half);
        Bounds { min: self.center - half, max: self.center + half }
    }
}
