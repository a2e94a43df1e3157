//! Points of strands.
use super::{
    super::shading::{Gloss, Point, PointKind, Receiver},
    Eye, Seen,
};
use crate::{
    model::Material,
    records::{CapsuleRecord, Caster},
};
use glam::{UVec2, Vec2, Vec3};

impl Eye<'_> {
    /// Point of a translucent capsule: its middle, with its axis as normal.
    pub(super) fn strand(
        &self,
        caster: &Caster,
        record: &CapsuleRecord,
        material: &Material,
    ) -> Point {
        Point {
            kind: PointKind::Strand,
            position: caster.center,
            pixel: UVec2::ZERO,
            face: Vec3::ZERO,
            normal: (record.last - record.first).normalize_or_zero(),
            to_eye: (self.position() - caster.center).normalize(),
            // Not shadowed by itself.
            reach: record.first_radius.max(record.last_radius),
            receiver: Receiver::new(material, record.id),
            albedo: Vec3::ONE,
            roughness: material.roughness,
            gloss: Gloss::SOLID,
            emission: Vec3::ZERO,
            metallic: 0.0,
        }
    }

    /// Point of an opaque capsule where the ray meets it: with the normal of a cylinder.
    pub(super) fn solid_strand(
        &self,
        solid: &Seen<'_>,
        caster: &Caster,
        material: &Material,
        position: Vec3,
        pixel: Vec2,
    ) -> Point {
        let record = &solid.records.capsules.records[caster.id as usize];
        let to_eye = (self.position() - position).normalize();
        let axis = (record.last - record.first).normalize_or_zero();
        let off = position - record.first;
        let aside = off - axis * off.dot(axis);
        let normal = aside.try_normalize().unwrap_or(to_eye);
        let albedo = (caster.color() * material.tint).truncate();
        let around = self.lighting.mirrored_around(material, albedo, normal, to_eye);
        Point {
            kind: PointKind::Solid,
            position,
            pixel: pixel.as_uvec2(),
            face: normal,
            normal,
            to_eye,
            reach: aside.length(),
            receiver: Receiver::new(material, record.id).at_pixel(pixel.as_uvec2()),
            albedo,
            roughness: material.roughness,
            gloss: Gloss::SOLID,
            emission: material.emission + around,
            metallic: material.metallic,
        }
    }
}
