//! Scene files, for the command line, tests and benches.
#![warn(missing_docs)]
mod animate;
mod announced;
mod chest;
#[doc(hidden)]
pub mod clouds;
mod defaults;
mod deform;
mod dense;
#[doc(hidden)]
pub mod displace;
mod document;
mod emitters;
mod environment;
mod error;
mod exposure;
mod faces;
mod far_sides;
mod format_table;
mod formats;
mod fur;
#[doc(hidden)]
pub mod generate;
mod gltf;
mod held;
mod images;
mod keys;
mod ktx2;
mod lattice_noise;
mod light_tables;
mod limits;
mod load;
mod loader;
mod loader_files;
mod loader_splats;
mod look;
mod look_presets;
mod models;
mod named;
#[doc(hidden)]
pub mod noise;
mod numbers;
mod obj;
mod obj_materials;
mod origin;
mod painted;
mod particles;
mod plain;
mod ply;
mod ply_body;
mod ply_header;
mod ply_mesh;
mod points;
mod rays;
mod read;
mod rig;
mod room;
mod shapes;
mod share;
mod source;
mod splat_file;
#[doc(hidden)]
pub mod splats;
mod strands;
mod subject;
mod summary;
mod tables;
#[doc(hidden)]
pub mod track;
mod units;
mod vdb;
mod volume_file;
mod volume_frame;
mod volumes;

pub use defaults::{empty_scene, usual_camera};
pub use error::SceneError;
pub use format_table::{FORMATS, Family, Format};
pub use formats::{facts, format_of};
pub use gltf::Model;
pub use gobo::model::Scene;
pub use held::{HeldFile, HeldFiles, hold_files};
pub use limits::Limit;
pub use load::{
    LoadOptions, Relit, check, check_with, inspect, load, load_as, load_text, load_with,
    load_with_splats,
};
pub use named::files;
pub use origin::{recentre, rounding_warning};
pub use particles::ParticleFile;
pub use share::Share;
pub use splat_file::{load_harmonics, load_splats};
pub use summary::Summary;
#[doc(hidden)]
pub use {load::asked_keys, read::watch_files};

use glam::Mat4;
use gobo::model::{Bounds, Camera, Material};
use std::path::Path;

/// Reads a PLY or CSV file, or a point cloud (LAS, LAZ, PCD, E57), alone, for hosts that make their own
/// scenes. The particles refer to material `material_id` of the host's list; ids default to row number +
/// `first_id`; `default_radius` \[m\] is for files without radii.
pub fn load_particles(
    path: &Path,
    material: &Material,
    material_id: u32,
    default_radius: Option<f32>,
    first_id: u32,
) -> Result<ParticleFile, SceneError> {
    if let Some(kind) = points::kind_of_file(path) {
        let radius = default_radius;
        let wanted = points::PointsWanted {
            material: material_id,
            radius,
            first_id,
            earlier: 0,
            budget: None,
            share: None,
            classes: None,
        };
        return points::load(path, kind, wanted, &mut None).map(|cloud| cloud.file);
    }
    particles::load(path, material, material_id, default_radius, first_id, 0)
}

/// Reads a `.glb` or `.gltf` file, an OBJ or a PLY with faces, alone, at the start of its animation. World
/// space = `transform` * glTF space.
pub fn load_model(path: &Path, transform: Mat4) -> Result<Model, SceneError> {
    let (earlier, wanted) = (gltf::Earlier::default(), gltf::Wanted::default());
    let mut model = models::load(path, transform, &earlier, wanted)?;
    if let Some(rig) = &model.rig {
        let local = model.triangles.clone();
        let is_volume = |material: u32| model.materials[material as usize].is_volume();
        rig.pose(&local, &mut model.triangles, transform, 0.0, is_volume);
    }
    far_sides::Filters::add(&mut model.triangles, &model.materials, path)?;
    Ok(model)
}
