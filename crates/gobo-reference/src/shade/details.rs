//! CPU reference of `crates/gobo-picture/wgsl/shade/details.wgsl`: what images say of an opaque surface texel
//! by texel.
use super::seen::Seen;
use crate::hit::HitTriangle;
use glam::{Vec2, Vec3};
use gobo::{
    model::Material,
    records::{Footprint, TriangleRecord, from_octahedral},
};

/// Properties of a surface that images give.
#[derive(Clone, Copy, Debug)]
pub(super) struct Details {
    /// Unit, on the eye's side of the face.
    pub(super) normal: Vec3,
    /// Share of the ambient light that gets there.
    pub(super) open: f32,
    pub(super) roughness: f32,
    pub(super) metallic: f32,
}

impl Seen<'_> {
    /// Properties that images give the surface where the ray meets it. `normal`: interpolated, on the eye's
    /// side.
    pub(super) fn details(
        &self,
        material: &Material,
        footprint: &Footprint,
        pixel: Vec2,
        normal: Vec3,
    ) -> Details {
        let Material { roughness, metallic, .. } = *material;
        let mut found = Details { normal, open: 1.0, roughness, metallic };
        let setup = self.setup(footprint);
        let Some((details, met)) = material.details.zip(setup.hit(pixel)) else { return found };
        let details = &self.records.materials[details as usize];
        let image = |texture: u32| {
            let seen = self.records().seen_image(texture, setup, pixel, met.uv, true);
            seen.rgba.truncate()
        };
        if let Some(texture) = details.texture {
            let [open, roughness, metallic] = image(texture).to_array();
            found = Details { normal, open, roughness, metallic };
        }
        if let Some(texture) = details.emissive_texture {
            let by = image(texture) * 2.0 - 1.0;
            found.normal = bent(self.record(footprint), met.barycentric, normal, by);
        }
        found
    }
}

/// The normal of an image in the frame of a triangle: along u, against v, and off the surface. The side that
/// is seen from behind has the same normals turned round.
fn bent(record: &TriangleRecord, barycentric: Vec3, normal: Vec3, by: Vec3) -> Vec3 {
    let [a, b, c] = record.positions_u;
    let (right, up) = (b - a, c - a);
    let rows = Vec2::new(record.v.y - record.v.x, record.v.z - record.v.x);
    let determinant = right.w * rows.y - up.w * rows.x;
    let mirrors = if determinant == 0.0 { 0.0 } else { determinant.signum() };
    let [first, second, third] = record.normals.map(from_octahedral);
    let front = first * barycentric.x + second * barycentric.y + third * barycentric.z;
    let side = if normal.dot(front) >= 0.0 { mirrors } else { -mirrors };
    let along = flat_axis((right * rows.y - up * rows.x).truncate() * side, normal);
    let against = flat_axis((right * up.w - up * right.w).truncate() * side, normal);
    let found = along * by.x + against * by.y + normal * by.z;
    let length = found.length();
    if length > 1e-6 { found / length } else { normal }
}

/// Part of an axis in the plane of a normal, unit; zero for none.
fn flat_axis(axis: Vec3, normal: Vec3) -> Vec3 {
    let unit = axis / axis.abs().max_element().max(1e-30);
    let flat = unit - normal * unit.dot(normal);
    flat / flat.length().max(1e-6)
}
