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

use crate::model::{
    Air, Bounds, Camera, ClusterSettings, Light, Material, Particle, ShadowSettings, Skipped,
    Texture, Triangle,
};
use glam::{Mat4, Vec3};
use std::path::Path;

/// Everything a frame is made from, in world space. Every number in it is finite and in range:
/// what was not is in `skipped`.
#[derive(Clone, Debug)]
pub struct Scene {
    pub camera: Camera,
    /// Of the picture [stops]: light is shown 2 to this power as bright.
    pub exposure: f32,
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
