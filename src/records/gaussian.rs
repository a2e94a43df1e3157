//! Gaussians as uploaded, and their setups for one view.
use super::{
    CasterRecord, Outline,
    pack::{color_bits, from_color_bits, from_opacity, opacity_bits},
};
use crate::model::{Gaussian, GaussianOpacity, Material, Transfer};
use glam::{Mat3, Quat, Vec2, Vec3};

/// Texels of a [`GaussianSetup`].
pub const GAUSSIAN_TEXELS: u32 = 3;
/// Texel of a [`GaussianSetup`] with its outline.
pub const OUTLINE_TEXEL: u32 = 2;
/// Rounding of a unit quaternion's squared length.
pub const UNIT_ROUNDING: f32 = 1e-6;
/// Flag of a Gaussian's [`CasterRecord::material_rotation`]: in shadow views its colour is black.
pub const NEUTRAL_BIT: u32 = 1 << 16;
/// Flag of a Gaussian's [`CasterRecord::material_rotation`]: a medium, whose alpha is its extinction
/// [1/m / 32768].
pub const MEDIUM_BIT: u32 = 1 << 17;

crate::records::gpu_struct! {
    /// A Gaussian's axes as kernels read them: a record as long as its [`CasterRecord`]. WGSL:
    /// `wgsl/records/caster.wgsl`.
    pub struct GaussianAxes {
        /// Unit quaternion x, y, z, w: from its own space to the world.
        pub rotation: [f32; 4],
        /// Standard deviations \[m\].
        pub sigma: Vec3,
        /// Seed of dither patterns.
        pub id: u32,
    }
}

impl GaussianAxes {
    /// The axes of a Gaussian.
    pub fn new(gaussian: &Gaussian) -> Self {
        let Gaussian { rotation, sigma, id, .. } = *gaussian;
        // A Newton step to unit length, which it has within 1e-4. A quaternion of unit length up to rounding
        // keeps its bits, so that devices, which round otherwise, have the same.
        let squared = rotation.length_squared();
        let is_unit = (squared - 1.0).abs() <= UNIT_ROUNDING;
        let step = if is_unit { 1.0 } else { 1.5 - 0.5 * squared };
        Self { rotation: rotation.to_array().map(|v| v * step), sigma, id }
    }

    /// The standard deviations as vectors, world space \[m\]: columns.
    pub fn columns(&self) -> Mat3 {
        Mat3::from_quat(Quat::from_array(self.rotation)) * Mat3::from_diagonal(self.sigma)
    }
}

/// Flags of the records of a material's Gaussians.
pub(super) fn gaussian_marks(material: &Material) -> u32 {
    let neutral = if material.neutral { NEUTRAL_BIT } else { 0 };
    let medium = matches!(material.gaussian, GaussianOpacity::Medium { .. });
    neutral | if medium { MEDIUM_BIT } else { 0 }
}

impl CasterRecord {
    /// The record of a Gaussian; `axes`: index of its [`GaussianAxes`].
    pub fn of_gaussian(gaussian: &Gaussian, material: &Material, axes: u32) -> Self {
        let is_gain = material.transfer == Transfer::Gain;
        let color = gaussian.color / material.transfer.max_color();
        let opacity = match material.gaussian {
            GaussianOpacity::Splat => gaussian.opacity,
            GaussianOpacity::Medium { density } => {
                gaussian.opacity * density / super::OPACITY_SCALE
            }
        };
        Self {
            center: gaussian.center,
            radius: gaussian.radius(material.gaussian),
            red_green: color_bits(color.x, is_gain) | color_bits(color.y, is_gain) << 16,
            blue_alpha: color_bits(color.z, is_gain) | opacity_bits(opacity) << 16,
            material_rotation: (gaussian.material & 0xffff) | gaussian_marks(material),
            id: axes,
        }
    }
}

crate::records::texel_struct! {
    /// A Gaussian projected to one view, for the hit test.
    ///
    /// With `delta` the vector from the reference to the texel's centre \[texels\] and
    /// `u = (a delta.x + b delta.y, c delta.y)`, the ray's least distance from the centre in the Gaussian's
    /// own space is `q^2 = |u|^2 / (e^2 + spread |u|^2)` where `e = 1 + tilt . u`, at
    /// `e / (e^2 + spread |u|^2)` times the centre's distance along the axis. In an orthographic view,
    /// `q^2 = |u|^2`, at the centre's light depth less `tilt . u`.
    #[derive(Default)]
    pub struct GaussianSetup {
        /// `a`, `b` and `c` [1/texels].
        pub whitening: Vec3,
        /// Squared deviation along the ray through the centre, as a share of the distance (orthographic: of
        /// the depth range).
        pub spread: f32,
        pub tilt: Vec2,
        /// Colour times tint, red and green, the roots of 1 - c in 16 bits; divided by 16 for a `gain`
        /// material.
        pub red_green: u32,
        /// Blue, the root of 1 - c in 16 bits, and the thinning by enlargement, f16.
        pub blue_thin: u32,
        /// Tiles of its outline, where its rectangle marks one.
        pub outline: Outline,
    }
}

impl GaussianSetup {
    /// `transfer`: the material's.
    pub fn set_color(&mut self, color: Vec3, transfer: u32, thin: f32) {
        let is_gain = transfer == Transfer::Gain as u32;
        self.red_green = color_bits(color.x, is_gain) | color_bits(color.y, is_gain) << 16;
        self.blue_thin = color_bits(color.z, is_gain) | opacity_bits(thin) << 16;
    }

    /// Colour `c`, rgb; divided by 16 for a `gain` material. `transfer`: the material's.
    pub fn color(&self, transfer: u32) -> Vec3 {
        let words = [self.red_green, self.red_green >> 16, self.blue_thin];
        Vec3::from(words.map(|word| from_color_bits(word, transfer == Transfer::Gain as u32)))
    }

    /// Ratio of its area to its projected, enlarged area.
    pub fn thin(&self) -> f32 {
        from_opacity(self.blue_thin >> 16)
    }
}
