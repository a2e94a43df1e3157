//! Extent of a directional view: all casters, and depths that include their receivers.
use super::Receivers;
use crate::model::{Bounds, Gaussian, Grid, Scene, Strand, Triangle, emission::Emission};
use glam::{Mat4, Vec2, Vec3};

/// Casters and receivers that a directional view covers.
pub(super) struct Cover<'a> {
    /// Bounds of all casters and receivers.
    pub(super) all: Bounds,
    /// Bounds of the casters; `all` if there are none.
    pub(super) casters: Bounds,
    /// The scene, if it has triangles that cast no shadow and so do not enlarge the map: a ground up to the
    /// horizon.
    scene: Option<&'a Scene>,
    /// Receivers in addition to the scene.
    receivers: Option<&'a Receivers>,
}

impl<'a> Cover<'a> {
    pub(super) fn of_box(all: Bounds) -> Self {
        Self { all, casters: all, scene: None, receivers: None }
    }

    /// With air, the maps are as deep as the scene, because light is scattered up to its end.
    pub(super) fn of_scene(scene: &'a Scene) -> Self {
        let all = scene.held_bounds().or_unit();
        if scene.air.is_some() || scene.materials.iter().all(|material| material.casts) {
            return Self::of_box(all);
        }
        let casts = |material: u32| scene.materials[material as usize].casts;
        let particles = scene.particles.iter().filter(|p| casts(p.material));
        let casters =
            particles.fold(scene.held_casters(), |b, p| b.with_sphere(p.center, p.radius));
        let bounds = |g: &Gaussian| g.bounds(scene.materials[g.material as usize].gaussian);
        let gaussians = scene.gaussians.iter().filter(|g| casts(g.material));
        let casters = gaussians.fold(casters, |b, g| b.with(&bounds(g)));
        let emissions = scene.emissions.iter().filter(|e| casts(e.emitter.material));
        let casters = emissions.fold(casters, |b, e| b.with(&e.bounds()));
        let grids = scene.grids.iter().filter(|grid| casts(grid.material));
        let casters = grids.fold(casters, |b, grid| b.with(&grid.bounds()));
        let strands = scene.strands.iter().filter(|strand| casts(strand.material));
        let casters = strands.fold(casters, |b, strand| b.with(&strand.bounds()));
        let corners =
            scene.triangles.iter().filter(|t| casts(t.material)).flat_map(|t| t.positions);
        let casters = corners.fold(casters, |b, p| b.with_sphere(p, 0.0));
        if casters.is_empty() {
            Self::of_box(all)
        } else {
            Self { all, casters, scene: Some(scene), receivers: None }
        }
    }

    /// The cover with additional receivers.
    pub(super) fn around(self, receivers: &'a Receivers) -> Self {
        let all = receivers.boxes().fold(self.all, Bounds::with);
        Self { all, receivers: Some(receivers), ..self }
    }

    /// Least view-space z of a receiver within a window of the view: a rectangle in x and y.
    pub(super) fn deepest(&self, view_from_world: &Mat4, min: Vec2, max: Vec2) -> f32 {
        let of_box = |bounds: &Bounds| deepest_of_box(bounds, view_from_world, min, max);
        let boxes = self.receivers.iter().flat_map(|receivers| receivers.boxes());
        let points = boxes.map(of_box).fold(f32::INFINITY, f32::min);
        let Some(scene) = self.scene else { return points };
        let casts = |material: u32| scene.materials[material as usize].casts;
        let particles = scene.particles.iter().filter(|p| !casts(p.material)).map(|p| {
            let center = view_from_world.transform_point3(p.center);
            let is_inside = center.truncate().cmpge(min - p.radius).all()
                && center.truncate().cmple(max + p.radius).all();
            if is_inside { center.z - p.radius } else { f32::INFINITY }
        });
        let triangles = scene.triangles.iter().filter(|t| !casts(t.material));
        let triangles = triangles.map(|t| deepest_within(t, view_from_world, min, max));
        let emissions = scene.emissions.iter().filter(|e| !casts(e.emitter.material));
        let grids = scene.grids.iter().filter(|grid| !casts(grid.material)).map(Grid::bounds);
        let strands = scene.strands.iter().filter(|strand| !casts(strand.material));
        let boxes = emissions.map(Emission::bounds).chain(grids).chain(strands.map(Strand::bounds));
        let bounds = |g: &Gaussian| g.bounds(scene.materials[g.material as usize].gaussian);
        let gaussians = scene.gaussians.iter().filter(|g| !casts(g.material)).map(bounds);
        let boxes = boxes.chain(gaussians).filter(|bounds| !bounds.is_empty());
        let boxes = boxes.map(|bounds| of_box(&bounds));
        particles.chain(triangles).chain(boxes).fold(points, f32::min)
    }
}

/// Least z of a box that touches a rectangle; infinite for a box that does not.
fn deepest_of_box(bounds: &Bounds, view_from_world: &Mat4, min: Vec2, max: Vec2) -> f32 {
    let corners = bounds.corners().map(|corner| view_from_world.transform_point3(corner));
    let seen = corners.iter().fold(Bounds::EMPTY, |all, &corner| all.with_sphere(corner, 0.0));
    let is_inside = seen.max.truncate().cmpge(min).all() && seen.min.truncate().cmple(max).all();
    if is_inside { seen.min.z } else { f32::INFINITY }
}

/// Least z of the part of a triangle within a rectangle (Sutherland and Hodgman 1974).
fn deepest_within(triangle: &Triangle, view_from_world: &Mat4, min: Vec2, max: Vec2) -> f32 {
    let corners = triangle.positions.map(|p| view_from_world.transform_point3(p));
    let (low, high) =
        (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
    let (low, high) = (low.truncate(), high.truncate());
    if low.cmpgt(max).any() || high.cmplt(min).any() {
        return f32::INFINITY;
    }
    if low.cmpge(min).all() && high.cmple(max).all() {
        return corners.iter().map(|p| p.z).fold(f32::INFINITY, f32::min);
    }
    let mut polygon = corners.to_vec();
    let sides: [(usize, f32, f32); 4] =
        [(0, 1.0, min.x), (0, -1.0, -max.x), (1, 1.0, min.y), (1, -1.0, -max.y)];
    for (axis, sign, least) in sides {
        let inside = |p: &Vec3| sign * p[axis] - least;
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (i, &a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            let (in_a, in_b) = (inside(&a), inside(&b));
            if in_a >= 0.0 {
                kept.push(a);
            }
            if (in_a >= 0.0) != (in_b >= 0.0) {
                kept.push(a.lerp(b, in_a / (in_a - in_b)));
            }
        }
        polygon = kept;
    }
    polygon.iter().map(|p| p.z).fold(f32::INFINITY, f32::min)
}
