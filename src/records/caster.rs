//! Particles as uploaded to kernels.
use super::pack::{from_opacity, from_unorm, opacity_bits, unorm2};
use crate::model::{Material, Particle};
use glam::{Vec3, Vec4};

/// Texels of a [`Caster`].
pub const CASTER_TEXELS: u32 = 2;

crate::records::texel_struct! {
    /// A particle as kernels read it.
    pub struct Caster {
        /// World space \[m\].
        pub center: Vec3,
        /// Radius \[m\].
        pub radius: f32,
        /// Red and green, unorm16; divided by 16 for a `gain` material.
        pub red_green: u32,
        /// Blue, unorm16, and alpha, f16.
        pub blue_alpha: u32,
        /// Material in the low half, rotation in the high one [turns / 65536].
        pub material_rotation: u32,
        pub id: u32,
    }
}

impl Caster {
    pub fn new(particle: &Particle, material: &Material) -> Self {
        let color = particle.color.truncate() / material.transfer.max_color();
        let turns = particle.rotation / std::f32::consts::TAU;
        let turns = turns - turns.floor();
        Self {
            center: particle.center,
            radius: particle.radius,
            red_green: unorm2(color.x, color.y),
            blue_alpha: unorm2(color.z, 0.0) | opacity_bits(particle.color.w) << 16,
            material_rotation: (particle.material & 0xffff)
                | ((turns * 65536.0).round() as u32 & 0xffff) << 16,
            id: particle.id,
        }
    }

    pub fn material(&self) -> u32 {
        self.material_rotation & 0xffff
    }

    /// Rotation of a quad [radians].
    pub fn rotation(&self) -> f32 {
        (self.material_rotation >> 16) as f32 * (std::f32::consts::TAU / 65536.0)
    }

    /// Linear rgba, before the material's tint; rgb is divided by 16 for a `gain` material.
    pub fn color(&self) -> Vec4 {
        Vec4::new(
            from_unorm(self.red_green),
            from_unorm(self.red_green >> 16),
            from_unorm(self.blue_alpha),
            from_opacity(self.blue_alpha >> 16),
        )
    }
}
