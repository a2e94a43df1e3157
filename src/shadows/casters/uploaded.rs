//! Copy of the uploaded data.
use crate::{
    model::{Material, Texture},
    records::{CasterRecord, TriangleRecord},
};
use std::hash::{DefaultHasher, Hash as _, Hasher as _};

/// Copy of the upload, to detect changes.
#[derive(Debug)]
pub(super) struct Uploaded {
    /// Indices into the scene's particles followed by its bricks, capsules and Gaussians, and into its
    /// triangles, in upload order.
    pub particle_order: Vec<u32>,
    pub triangle_order: Vec<u32>,
    /// Particles and Gaussians, then the ranks of the blue noise, the Gaussians' axes and the capsules.
    pub casters: Vec<CasterRecord>,
    pub triangles: Vec<TriangleRecord>,
    pub materials: Vec<Material>,
    /// Hashes of the textures.
    pub textures: Vec<u64>,
    /// Sizes of the textures \[texels\].
    pub texture_sizes: Vec<(u32, u32)>,
    pub blue_first: u32,
    /// Number of the scene's particles; larger indices belong to Gaussians.
    pub particle_count: usize,
    pub in_order: bool,
}

pub(super) fn hash(texture: &Texture) -> u64 {
    let mut hasher = DefaultHasher::new();
    (texture.width, texture.height, &texture.rgba).hash(&mut hasher);
    hasher.finish()
}
