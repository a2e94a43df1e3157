//! Particles as uploaded to kernels.
use super::pack::{color_bits, from_color_bits, from_opacity, opacity_bits};
use crate::model::{Material, Particle, Transfer};
use glam::{Vec3, Vec4};

/// Texels of a [`CasterRecord`] in a texture.
pub const CASTER_TEXELS: u32 = 2;

crate::records::gpu_struct! {
    /// A particle as kernels read it. WGSL: `wgsl/records/record.wgsl`.
    pub struct CasterRecord {
        /// World space \[m\].
        pub center: Vec3,
        /// Radius \[m\].
        pub radius: f32,
        /// Red and green, the roots of 1 - c in 16 bits; divided by 16 for a `gain` material.
        pub red_green: u32,
        /// Blue, the roots of 1 - c in 16 bits, and alpha, f16.
        pub blue_alpha: u32,
        /// Material in the low half, rotation in the high one [turns / 65536].
        pub material_rotation: u32,
        pub id: u32,
    }
}

impl CasterRecord {
    /// The record of a particle.
    pub fn new(particle: &Particle, material: &Material) -> Self {
        let is_gain = material.transfer == Transfer::Gain;
        let color = particle.color.truncate() / material.transfer.max_color();
        let turns = particle.rotation / std::f32::consts::TAU;
        let turns = turns - turns.floor();
        Self {
            center: particle.center,
            radius: particle.radius,
            red_green: color_bits(color.x, is_gain) | color_bits(color.y, is_gain) << 16,
            blue_alpha: color_bits(color.z, is_gain) | opacity_bits(particle.color.w) << 16,
            material_rotation: (particle.material & 0xffff)
                | ((turns * 65536.0).round() as u32 & 0xffff) << 16,
            id: particle.id,
        }
    }

    /// Index of its material.
    pub fn material(&self) -> u32 {
        self.material_rotation & 0xffff
    }

    /// Rotation of a quad \[radians\].
    pub fn rotation(&self) -> f32 {
        (self.material_rotation >> 16) as f32 * (std::f32::consts::TAU / 65536.0)
    }

    /// Linear rgba, before the material's tint; rgb is divided by 16 for a `gain` material. `transfer`: the
    /// material's.
    pub fn color(&self, transfer: u32) -> Vec4 {
        let is_gain = transfer == Transfer::Gain as u32;
        Vec4::new(
            from_color_bits(self.red_green, is_gain),
            from_color_bits(self.red_green >> 16, is_gain),
            from_color_bits(self.blue_alpha, is_gain),
            from_opacity(self.blue_alpha >> 16),
        )
    }
}
