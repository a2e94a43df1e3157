//! Points of strands.
use super::{
    super::shading::{Coat, Gloss, Point, PointKind, Receiver},
    Eye,
};
use glam::{UVec2, Vec3};
use gobo::{
    model::Material,
    records::{CapsuleRecord, CasterRecord},
};

impl Eye<'_> {
    /// Point of a translucent capsule: its middle, with the axis in place of the normal.
    pub(super) fn strand(
        &self,
        caster: &CasterRecord,
        record: &CapsuleRecord,
        material: &Material,
    ) -> Point {
        Point {
            kind: PointKind::Strand,
            position: caster.center,
            pixel: UVec2::ZERO,
            face: Vec3::ZERO,
            normal: (record.last - record.first).normalize_or_zero(),
            to_eye: (self.position() - caster.center).normalize_or_zero(),
            // It does not shadow itself.
            reach: record.first_radius.max(record.last_radius),
            receiver: Receiver::new(material, record.id),
            albedo: Vec3::ONE,
            roughness: material.roughness,
            gloss: Gloss::SOLID,
            emission: Vec3::ZERO,
            metallic: 0.0,
            far: Vec3::ZERO,
            coat: Coat::NONE,
        }
    }

    /// Normal of an opaque capsule where the ray meets it, as of a cylinder, and its radius there.
    pub(super) fn strand_surface(
        record: &CapsuleRecord,
        position: Vec3,
        to_eye: Vec3,
    ) -> (Vec3, f32) {
        let axis = (record.last - record.first).normalize_or_zero();
        let off = position - record.first;
        let aside = off - axis * off.dot(axis);
        (aside.try_normalize().unwrap_or(to_eye), aside.length())
    }
}
