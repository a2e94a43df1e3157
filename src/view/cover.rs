//! What a directional view must hold: all that casts, and as deep as what that may fall on.
use crate::model::{Bounds, ReceiverPoint, Scene, Triangle};
use glam::{Mat4, Vec2, Vec3};

/// What covers the texels of one scene.
pub(super) struct Cover<'a> {
    /// All casters and receivers.
    pub(super) all: Bounds,
    /// What casts; `all` where nothing does.
    pub(super) casters: Bounds,
    /// With triangles that cast nothing and bound no map: a ground as far as the horizon.
    scene: Option<&'a Scene>,
    /// Receivers beside the scene.
    points: &'a [ReceiverPoint],
}

impl<'a> Cover<'a> {
    pub(super) fn of_box(all: Bounds) -> Self {
        Self { all, casters: all, scene: None, points: &[] }
    }

    /// Air is lit all the way to the scene's end, so that with it maps are as deep as the scene.
    pub(super) fn of_scene(scene: &'a Scene) -> Self {
        let all = scene.bounds().or_unit();
        if scene.air.is_some() || scene.materials.iter().all(|material| material.casts) {
            return Self::of_box(all);
        }
        let casts = |material: u32| scene.materials[material as usize].casts;
        let particles = scene.particles.iter().filter(|p| casts(p.material));
        let casters = particles.fold(Bounds::EMPTY, |b, p| b.with_sphere(p.center, p.radius));
        let corners =
            scene.triangles.iter().filter(|t| casts(t.material)).flat_map(|t| t.positions);
        let casters = corners.fold(casters, |b, p| b.with_sphere(p, 0.0));
        if casters.is_empty() {
            Self::of_box(all)
        } else {
            Self { all, casters, scene: Some(scene), points: &[] }
        }
    }

    /// With further receivers.
    pub(super) fn around(self, points: &'a [ReceiverPoint]) -> Self {
        let all = points.iter().fold(self.all, |b, point| b.with_sphere(point.position, 0.0));
        Self { all, points, ..self }
    }

    /// The least z that a receiver has within a window of the view: a rectangle in its x and y.
    pub(super) fn deepest(&self, view_from_world: &Mat4, min: Vec2, max: Vec2) -> f32 {
        let inside = |p: &Vec3| p.truncate().cmpge(min).all() && p.truncate().cmple(max).all();
        let points =
            self.points.iter().map(|point| view_from_world.transform_point3(point.position));
        let points = points.filter(inside).map(|p| p.z).fold(f32::INFINITY, f32::min);
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
        particles.chain(triangles).fold(points, f32::min)
    }
}

/// Least z of the part of a triangle within a rectangle (Sutherland and Hodgman 1974).
fn deepest_within(triangle: &Triangle, view_from_world: &Mat4, min: Vec2, max: Vec2) -> f32 {
    let mut polygon: Vec<Vec3> =
        triangle.positions.iter().map(|&p| view_from_world.transform_point3(p)).collect();
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
