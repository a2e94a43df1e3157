//! Absorbing closed meshes (glTF `KHR_materials_volume`).
//!
//! Along a ray, the thickness of all volumes of one material is the sum of the depths of the faces turned
//! away from the light, minus those of the faces turned towards it, each at most the opaque depth: sums
//! commute, the air between two volumes does not count, and faces need not be paired.
use crate::model::{Material, Triangle};
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Largest optical depth through one material's volumes: fixed-point sums hold twice that without wrapping.
/// At this bound, anything thicker than a 2,000th of the bounds is black.
const MAX_TAU: f32 = 16384.0;

/// Absorption coefficient of each material's volumes, per channel [1/m]; zero if it is no volume. Bounded so
/// that the sums hold the thickness of all its volumes.
pub fn absorptions(materials: &[Material], triangles: &[Triangle]) -> Vec<Vec3> {
    let mut bounds = vec![(Vec3::INFINITY, Vec3::NEG_INFINITY); materials.len()];
    let is_volume: Vec<bool> = materials.iter().map(Material::is_volume).collect();
    for triangle in triangles.iter().filter(|t| is_volume[t.material as usize]) {
        let (min, max) = &mut bounds[triangle.material as usize];
        for corner in triangle.positions {
            (*min, *max) = (min.min(corner), max.max(corner));
        }
    }
    let absorption = |(material, (min, max)): (&Material, (Vec3, Vec3))| {
        if !min.cmple(max).all() {
            return Vec3::ZERO;
        }
        let most = MAX_TAU / (max - min).length().max(f32::MIN_POSITIVE);
        material.absorption().min(Vec3::splat(most))
    };
    materials.iter().zip(bounds).map(absorption).collect()
}

/// Whether every edge is used as often in one direction as in the other.
pub fn is_closed(triangles: &[Triangle]) -> bool {
    // -0 and 0 are one position.
    let key = |p: Vec3| (p + 0.0).to_array().map(f32::to_bits);
    let mut edges = HashMap::new();
    for triangle in triangles {
        let [a, b, c] = triangle.positions.map(key);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if from < to {
                *edges.entry((from, to)).or_insert(0) += 1;
            } else if to < from {
                *edges.entry((to, from)).or_insert(0) -= 1;
            }
        }
    }
    edges.values().all(|balance: &i32| *balance == 0)
}

/// Makes a closed mesh's triangles counterclockwise from outside; normals stay.
pub fn turn_outwards(triangles: &mut [Triangle]) {
    let volume: f64 = triangles
        .iter()
        .map(|triangle| {
            let [a, b, c]: [DVec3; 3] = triangle.positions.map(Vec3::as_dvec3);
            a.dot(b.cross(c))
        })
        .sum();
    if volume < 0.0 {
        for triangle in triangles {
            triangle.positions.swap(1, 2);
            triangle.normals.swap(1, 2);
            triangle.uvs.swap(1, 2);
            triangle.colors.swap(1, 2);
        }
    }
}
