//! CPU reference of `crates/gobo-picture/wgsl/shade/coat.wgsl`: a clear coat over an opaque surface, as of
//! glass (`KHR_materials_clearcoat`).
use super::reflectance::{HEAD_ON, lobe, rising};
use glam::Vec3;

/// A clear coat: it mirrors, and the surface sends out only light that it does not mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// Covered share of the surface; 0 without a coat.
    pub share: f32,
    /// Roughness of its highlights, 0 to 1.
    pub roughness: f32,
    /// Its own normal, unit, on the eye's side.
    pub normal: Vec3,
}

impl Coat {
    /// No coat.
    pub const NONE: Self = Self { share: 0.0, roughness: 0.0, normal: Vec3::ZERO };

    /// Share of light that it mirrors to the eye. A rough one has no grazing reflection.
    pub fn mirrored(&self, to_eye: Vec3) -> f32 {
        let grazing = (1.0 - self.roughness).max(HEAD_ON);
        let rise = rising(self.normal.dot(to_eye));
        self.share * (HEAD_ON + (grazing - HEAD_ON) * rise)
    }

    /// Highlight under light from `toward` per unit of reflectance, times the cosine.
    pub(super) fn shine(&self, toward: Vec3, to_eye: Vec3) -> f32 {
        let middle = (toward + to_eye).normalize();
        self.normal.dot(toward).max(0.0) * lobe(self.normal, middle, self.roughness)
    }
}
