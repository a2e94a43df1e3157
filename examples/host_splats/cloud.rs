//! Two layouts of splats, and their decoding.
use gobo::{
    Gaussian,
    glam::{Quat, Vec3},
};

/// A number of 0 to 1 (pcg, Jarzynski and Olano 2020).
fn chance(seed: u32) -> f32 {
    let state = seed.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    ((word >> 22) ^ word) as f32 / u32::MAX as f32
}

/// Needles along a ring. Rings with other numbers have another colour and position.
pub(crate) fn ring(count: u32, number: u32) -> Vec<Gaussian> {
    let one = |id: u32| {
        let chance = |n| chance((id * 8 + n) * 2 + number) - 0.5;
        let turn = id as f32 / count as f32 * std::f32::consts::TAU;
        let (sine, cosine) = turn.sin_cos();
        let side = if number == 1 { -0.55 } else { 0.55 };
        let off = Vec3::new(chance(0), chance(1), chance(2)) * 0.5;
        let waves = 0.5 + 0.5 * (3.0 * turn).sin();
        let color = if number == 1 {
            Vec3::new(0.95, 0.35 + 0.4 * waves, 0.12)
        } else {
            Vec3::new(0.1, 0.4 + 0.4 * waves, 0.95)
        };
        Gaussian {
            center: Vec3::new(side + 1.1 * cosine, 1.0 + 0.3 * sine, 1.1 * sine) + off,
            rotation: Quat::from_rotation_y(-turn) * Quat::from_rotation_x(chance(3) * 0.5),
            sigma: Vec3::new(0.02, 0.02, 0.1) * (1.0 + chance(4)),
            color,
            opacity: 0.3 + 0.3 * chance(5),
            material: 0,
            id,
        }
    };
    (0..count).map(one).collect()
}

/// A splat of 32 bytes.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Packed {
    place: [f32; 3],
    scale: [f32; 3],
    rgba: [u8; 4],
    turn: [u8; 4],
}

impl Packed {
    pub(crate) fn new(gaussian: &Gaussian) -> Self {
        let Gaussian { center, rotation, sigma, color, opacity, .. } = *gaussian;
        let [x, y, z, w] = rotation.to_array();
        Self {
            place: center.to_array(),
            scale: sigma.to_array(),
            rgba: color.extend(opacity).to_array().map(|share| (share * 255.0).round() as u8),
            turn: [w, x, y, z].map(|v| (v * 128.0 + 128.0).round().clamp(0.0, 255.0) as u8),
        }
    }

    pub(crate) fn gaussian(&self, id: u32) -> Gaussian {
        let [r, g, b, a] = self.rgba.map(|byte| f32::from(byte) / 255.0);
        let [w, x, y, z] = self.turn.map(|byte| (f32::from(byte) - 128.0) / 128.0);
        Gaussian {
            center: self.place.into(),
            rotation: Quat::from_xyzw(x, y, z, w).normalize(),
            sigma: self.scale.into(),
            color: Vec3::new(r, g, b),
            opacity: a,
            material: 0,
            id,
        }
    }
}

/// Splats, an array per property.
pub(crate) struct Arrays {
    means: Vec<[f32; 3]>,
    log_scales: Vec<[f32; 3]>,
    /// Scalar first, of any length.
    quaternions: Vec<[f32; 4]>,
    f_dc: Vec<[f32; 3]>,
    logits: Vec<f32>,
}

/// The first spherical harmonic.
const HARMONIC: f32 = 0.282_094_79;

impl Arrays {
    pub(crate) fn new(gaussians: &[Gaussian]) -> Self {
        let all = || gaussians.iter();
        Self {
            means: all().map(|g| g.center.to_array()).collect(),
            log_scales: all().map(|g| g.sigma.map(f32::ln).to_array()).collect(),
            quaternions: all()
                .map(|g| [g.rotation.w, g.rotation.x, g.rotation.y, g.rotation.z].map(|v| 3.0 * v))
                .collect(),
            f_dc: all().map(|g| ((g.color - 0.5) / HARMONIC).to_array()).collect(),
            logits: all().map(|g| (g.opacity / (1.0 - g.opacity)).ln()).collect(),
        }
    }

    /// Contents of five buffers.
    pub(crate) fn bytes(&self) -> [&[u8]; 5] {
        [
            bytemuck::cast_slice(&self.means),
            bytemuck::cast_slice(&self.log_scales),
            bytemuck::cast_slice(&self.quaternions),
            bytemuck::cast_slice(&self.f_dc),
            bytemuck::cast_slice(&self.logits),
        ]
    }

    pub(crate) fn gaussians(&self) -> impl Iterator<Item = Gaussian> + '_ {
        (0..self.means.len()).map(|i| {
            let [w, x, y, z] = self.quaternions[i];
            Gaussian {
                center: self.means[i].into(),
                rotation: Quat::from_xyzw(x, y, z, w).normalize(),
                sigma: Vec3::from(self.log_scales[i]).map(f32::exp),
                color: (0.5 + HARMONIC * Vec3::from(self.f_dc[i])).clamp(Vec3::ZERO, Vec3::ONE),
                opacity: 1.0 / (1.0 + (-self.logits[i]).exp()),
                material: 0,
                id: i as u32,
            }
        })
    }
}
