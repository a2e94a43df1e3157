//! Spheres displaced by animated noise: closed, lumpy bodies for clouds of dust.
use super::{numbers::array, shapes, shapes::KindOfShape};
use crate::{
    model::{Motion, Scene, Triangle},
    records::pcg,
};
use glam::{IVec3, Mat3, Mat4, Vec3};
use std::{collections::HashMap, sync::Arc};

/// Displacement of a sphere along its radius.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Displace {
    /// Largest change of the radius, 0 to 0.9: below 1, so that it never turns inside out.
    pub amplitude: f32,
    /// Lumps of the coarsest octave along a radius.
    #[serde(default = "two")]
    pub frequency: f32,
    /// Speed at which lumps appear and vanish [1/s].
    #[serde(default)]
    pub speed: f32,
    /// Velocity of the noise through the sphere [radii per second].
    #[serde(default, deserialize_with = "array")]
    pub drift: [f32; 3],
    #[serde(default)]
    pub seed: u32,
}

fn two() -> f32 {
    2.0
}

/// A displaced sphere of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displaced {
    /// First of its triangles in the scene.
    pub first_triangle: usize,
    pub displace: Displace,
    /// Subdivisions of an icosahedron.
    pub level: u32,
    pub world_from_sphere: Mat4,
}

const OCTAVES: u32 = 4;
/// Amplitude of an octave over that of the one before: lumps rather than rock.
const ROUGHNESS: f32 = 0.36;
/// About three standard deviations of the sum of octaves.
const SPREAD: f32 = 0.75;

impl Displace {
    pub const MAX_AMPLITUDE: f32 = 0.9;
    pub const MAX_FREQUENCY: f32 = 64.0;

    /// The problem of invalid parameters, and the remedy.
    pub(super) fn fault(&self, kind: KindOfShape) -> Option<(String, &'static str)> {
        if !matches!(kind, KindOfShape::Sphere) {
            return Some(("only spheres are displaced".to_owned(), "use kind = \"sphere\""));
        }
        let Self { amplitude, frequency, speed, drift: [x, y, z], .. } = *self;
        if !(0.0..=Self::MAX_AMPLITUDE).contains(&amplitude) {
            return Some((format!("amplitude is {amplitude}"), "amplitude is 0 to 0.9"));
        }
        if !(frequency > 0.0 && frequency <= Self::MAX_FREQUENCY) {
            let help = "frequency is above 0 and at most 64";
            return Some((format!("frequency is {frequency}"), help));
        }
        let fast = [speed, x, y, z].into_iter().find(|v| !v.is_finite() || v.abs() > 1e3);
        fast.map(|v| (format!("speed is {v}"), "speeds are finite, up to 1000"))
    }

    /// Whether it is animated.
    pub fn moves(&self) -> bool {
        self.speed != 0.0 || self.drift != [0.0; 3]
    }

    /// Radius along a unit vector, relative to the sphere's.
    fn radius(&self, along: Vec3, seconds: f64) -> f32 {
        let shift = Vec3::from_array(self.drift.map(|speed| (f64::from(speed) * seconds) as f32));
        let age = (f64::from(self.speed) * seconds).rem_euclid(65536.0) as f32;
        let mut sum = 0.0;
        for octave in 0..OCTAVES {
            let cells = self.frequency * (1 << octave) as f32;
            let seed = pcg(self.seed ^ (octave << 24));
            let height = gradient_noise((along - shift) * cells, age * (octave + 1) as f32, seed);
            sum += height * ROUGHNESS.powi(octave as i32);
        }
        1.0 + self.amplitude * (sum / SPREAD).clamp(-1.0, 1.0)
    }

