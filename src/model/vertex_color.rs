//! Colours of vertices.
use glam::{Vec3, Vec4};

/// Linear rgba of a vertex in four bytes: the square roots of red, green and blue, and alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VertexColor(pub [u8; 4]);

impl VertexColor {
    /// The neutral factor.
    pub const WHITE: Self = Self([255; 4]);

    /// The nearest colour; `rgba`: linear, 0..=1.
    pub fn new(rgba: Vec4) -> Self {
        let [r, g, b] = rgba.truncate().clamp(Vec3::ZERO, Vec3::ONE).map(f32::sqrt).to_array();
        Self([r, g, b, rgba.w.clamp(0.0, 1.0)].map(|value| (value * 255.0).round() as u8))
    }

    /// The bits that kernels read.
    pub(crate) fn bits(self) -> u32 {
        u32::from_le_bytes(self.0)
    }
}

impl Default for VertexColor {
    fn default() -> Self {
        Self::WHITE
    }
}
