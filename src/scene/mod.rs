//! Scenes: what the command line, the tests and the benches share.
mod defaults;
pub mod displace;
mod document;
mod error;
pub mod generate;
mod gltf;
mod gltf_file;
mod gltf_items;
mod gltf_json;
mod gltf_material;
mod gltf_mesh;
mod gltf_texture;
mod images;
mod light_tables;
mod limits;
mod load;
mod loader;
mod loader_files;
pub mod noise;
mod painted;
mod particles;
mod plain;
mod ply;
mod ply_header;
mod read;
mod shapes;
mod source;
mod summary;
mod tables;

pub use error::SceneError;
pub use gltf::Model;
pub use limits::Limit;
pub use load::{LoadOptions, load, load_as, load_with};
pub use particles::ParticleFile;
pub use summary::Summary;

use crate::{
    caster::{Material, Particle, Texture, Triangle},
    counters::Skipped,
    light::Light,
    settings::{Air, ClusterSettings, ShadowSettings},
};
use glam::{Mat4, UVec2, Vec3};
use std::path::Path;

/// The eye of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// World space [m].
    pub eye: Vec3,
    /// World space [m].
    pub target: Vec3,
    pub up: Vec3,
    /// Vertical field of view [radians].
    pub fov_y: f32,
    /// Of the picture [pixels].
    pub size: UVec2,
}

/// Everything a frame is made from, in world space. Every number in it is finite and in range:
/// what was not is in `skipped`.
#[derive(Clone, Debug)]
pub struct Scene {
    pub camera: Camera,
    pub shadow: ShadowSettings,
    pub clusters: ClusterSettings,
    pub lights: Vec<Light>,
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    /// Textures that follow the time.
    pub animated: Vec<noise::Animated>,
    /// Triangles that follow the time.
    pub displaced: Vec<displace::Displaced>,
    pub particles: Vec<Particle>,
    pub triangles: Vec<Triangle>,
    /// Light that comes from everywhere: linear rgb.
    pub ambient: Vec3,
    /// What the camera sees where there is nothing: linear rgb.
    pub background: Vec3,
    /// What scatters light on its way to the eye; `None` where it is clear.
    pub air: Option<Air>,
    /// Inputs left out, by reason.
    pub skipped: Skipped,
    /// What its files hold and nobody reads, a sentence each.
    pub notes: Vec<String>,
}

/// An axis-aligned box, world space [m]; empty while `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    pub min: Vec3,
    pub max: Vec3,
}

impl Bounds {
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    #[must_use]
    pub fn with_sphere(self, center: Vec3, radius: f32) -> Self {
        Self { min: self.min.min(center - radius), max: self.max.max(center + radius) }
    }

    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// The box, or the one around the unit sphere where it is empty: views need some extent.
    #[must_use]
    pub fn or_unit(&self) -> Self {
        if self.is_empty() { Self::EMPTY.with_sphere(Vec3::ZERO, 1.0) } else { *self }
    }

    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Of the sphere around the box [m].
    pub fn radius(&self) -> f32 {
        (self.max - self.min).length() * 0.5
    }

    /// Half the surface [m²].
    pub fn half_area(&self) -> f32 {
        let edge = self.max - self.min;
        edge.x * edge.y + edge.y * edge.z + edge.z * edge.x
    }

    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            Vec3::new(
                if i & 1 == 0 { self.min.x } else { self.max.x },
                if i & 2 == 0 { self.min.y } else { self.max.y },
                if i & 4 == 0 { self.min.z } else { self.max.z },
            )
        })
    }
}

impl Scene {
    /// Of all casters and receivers.
    pub fn bounds(&self) -> Bounds {
        let particles =
            self.particles.iter().fold(Bounds::EMPTY, |b, p| b.with_sphere(p.center, p.radius));
        self.triangles
            .iter()
            .flat_map(|t| t.positions)
            .fold(particles, |b, p| b.with_sphere(p, 0.0))
    }
}

/// Reads a PLY or CSV file alone, for hosts that make their own scenes. The particles refer to
/// material `material_id` of the host's list; ids default to row number + `first_id`;
/// `default_radius` [m] is for files without one.
pub fn load_particles(
    path: &Path,
    material: &Material,
    material_id: u32,
    default_radius: Option<f32>,
    first_id: u32,
) -> Result<ParticleFile, SceneError> {
    particles::load(path, material, material_id, default_radius, first_id, 0)
}

/// Reads a `.glb` or `.gltf` file alone. World space = `transform` * glTF space.
pub fn load_model(path: &Path, transform: Mat4) -> Result<Model, SceneError> {
    gltf::load(path, transform, &gltf::Earlier::default())
}