    /// Displaces `triangles`, those of the unit sphere at its own origin, to world space.
    pub(super) fn apply(&self, triangles: &mut [Triangle], world_from_sphere: Mat4, seconds: f64) {
        let key = |p: Vec3| p.to_array().map(f32::to_bits);
        // Corners with equal bits are shared, so that the body stays closed to the last bit.
        let mut moved: HashMap<[u32; 3], Vec3> = HashMap::new();
        for corner in triangles.iter().flat_map(|triangle| triangle.normals) {
            moved.entry(key(corner)).or_insert_with(|| {
                let local = corner * (0.5 * self.radius(corner, seconds));
                world_from_sphere.transform_point3(local)
            });
        }
        let turned = Mat3::from_mat4(world_from_sphere).determinant() < 0.0;
        let mut normals: HashMap<[u32; 3], Vec3> = HashMap::new();
        for triangle in &mut *triangles {
            triangle.positions = triangle.normals.map(|corner| moved[&key(corner)]);
            let [a, b, c] = triangle.positions;
            let face = (b - a).cross(c - a) * if turned { -1.0 } else { 1.0 };
            for corner in triangle.normals {
                *normals.entry(key(corner)).or_default() += face;
            }
        }
        for triangle in triangles {
            triangle.normals = triangle.normals.map(|corner| {
                let corner = normals[&key(corner)].try_normalize();
                corner.unwrap_or(Vec3::Y)
            });
        }
    }
}

impl Displaced {
    /// Range of its triangles in the scene.
    pub(super) fn triangles(&self) -> std::ops::Range<usize> {
        self.first_triangle..self.first_triangle + shapes::sphere_triangles(self.level)
    }

    /// Displaces its triangles at a time [s].
    pub(super) fn set_time(&self, target: &mut [Triangle], seconds: f64) {
        let mut sphere = shapes::sphere(self.level);
        self.displace.apply(&mut sphere, self.world_from_sphere, seconds);
        crate::model::turn_outwards(&mut sphere);
        for (target, at) in target.iter_mut().zip(&sphere) {
            target.positions = at.positions;
            target.normals = at.normals;
            target.uvs = at.uvs;
        }
    }
}

impl Motion for Displaced {
    fn apply(&self, scene: &mut Scene, seconds: f64) {
        self.set_time(&mut scene.triangles[self.triangles()], seconds);
    }

    fn moved(&self, by: Vec3) -> Option<Arc<dyn Motion>> {
        let world_from_sphere = Mat4::from_translation(by) * self.world_from_sphere;
        Some(Arc::new(Self { world_from_sphere, ..*self }))
    }
}

/// Gradient noise on an infinite lattice (Perlin 2002); gradients rotate as `age` grows (Perlin and Neyret
/// 2001).
pub(super) fn gradient_noise(at: Vec3, age: f32, seed: u32) -> f32 {
    let low = at.floor();
    let part = at - low;
    let fade = part * part * part * (part * (part * 6.0 - 15.0) + 10.0);
    let corner = |x: i32, y: i32, z: i32| {
        let cell = low.as_ivec3() + IVec3::new(x, y, z);
        let [x_bits, y_bits, z_bits] = cell.to_array().map(i32::cast_unsigned);
        let hash = pcg(x_bits ^ pcg(y_bits ^ pcg(z_bits ^ seed)));
        // Two perpendicular axes, in whose plane the gradient rotates in either direction.
        let unit = |bits: u32| (bits & 0xffff) as f32 / 32767.5 - 1.0;
        let (bits, more) = (pcg(hash), pcg(hash ^ 0x9e37_79b9));
        let first = Vec3::new(unit(bits), unit(bits >> 16), unit(more)).normalize_or(Vec3::X);
        let second = first.any_orthonormal_vector();
        let turns = unit(more >> 16) + if hash & 1 == 0 { age.fract() } else { -age.fract() };
        let (sin, cos) = (turns * std::f32::consts::TAU).sin_cos();
        (first * cos + second * sin).dot(part - Vec3::new(x as f32, y as f32, z as f32))
    };
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let row = |y: i32, z: i32| mix(corner(0, y, z), corner(1, y, z), fade.x);
    let slice = |z: i32| mix(row(0, z), row(1, z), fade.y);
    mix(slice(0), slice(1), fade.z)
}
