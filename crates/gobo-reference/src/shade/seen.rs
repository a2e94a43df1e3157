//! Casters visible to the camera, and the surfaces of their triangles at a hit.
use crate::{
    bin::Bins,
    caster_hit::Records,
    hit::{HitTriangle, TriangleHit},
    maps::{SceneRecords, ViewCasters, depth_order},
    project::ProjectParams,
};
use glam::{Vec2, Vec3};
use gobo::{
    model::{Casters, Material, ShadowSettings, TILE_SIZE},
    records::{
        Footprint, GpuView, ImageDetail, TRIANGLE_BIT, TriangleRecord, TriangleSetup,
        from_octahedral,
    },
};

/// Casters visible to the camera.
pub(super) struct Seen<'a> {
    pub(super) records: SceneRecords<'a>,
    pub(super) casters: ViewCasters,
    pub(super) bins: Bins,
    view: GpuView,
    detail: ImageDetail,
}

/// Diffuse transmission of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct FarSide {
    /// Scattered share of the light from the far side.
    pub(super) color: Vec3,
    /// Remaining share of the light on this side.
    pub(super) near: f32,
}

impl<'a> Seen<'a> {
    pub(super) fn new(
        casters: Casters<'a>,
        shadow: &ShadowSettings,
        view: &GpuView,
        detail: ImageDetail,
    ) -> Self {
        let records = SceneRecords::new(casters, shadow);
        // Only by distance are all bricks of a grid in order along each ray.
        let by_distance = !records.bricks.particles.is_empty();
        let params = ProjectParams { scatter: false, include_non_casters: true, by_distance };
        let casters = records.project(view, params);
        let tile_count = view.tiles_x * (view.size.y as u32).div_ceil(TILE_SIZE);
        let sorted = depth_order(&casters.keys);
        let bins = casters.bins(&sorted, view, tile_count, u32::MAX);
        Self { records, casters, bins, view: *view, detail }
    }

    pub(super) fn records(&self) -> Records<'_> {
        Records {
            view: &self.view,
            casters: &self.records.casters,
            bricks: &self.records.bricks,
            capsules: &self.records.capsules.records,
            axes: &self.records.axes,
            gaussians: &self.casters.gaussians,
            setups: &self.casters.setups,
            materials: self.records.materials,
            absorptions: &self.records.absorptions,
            images: &self.records.images,
            detail: Some(self.detail),
        }
    }

    /// Emission of the surface where the ray meets it.
    pub(super) fn emission(&self, material: &Material, setup: &TriangleSetup, pixel: Vec2) -> Vec3 {
        let texture = material.emissive_texture.zip(setup.hit(pixel));
        texture.map_or(material.emission, |(texture, met)| {
            let seen = self.records().seen_image(texture, setup, pixel, met.uv, true);
            material.emission * seen.rgba.truncate()
        })
    }

    /// Diffuse transmission of the surface where the ray meets it.
    pub(super) fn far_side(
        &self,
        material: &Material,
        footprint: &Footprint,
        pixel: Vec2,
    ) -> Option<FarSide> {
        let far = &self.records.materials[material.far_side? as usize];
        let setup = self.setup(footprint);
        let color = far.tint.truncate();
        let texture = far.texture.zip(setup.hit(pixel));
        let color = texture.map_or(color, |(texture, met)| {
            let seen = self.records().seen_image(texture, setup, pixel, met.uv, false);
            color * seen.rgba.truncate()
        });
        Some(FarSide { color, near: 1.0 - far.transmission })
    }

    /// Geometric and interpolated normal, both on the face's side that the eye sees. Near a silhouette the
    /// interpolated normal may point away from the eye; it stays on the face's side.
    pub(super) fn normals(
        &self,
        footprint: &Footprint,
        met: Option<TriangleHit>,
        to_eye: Vec3,
    ) -> [Vec3; 2] {
        let weights = met.map_or(Vec3::splat(1.0 / 3.0), |met| met.barycentric);
        let [a, b, c] = self.record(footprint).normals.map(from_octahedral);
        let normal = a * weights.x + b * weights.y + c * weights.z;
        let normal = normal / normal.length().max(1e-6);
        let face = toward(to_eye, from_octahedral(self.setup(footprint).normal));
        [face, toward(face, normal)]
    }

    /// A point of a facet, moved out to the round surface that the facet's normals approximate, so that no
    /// facet shadows itself where that surface still faces the light (Hanika 2021, "Hacking the shadow
    /// terminator", section 4.2). `face`: of the facet, on the eye's side.
    pub(super) fn rounded(
        &self,
        footprint: &Footprint,
        met: Option<TriangleHit>,
        face: Vec3,
        point: Vec3,
    ) -> Vec3 {
        let record = self.record(footprint);
        let is_flat = record.normals.iter().all(|&normal| normal == record.normals[0]);
        let Some(met) = met.filter(|_| !is_flat) else { return point };
        let out = |i: usize| {
            let normal = toward(face, from_octahedral(record.normals[i]));
            let below = normal.dot(record.positions_u[i].truncate() - point);
            normal * (met.barycentric[i] * below.max(0.0))
        };
        point + out(0) + out(1) + out(2)
    }

    pub(super) fn record(&self, footprint: &Footprint) -> &TriangleRecord {
        &self.records.triangles[(footprint.caster & !TRIANGLE_BIT) as usize]
    }

    pub(super) fn setup(&self, footprint: &Footprint) -> &TriangleSetup {
        &self.casters.setups[footprint.red_green as usize]
    }
}

fn toward(side: Vec3, normal: Vec3) -> Vec3 {
    if normal.dot(side) >= 0.0 { normal } else { -normal }
}
