//! Edges of shadows in 64 bits: rays through pixels and to lights, tested against a scene's triangles. No
//! map, no filter.
use gobo::{
    glam::{DVec2, DVec3, Vec3},
    model::{Camera, LightKind, Transfer},
};
use gobo_scene::Scene;

/// Cells a side of the grid of triangles that a ray may hit.
const CELLS: usize = 192;

/// Origin of rays: a point, or a direction.
#[derive(Clone, Copy)]
enum From {
    Point(DVec3),
    /// Direction in which they travel, unit.
    Far(DVec3),
}

#[derive(Clone, Copy)]
struct Corners {
    corners: [DVec3; 3],
    /// Normal, unit.
    normal: DVec3,
    /// Transmittance; 0 for an opaque one.
    passes: DVec3,
}

/// Triangles by their position for rays from one place.
struct Rays {
    from: From,
    axes: [DVec3; 3],
    low: DVec2,
    high: DVec2,
    cells: Vec<Vec<u32>>,
    /// Triangles partly behind the place.
    around: Vec<u32>,
}

impl Rays {
    fn new(from: From, along: DVec3, triangles: &[Corners]) -> Self {
        let up = if along.y.abs() > 0.99 { DVec3::Z } else { DVec3::Y };
        let right = along.cross(up).normalize();
        let axes = [right, right.cross(along), along];
        let (low, high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut rays = Self { from, axes, low, high, cells: Vec::new(), around: Vec::new() };
        let boxes: Vec<_> = triangles.iter().map(|triangle| rays.seen(triangle)).collect();
        for &(low, high) in boxes.iter().flatten() {
            (rays.low, rays.high) = (rays.low.min(low), rays.high.max(high));
        }
        if matches!(from, From::Point(_)) {
            (rays.low, rays.high) =
                (rays.low.max(DVec2::splat(-3.0)), rays.high.min(DVec2::splat(3.0)));
        }
        rays.cells = vec![Vec::new(); CELLS * CELLS];
        for (index, seen) in (0..).zip(boxes) {
            let Some((low, high)) = seen else {
                rays.around.push(index);
                continue;
            };
            let ([x0, y0], [x1, y1]) = (rays.cell(low), rays.cell(high));
            for y in y0..=y1 {
                (x0..=x1).for_each(|x| rays.cells[y * CELLS + x].push(index));
            }
        }
        rays
    }

    fn place(&self, point: DVec3) -> Option<DVec2> {
        let [right, up, along] = self.axes;
        let flat = |p: DVec3| DVec2::new(p.dot(right), p.dot(up));
        match self.from {
            From::Far(_) => Some(flat(point)),
            From::Point(eye) => {
                let away = point - eye;
                let depth = away.dot(along);
                (depth > 1e-6).then(|| flat(away) / depth)
            }
        }
    }

    fn seen(&self, triangle: &Corners) -> Option<(DVec2, DVec2)> {
        let mut both = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corner in triangle.corners {
            let place = self.place(corner)?;
            both = (both.0.min(place), both.1.max(place));
        }
        Some(both)
    }

    fn cell(&self, place: DVec2) -> [usize; 2] {
        let share = (place - self.low) / (self.high - self.low) * CELLS as f64;
        share.to_array().map(|x| (x.max(0.0) as usize).min(CELLS - 1))
    }

    /// Triangles that the ray through a point may hit.
    fn near(&self, point: DVec3) -> impl Iterator<Item = usize> {
        let cell = self.place(point).map(|place| {
            let [x, y] = self.cell(place);
            &self.cells[y * CELLS + x]
        });
        cell.into_iter().flatten().chain(&self.around).map(|&index| index as usize)
    }
}

/// Distance along `way` from `start` to a triangle (Möller and Trumbore 1997).
fn meets(triangle: &Corners, start: DVec3, way: DVec3) -> Option<f64> {
    let [a, b, c] = triangle.corners;
    let (ab, ac) = (b - a, c - a);
    let p = way.cross(ac);
    let scale = ab.dot(p);
    if scale.abs() < 1e-18 {
        return None;
    }
    let s = start - a;
    let q = s.cross(ab);
    let (u, v) = (s.dot(p) / scale, way.dot(q) / scale);
    (u >= 0.0 && v >= 0.0 && u + v < 1.0).then(|| ac.dot(q) / scale)
}

/// A plane visible to the camera.
#[derive(Clone, Copy)]
pub(crate) struct Plane {
    at: DVec3,
    /// Normal towards the light, unit.
    pub normal: DVec3,
}

/// An edge of a shadow on a plane, at a point of the picture [pixels].
pub(crate) struct Edge {
    pub at: DVec2,
    /// Direction across it, from `before` to `behind`, unit.
    pub across: DVec2,
    pub plane: Plane,
    /// Light on both sides.
    pub before: DVec3,
    pub behind: DVec3,
}

/// A scene under its first light.
pub(crate) struct Truth<'a> {
    camera: &'a Camera,
    light: LightKind,
    triangles: Vec<Corners>,
    eye: Rays,
    lamp: Rays,
}

