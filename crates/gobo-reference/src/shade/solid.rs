//! Points of the nearest opaque surfaces.
use super::{
    super::shading::{Coat, Gloss, Point, PointKind, Receiver},
    Eye, Seen,
    details::Details,
    is_solid, seen_color,
};
use crate::{
    caster_hit::{Hit, Target},
    coplanar::is_in_front,
    hit::HitTriangle,
    mask::SeenSurface,
    tile::{Tile, TileTexels},
};
use glam::{Vec2, Vec3};
use gobo::{
    model::{Material, Shape},
    records::{Footprint, TRIANGLE_BIT},
};

/// The first opaque caster on a pixel's ray.
#[derive(Clone, Copy)]
pub(super) struct NearestCaster<'a> {
    pub(super) footprint: &'a Footprint,
    pub(super) material: &'a Material,
    pub(super) hit: Hit,
    /// Id of its object, if it is a triangle.
    pub(super) object: Option<u32>,
}

impl Eye<'_> {
    /// Nearest opaque caster of each pixel.
    pub(super) fn nearest<'a>(
        &self,
        solid: &'a Seen<'_>,
        index: usize,
        tile: &Tile,
    ) -> TileTexels<Option<NearestCaster<'a>>> {
        let mut nearest = TileTexels::filled(None::<NearestCaster<'a>>);
        for pair in solid.bins.tile(index) {
            let footprint = &solid.casters.footprints[pair.footprint as usize];
            let target = Target::new(solid.records(), footprint);
            let material = target.material;
            let object = (footprint.caster & TRIANGLE_BIT != 0).then_some(target.id);
            for (in_tile, pixel) in target.texels(tile) {
                let before = nearest[in_tile];
                let before = before.map_or((1.0, None), |it| (it.hit.depth, it.object));
                if let Some(hit) = target.hit(pixel, 1.0)
                    && is_solid(material, &hit)
                    && hit.depth < 1.0
                    && is_in_front((hit.depth, object), before)
                {
                    nearest[in_tile] = Some(NearestCaster { footprint, material, hit, object });
                }
            }
        }
        nearest
    }

    /// Their points.
    pub(super) fn solid_points(
        &self,
        solid: &Seen<'_>,
        index: usize,
        tile: &Tile,
    ) -> TileTexels<SeenSurface> {
        let nearest = self.nearest(solid, index, tile);
        let mut points = TileTexels::filled(SeenSurface { object: None, depth: 1.0, point: None });
        for (in_tile, pixel) in tile.texels() {
            if let Some(nearest) = nearest[in_tile] {
                let point = Some(self.solid_point(solid, &nearest, pixel));
                let object = nearest.object;
                points[in_tile] = SeenSurface { object, depth: nearest.hit.depth, point };
            }
        }
        points
    }

    pub(super) fn solid_point(
        &self,
        solid: &Seen<'_>,
        nearest: &NearestCaster<'_>,
        pixel: Vec2,
    ) -> Point {
        let point = self.plain_point(solid, nearest, pixel);
        if nearest.material.catcher { self.lighting.caught(&point) } else { point }
    }

    /// The point, with its own albedo even if it shows the surroundings behind it.
    fn plain_point(&self, solid: &Seen<'_>, nearest: &NearestCaster<'_>, pixel: Vec2) -> Point {
        let NearestCaster { footprint, material, hit, .. } = nearest;
        if footprint.caster & TRIANGLE_BIT != 0 {
            let facet = self.triangle(solid, footprint, material, hit, pixel);
            let Point { albedo, to_eye, face, .. } = facet;
            let details = solid.details(material, footprint, pixel, facet.normal);
            let Details { normal, open, roughness, metallic, coat } = details;
            let facet = Point { normal, roughness, ..facet };
            let surface = (roughness, metallic);
            let around = open * self.lighting.mirrored_around(surface, albedo, normal, to_eye);
            let met = solid.setup(footprint).hit(pixel);
            let position = solid.rounded(footprint, met, face, facet.position);
            if material.unlit {
                let emission = facet.emission + albedo;
                let gloss = Gloss { reflectivity: 0.0, polish: 0.0 };
                return Point { position, albedo: Vec3::ZERO, gloss, emission, ..facet };
            }
            if let Some(far) = solid.far_side(material, footprint, pixel) {
                let mut leaf = Point {
                    kind: PointKind::Leaf,
                    albedo: albedo * far.near,
                    far: far.color,
                    emission: facet.emission + around,
                    metallic,
                    ..facet
                };
                leaf.emission += self.lighting.ambient_behind(&leaf);
                leaf.emission -= (1.0 - open) * self.lighting.ambient_of(&leaf);
                return leaf;
            }
            let mut point = Point {
                position,
                to_eye: (self.position() - position).normalize(),
                emission: facet.emission + around,
                metallic,
                coat,
                ..facet
            };
            let reflected = (-to_eye).reflect(coat.normal);
            let over = open * self.lighting.radiance_around(reflected, coat.roughness);
            point.emission = point.emission.lerp(over, coat.mirrored(to_eye));
            point.emission -= (1.0 - open) * self.lighting.ambient_of(&point);
            return point;
        }
        let caster = &solid.records.casters[footprint.caster as usize];
        let position = self.point(pixel, hit.depth);
        let to_eye = (self.position() - position).normalize();
        let (normal, reach, id) = if material.shape == Shape::Capsule {
            let record = &solid.records.capsules.records[caster.id as usize];
            let (normal, reach) = Self::strand_surface(record, position, to_eye);
            (normal, reach, record.id)
        } else {
            // Normal of the sphere impostor.
            let aside = (position - caster.center) / caster.radius;
            let out = (1.0 - aside.length_squared()).max(0.05).sqrt();
            ((aside + to_eye * out).normalize(), caster.radius, caster.id)
        };
        let albedo = (caster.color(material.transfer as u32) * material.tint).truncate();
        let surface = (material.roughness, material.metallic);
        let around = self.lighting.mirrored_around(surface, albedo, normal, to_eye);
        Point {
            kind: PointKind::Solid,
            position,
            pixel: pixel.as_uvec2(),
            face: normal,
            normal,
            to_eye,
            reach,
            receiver: Receiver::new(material, id).at_pixel(pixel.as_uvec2()),
            albedo,
            roughness: material.roughness,
            gloss: Gloss::SOLID,
            emission: material.emission + around,
            metallic: material.metallic,
            far: Vec3::ZERO,
            coat: Coat::NONE,
        }
    }

    /// Point of an opaque triangle without mirroring.
    pub(super) fn triangle(
        &self,
        seen: &Seen<'_>,
        footprint: &Footprint,
        material: &Material,
        hit: &Hit,
        pixel: Vec2,
    ) -> Point {
        let setup = seen.setup(footprint);
        let position = self.point(pixel, hit.depth);
        let to_eye = (self.position() - position).normalize();
        let record = seen.record(footprint);
        let met = setup.hit(pixel);
        let [face, normal] = seen.normals(footprint, met, to_eye);
        Point {
            kind: PointKind::Solid,
            position,
            pixel: pixel.as_uvec2(),
            face,
            normal,
            to_eye,
            reach: 0.0,
            receiver: Receiver::new(material, record.id).at_pixel(pixel.as_uvec2()),
            albedo: seen_color(hit, material),
            roughness: material.roughness,
            gloss: Gloss::SOLID,
            emission: seen.emission(material, setup, pixel),
            metallic: 0.0,
            far: Vec3::ZERO,
            coat: Coat::NONE,
        }
    }
}
