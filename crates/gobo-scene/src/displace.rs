//! Spheres displaced by animated noise: closed, lumpy bodies for clouds of dust.
use super::{lattice_noise::LatticeNoise, numbers::array, shapes, shapes::KindOfShape};
use glam::{Mat3, Mat4, Vec3};
use gobo::{
    model::{Bounds, Motion, Scene, Triangle},
    records::pcg,
};
use rayon::prelude::*;
use std::{collections::HashMap, sync::Arc};

/// Displacement of a sphere along its radius.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Displace {
    /// Largest change of the radius, 0 to 0.9: below 1, so that the surface never turns inside out.
    pub amplitude: f32,
    /// Lumps of the coarsest octave per radius.
    #[serde(default = "two")]
    pub frequency: f32,
    /// Speed at which lumps appear and vanish [1/s].
    #[serde(default)]
    pub speed: f32,
    /// Velocity of the noise through the sphere \[radii per second\].
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
    /// Index into the scene's materials.
    pub material: u32,
}

/// Time span in which an endless motion is sampled \[s\].
const CHANGED: f64 = 4.0;
const OCTAVES: usize = 4;
/// Amplitude of an octave over that of the one before; low, so that the surface looks like lumps and not like
/// rock.
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

    /// Its octaves of noise at a time \[s\].
    fn octaves(&self, seconds: f64) -> [LatticeNoise; OCTAVES] {
        let age = (f64::from(self.speed) * seconds).rem_euclid(65536.0) as f32;
        std::array::from_fn(|octave| {
            let seed = pcg(self.seed ^ ((octave as u32) << 24));
            LatticeNoise::new(age * (octave + 1) as f32, seed)
        })
    }

    /// Radius along a unit vector, relative to the sphere's. `shift`: of the noise since the start.
    fn radius(&self, along: Vec3, shift: Vec3, octaves: &mut [LatticeNoise; OCTAVES]) -> f32 {
        let mut sum = 0.0;
        for (octave, noise) in octaves.iter_mut().enumerate() {
            let cells = self.frequency * (1 << octave) as f32;
            sum += noise.at((along - shift) * cells) * ROUGHNESS.powi(octave as i32);
        }
        1.0 + self.amplitude * (sum / SPREAD).clamp(-1.0, 1.0)
    }

    /// Displaces `triangles` of the unit sphere, and takes them to world space.
    pub(super) fn apply(&self, triangles: &mut [Triangle], world_from_sphere: Mat4, seconds: f64) {
        // Corners with equal bits are one vertex, so that the body stays closed to the last bit.
        let mut indices: HashMap<[u32; 3], usize> = HashMap::new();
        let mut directions = Vec::new();
        let mut index_of = |corner: Vec3| {
            *indices.entry(corner.to_array().map(f32::to_bits)).or_insert_with(|| {
                directions.push(corner);
                directions.len() - 1
            })
        };
        let corners: Vec<[usize; 3]> =
            triangles.iter().map(|triangle| triangle.normals.map(&mut index_of)).collect();
        let shift = Vec3::from_array(self.drift.map(|speed| (f64::from(speed) * seconds) as f32));
        let moved: Vec<Vec3> = directions
            .par_iter()
            .with_min_len(4096)
            .map_init(
                || self.octaves(seconds),
                |octaves, &along| {
                    let local = along * (0.5 * self.radius(along, shift, octaves));
                    world_from_sphere.transform_point3(local)
                },
            )
            .collect();
        let turned = Mat3::from_mat4(world_from_sphere).determinant() < 0.0;
        let mut normals = vec![Vec3::ZERO; moved.len()];
        for (triangle, corners) in triangles.iter_mut().zip(&corners) {
            triangle.positions = corners.map(|corner| moved[corner]);
            let [a, b, c] = triangle.positions;
            let face = (b - a).cross(c - a) * if turned { -1.0 } else { 1.0 };
            corners.iter().for_each(|&corner| normals[corner] += face);
        }
        for (triangle, corners) in triangles.iter_mut().zip(&corners) {
            triangle.normals =
                corners.map(|corner| normals[corner].try_normalize().unwrap_or(Vec3::Y));
        }
    }
}

impl Displaced {
    /// Range of its triangles in the scene.
    pub(super) fn triangles(&self) -> std::ops::Range<usize> {
        self.first_triangle..self.first_triangle + shapes::sphere_triangles(self.level)
    }

    /// Displaces its triangles at a time \[s\].
    pub(super) fn set_time(&self, target: &mut [Triangle], seconds: f64) {
        let _phase = tracing::debug_span!("generate").entered();
        let mut sphere = shapes::sphere(self.level);
        self.displace.apply(&mut sphere, self.world_from_sphere, seconds);
        gobo::model::turn_outwards(&mut sphere);
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

    fn span(&self) -> Option<[f64; 2]> {
        Some([0.0, CHANGED])
    }

    fn reach(&self, wanted: &dyn Fn(u32) -> bool) -> Bounds {
        let most = 0.5 * (1.0 + self.displace.amplitude);
        let around = Bounds::EMPTY.with_sphere(Vec3::ZERO, most);
        let corners =
            around.corners().map(|corner| self.world_from_sphere.transform_point3(corner));
        let reach = Bounds::EMPTY;
        if wanted(self.material) {
            corners.iter().fold(reach, |reach, &corner| reach.with_sphere(corner, 0.0))
        } else {
            reach
        }
    }

    fn moved(&self, by: Vec3) -> Option<Arc<dyn Motion>> {
        let world_from_sphere = Mat4::from_translation(by) * self.world_from_sphere;
        Some(Arc::new(Self { world_from_sphere, ..*self }))
    }
}