/// Pixels on each side of an edge that must be free of other edges.
pub(crate) const CLEAR: f64 = 3.0;
/// Least cosine of the light on a measured surface.
const MIN_COSINE: f64 = 0.15;

impl<'a> Truth<'a> {
    pub(crate) fn new(scene: &'a Scene) -> Self {
        let corners = |triangle: &gobo::Triangle| {
            let corners = triangle.positions.map(Vec3::as_dvec3);
            let material = &scene.materials[triangle.material as usize];
            let tint = material.tint.as_dvec4();
            let passes = match material.transfer {
                _ if !material.casts => DVec3::ONE,
                Transfer::Opaque => DVec3::ZERO,
                _ => DVec3::ONE - tint.w * (DVec3::ONE - tint.truncate()),
            };
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            Corners { corners, normal: normal.normalize_or_zero(), passes }
        };
        let triangles: Vec<_> = scene.triangles.iter().map(corners).collect();
        let camera = &scene.camera;
        let along = (camera.target - camera.eye).as_dvec3().normalize();
        let eye = Rays::new(From::Point(camera.eye.as_dvec3()), along, &triangles);
        let light = scene.lights[0].kind.with_unit_direction();
        let (from, along) = match light {
            LightKind::Directional { direction } => (From::Far(direction.into()), direction),
            LightKind::Spot { position, direction, .. } => {
                (From::Point(position.into()), direction)
            }
            LightKind::Point { .. } => panic!("a point light has no truth here"),
        };
        let lamp = Rays::new(from, along.as_dvec3(), &triangles);
        Self { camera, light, triangles, eye, lamp }
    }

    fn ray(&self, pixel: DVec2) -> DVec3 {
        let size = self.camera.size.as_dvec2();
        let [right, up, along] = self.eye.axes;
        let slope = (f64::from(self.camera.fov_y) * 0.5).tan() / (size.y * 0.5);
        let off = (pixel - size * 0.5) * slope;
        along + right * off.x - up * off.y
    }

    /// The solid surface at a pixel, if light may fall on it.
    fn plane(&self, pixel: DVec2) -> Option<Plane> {
        let (eye, way) = (self.camera.eye.as_dvec3(), self.ray(pixel));
        let hits = self
            .eye
            .near(eye + way)
            .filter_map(|i| Some((meets(&self.triangles[i], eye, way)?, i)));
        let (distance, index) =
            hits.filter(|&(d, _)| d > 0.0).min_by(|a, b| a.0.total_cmp(&b.0))?;
        let triangle = &self.triangles[index];
        let at = eye + way * distance;
        let toward = self.toward(at);
        let normal = triangle.normal * triangle.normal.dot(way).signum() * -1.0;
        (triangle.passes == DVec3::ZERO || triangle.passes == DVec3::ONE)
            .then_some(Plane { at, normal })
            .filter(|_| normal.dot(toward) > MIN_COSINE)
    }

    /// Point of a plane at a pixel.
    pub(crate) fn point(&self, plane: Plane, pixel: DVec2) -> DVec3 {
        let (eye, way) = (self.camera.eye.as_dvec3(), self.ray(pixel));
        eye + way * ((plane.at - eye).dot(plane.normal) / way.dot(plane.normal))
    }

