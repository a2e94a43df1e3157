//! Triangles as uploaded, and their setups for one view.
use super::pack::octahedral;
use crate::model::{Triangle, VertexColor};
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3, Vec4};

/// Texels of a [`TriangleSetup`].
pub const SETUP_TEXELS: u32 = 8;
/// Texels of a [`TriangleRecord`].
pub const TRIANGLE_TEXELS: u32 = 6;
/// Flag of [`TriangleSetup::ties`]: the triangle is clockwise as seen from the light.
pub const BACK_BIT: u32 = 8;

crate::records::texel_struct! {
    /// A triangle of the scene as kernels read it.
    pub struct TriangleRecord {
        /// Three world-space positions \[m\], each followed by the vertex's u.
        pub positions_u: [Vec4; 3],
        pub v: Vec3,
        /// Index of the material.
        pub material: u32,
        /// Octahedral normals, snorm16 pairs.
        pub normals: [u32; 3],
        /// Id, from which owner tags and dithering follow.
        pub id: u32,
        /// [`VertexColor`](crate::model::VertexColor) of the corners.
        pub colors: [u32; 3],
        /// Not read.
        pub pad: u32,
    }
}

impl TriangleRecord {
    /// The record of a triangle.
    pub fn new(triangle: &Triangle) -> Self {
        let [a, b, c] = triangle.uvs;
        Self {
            positions_u: std::array::from_fn(|i| triangle.positions[i].extend(triangle.uvs[i].x)),
            v: Vec3::new(a.y, b.y, c.y),
            material: triangle.material,
            normals: triangle.normals.map(octahedral),
            id: triangle.id,
            colors: triangle.colors.map(VertexColor::bits),
            pad: 0,
        }
    }
}

/// Triangle setup for a view's hit test, in texel space.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct TriangleSetup {
    /// A point of the edge's line and the edge's direction: `x, y, dx, dy` \[texels\]. The edge
    /// function is `dx (py - y) - dy (px - x)`; the inside is where all three are >= 0.
    pub edges: [Vec4; 3],
    /// Factors that turn edge values into perspective-correct weights.
    pub weights: Vec3,
    /// Bit i: a texel centre exactly on edge i belongs to this triangle (fill rule). [`BACK_BIT`]: the
    /// triangle faces away from the light.
    pub ties: u32,
    /// Light depths of the corners.
    pub depths: Vec3,
    /// Index of the material.
    pub material: u32,
    /// Texture coordinates of the corners.
    pub uvs: [Vec2; 3],
    /// World-space face normal, octahedral.
    pub normal: u32,
    /// Id, from which owner tags and dithering follow.
    pub id: u32,
    /// Colours of the corners as in [`TriangleRecord`].
    pub colors: [u32; 3],
    /// Not read.
    pub pad: u32,
}
