//! Rays that meet a scene's triangles.
use glam::{Vec3, Vec3A};
use gobo::model::{Material, Triangle};
use obvhs::{
    bvh2::Bvh2,
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision},
    ray::{Ray, RayHit},
    triangle::Triangle as Facet,
};

/// Most triangles that are met; of more, every other, third ... one is.
const MOST: usize = 300_000;

/// Triangles in a hierarchy of boxes.
pub(super) struct Rays<'a> {
    triangles: Vec<&'a Triangle>,
    facets: Vec<Facet>,
    tree: Bvh2,
    /// Share of the triangles that are met: one of so many.
    step: usize,
}

/// The first triangle on a ray.
#[derive(Clone, Copy)]
pub(super) struct Met<'a> {
    pub(super) triangle: &'a Triangle,
    pub(super) place: Vec3,
    /// Unit normal of its front.
    pub(super) normal: Vec3,
    /// From the start of the ray \[lengths of its direction\].
    pub(super) distance: f32,
    /// Whether the ray meets its front.
    pub(super) is_front: bool,
}

impl<'a> Rays<'a> {
    /// `triangles`: all but those that light passes.
    pub(super) fn new(
        triangles: impl Iterator<Item = &'a Triangle> + Clone,
        materials: &[Material],
    ) -> Self {
        let is_shown = |it: &&Triangle| {
            let material = &materials[it.material as usize];
            material.visible && material.transfer.is_opaque()
        };
        let shown = triangles.filter(is_shown);
        let step = 1 + shown.clone().count() / MOST;
        let triangles: Vec<_> = shown.step_by(step).collect();
        let facet = |triangle: &&Triangle| {
            let [v0, v1, v2] = triangle.positions.map(Vec3A::from);
            Facet { v0, v1, v2 }
        };
        let facets: Vec<Facet> = triangles.iter().map(facet).collect();
        let indices = (0..facets.len() as u32).collect();
        let (search, precision) = (PlocSearchDistance::Minimum, SortPrecision::U64);
        let tree =
            PlocBuilder::with_capacity(facets.len()).build(search, &facets, indices, precision, 0);
        Self { triangles, facets, tree, step }
    }

    /// Whether all triangles are met.
    pub(super) fn is_whole(&self) -> bool {
        self.step == 1
    }

    /// The first triangle from `from` in direction `along`, which is finite and not zero.
    pub(super) fn first(&self, from: Vec3, along: Vec3) -> Option<Met<'a>> {
        let ray = Ray::new_inf(from.into(), along.into());
        let mut hit = RayHit::none();
        let index = |number: usize| self.tree.primitive_indices[number] as usize;
        self.tree
            .ray_traverse(ray, &mut hit, |ray, number| self.facets[index(number)].intersect(ray));
        if !hit.t.is_finite() {
            return None;
        }
        let triangle = self.triangles[index(hit.primitive_id as usize)];
        let [a, b, c] = triangle.positions;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let (place, is_front) = (from + along * hit.t, normal.dot(along) < 0.0);
        Some(Met { triangle, place, normal, distance: hit.t, is_front })
    }
}