    fn toward(&self, point: DVec3) -> DVec3 {
        match self.lamp.from {
            From::Far(along) => -along,
            From::Point(from) => (from - point).normalize(),
        }
    }

    /// Light at a pixel of a plane; `None` outside a spot's cone.
    fn light(&self, plane: Plane, pixel: DVec2) -> Option<DVec3> {
        let point = self.point(plane, pixel);
        let toward = self.toward(point);
        if let LightKind::Spot { direction, angle, .. } = self.light
            && -toward.dot(direction.as_dvec3()) < (f64::from(angle) * 0.49).cos()
        {
            return None;
        }
        let end = match self.lamp.from {
            From::Far(_) => f64::INFINITY,
            From::Point(from) => from.distance(point),
        };
        let mut light = DVec3::ONE;
        for index in self.lamp.near(point) {
            let triangle = &self.triangles[index];
            let distance = meets(triangle, point, toward);
            if distance.is_some_and(|distance| distance > 1e-4 && distance < end) {
                light *= triangle.passes;
            }
        }
        Some(light)
    }

    /// Position at which light changes between two pixels of a plane [share of the distance].
    fn change(&self, plane: Plane, ends: [DVec2; 2], lights: [DVec3; 2]) -> Option<DVec2> {
        let [mut first, mut last] = ends;
        for _ in 0..12 {
            let middle = (first + last) * 0.5;
            let light = self.light(plane, middle)?;
            match lights.map(|end| end.distance(light) < 1e-9) {
                [true, _] => first = middle,
                [_, true] => last = middle,
                _ => return None,
            }
        }
        Some((first + last) * 0.5)
    }

    /// The edge between two neighbouring pixels, if it is straight and isolated.
    fn edge(&self, pixel: DVec2, step: DVec2) -> Option<Edge> {
        let plane = self.plane(pixel)?;
        let lights = [self.light(plane, pixel)?, self.light(plane, pixel + step)?];
        if (lights[1] - lights[0]).abs().max_element() < 0.2 {
            return None;
        }
        let at = self.change(plane, [pixel, pixel + step], lights)?;
        let aside = DVec2::new(-step.y, step.x) * 0.75;
        let crossing = |aside: DVec2| {
            let ends = [pixel - step + aside, pixel + step * 2.0 + aside];
            self.change(plane, ends, lights)
        };
        let along = crossing(aside)? - crossing(-aside)?;
        let across = DVec2::new(along.y, -along.x).normalize();
        let across = across * across.dot(step).signum();
        for side in [-CLEAR, -0.5 * CLEAR, -0.15, 0.15, 0.5 * CLEAR, CLEAR] {
            let place = at + across * side;
            let level = lights[usize::from(side > 0.0)];
            let seen = self.plane(place)?;
            let is_plane = (seen.at - plane.at).dot(plane.normal).abs() < 1e-4
                && seen.normal.dot(plane.normal) > 0.99999;
            if !is_plane || self.light(plane, place)?.distance(level) > 1e-9 {
                return None;
            }
        }
        Some(Edge { at, across, plane, before: lights[0], behind: lights[1] })
    }

    /// Edges of shadows in the picture, at every `stride`th pixel.
    pub(crate) fn edges(&self, stride: u32) -> Vec<Edge> {
        let size = self.camera.size;
        let mut edges = Vec::new();
        for y in (4..size.y - 4).step_by(stride as usize) {
            for x in 4..size.x - 4 {
                let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                edges.extend(
                    self.edge(pixel, DVec2::X)
                        .filter(|edge| edge.across.x.abs() >= edge.across.y.abs()),
                );
            }
        }
        for x in (4..size.x - 4).step_by(stride as usize) {
            for y in 4..size.y - 4 {
                let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                edges.extend(
                    self.edge(pixel, DVec2::Y)
                        .filter(|edge| edge.across.y.abs() > edge.across.x.abs()),
                );
            }
        }
        edges
    }
}
