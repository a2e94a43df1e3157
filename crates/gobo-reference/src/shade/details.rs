//! CPU reference of `crates/gobo-picture/wgsl/shade/details.wgsl`: what images say of an opaque surface texel
//! by texel.
use super::{super::shading::Coat, seen::Seen};
use crate::hit::{HitTriangle, TriangleHit};
use glam::{Vec2, Vec3};
use gobo::{
    model::Material,
    records::{Footprint, TriangleRecord, TriangleSetup, from_octahedral},
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
    pub(super) coat: Coat,
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
        let mut found = Details { normal, open: 1.0, roughness, metallic, coat: Coat::NONE };
        let setup = self.setup(footprint);
        let Some((details, met)) = material.details.zip(setup.hit(pixel)) else { return found };
        let details = &self.records.materials[details as usize];
        let image = |texture: u32| self.data_of(texture, setup, pixel, met);
        let bent_by = |texture: Option<u32>| {
            let by = texture.map(|texture| image(texture) * 2.0 - 1.0);
            by.map_or(normal, |by| bent(self.record(footprint), met.barycentric, normal, by))
        };
        if let Some(texture) = details.texture {
            [found.open, found.roughness, found.metallic] = image(texture).to_array();
        }
        found.normal = bent_by(details.emissive_texture);
        if let Some(coat) = details.details {
            let coat = &self.records.materials[coat as usize];
            let mut shares = [coat.reflectivity, coat.roughness];
            if let Some(texture) = coat.texture {
                let rgb = image(texture);
                shares = [rgb.x, rgb.y];
            }
            let [share, roughness] = shares;
            found.coat = Coat { share, roughness, normal: bent_by(coat.emissive_texture) };
        }
        found
    }

    /// Numbers that an image gives where the ray meets a triangle.
    fn data_of(&self, texture: u32, setup: &TriangleSetup, pixel: Vec2, met: TriangleHit) -> Vec3 {
        self.records().seen_image(texture, setup, pixel, met.uv, true).rgba.truncate()
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
