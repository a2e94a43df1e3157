//! The subject of a file's own picture: objects on a ground that is far larger, and the front of what
//! is flat and upright.
use glam::Vec3;
use gobo::model::{Bounds, Scene, Triangle};
use std::collections::{BTreeMap, BTreeSet};

/// Largest height of a ground, and of its top above everything [widths of everything].
const GROUND_HEIGHT: f32 = 0.01;
/// Least width of a ground [widths of all that there is].
const GROUND_WIDTH: f32 = 0.5;
/// Largest extent of what stands on it [widths of all that there is].
const STANDING: f32 = 0.25;
/// Largest depth of what is flat, and least height [widths].
const FLAT: f32 = 0.15;
const UPRIGHT: f32 = 0.3;
/// Share of its area that looks to one side, from which on that is its front.
const ONE_SIDED: f32 = 0.2;
/// Share of a room's height that its floor and its ceiling are within, and share of its area that they cover.
const END: f32 = 0.05;
const COVERED: f32 = 0.5;
/// Angles at which depths are looked at, and corners that are.
const ANGLES: u32 = 36;
const MOST_CORNERS: usize = 20_000;

/// The subject of a picture.
pub(super) struct Subject<'a> {
    scene: &'a Scene,
    /// Ids of the triangles of grounds.
    grounds: BTreeSet<u32>,
    /// Bounds of all but grounds.
    pub(super) bounds: Bounds,
}

impl<'a> Subject<'a> {
    /// `contents`: a box around all that is to be seen.
    pub(super) fn new(scene: &'a Scene, contents: Bounds) -> Self {
        let whole = Self { scene, grounds: BTreeSet::new(), bounds: contents };
        let Scene { gaussians, emissions, grids, triangles, .. } = scene;
        if triangles.is_empty()
            || !(gaussians.is_empty() && emissions.is_empty() && grids.is_empty())
        {
            return whole;
        }
        let mut objects = BTreeMap::new();
        for triangle in triangles {
            let bounds = objects.entry(triangle.id).or_insert((Vec3::INFINITY, Vec3::NEG_INFINITY));
            *bounds = around(*bounds, triangle);
        }
        let size = contents.max - contents.min;
        let width = size.x.max(size.z);
        let is_ground = |(low, high): (Vec3, Vec3)| {
            let wide = (high - low).x.max((high - low).z) >= GROUND_WIDTH * width;
            wide && high.y <= contents.min.y + GROUND_HEIGHT * width
        };
        let ground = objects.iter().filter(|(_, bounds)| is_ground(**bounds));
        let grounds: BTreeSet<u32> = ground.map(|(id, _)| *id).collect();
        let mut rest = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for (low, high) in objects.iter().filter(|(id, _)| !grounds.contains(id)).map(|it| *it.1) {
            rest = (rest.0.min(low), rest.1.max(high));
        }
        for particle in &scene.particles {
            let reach = Vec3::splat(particle.radius);
            rest = (rest.0.min(particle.center - reach), rest.1.max(particle.center + reach));
        }
        let extent = (rest.1 - rest.0).max_element();
        if grounds.is_empty() || !(0.0..=STANDING * width).contains(&extent) {
            return whole;
        }
        Self { grounds, bounds: Bounds { min: rest.0, max: rest.1 }, ..whole }
    }

    /// Whether it stands on a ground of the file's own.
    pub(super) fn has_ground(&self) -> bool {
        !self.grounds.is_empty()
    }

    /// Its triangles.
    pub(super) fn triangles(&self) -> impl Iterator<Item = &'a Triangle> {
        let shown = |triangle: &&Triangle| !self.grounds.contains(&triangle.id);
        self.scene.triangles.iter().filter(shown)
    }

    /// Whether it is a room whose walls are single faces that look inward, with nothing but these to be seen
    /// from outside: most of the lowest twentieth looks up and most of the highest down, and little of that
    /// up.
    pub(super) fn is_room(&self) -> bool {
        let Bounds { min, max } = self.bounds;
        let size = max - min;
        let (low, high) = (min.y + END * size.y, max.y - END * size.y);
        let (mut floor, mut ceiling, mut roof) = (0.0, 0.0, 0.0);
        for triangle in self.triangles() {
            let [a, b, c] = triangle.positions;
            let upward = 0.5 * (b - a).cross(c - a).y;
            if triangle.positions.iter().all(|at| at.y <= low) {
                floor += upward.max(0.0);
            } else if triangle.positions.iter().all(|at| at.y >= high) {
                ceiling -= upward.min(0.0);
                roof += upward.max(0.0);
            }
        }
        let footprint = size.x * size.z;
        footprint > 0.0
            && floor.min(ceiling) >= COVERED * footprint
            && roof < ceiling * (1.0 - COVERED)
    }

    /// Level direction, unit, in which the front of what is flat and upright looks; `aside`: the side that is
    /// as good as the other.
    pub(super) fn front(&self, aside: Vec3) -> Option<Vec3> {
        let Scene { particles, gaussians, emissions, grids, strands, .. } = self.scene;
        let others =
            [particles.len(), gaussians.len(), emissions.len(), grids.len(), strands.len()];
        if others.iter().any(|&count| count > 0) {
            return None;
        }
        let step = 1 + 3 * self.triangles().count() / MOST_CORNERS;
        let corners: Vec<Vec3> =
            self.triangles().flat_map(|triangle| triangle.positions).step_by(step).collect();
        let along = |i: u32| {
            let (sine, cosine) = (std::f32::consts::PI * i as f32 / ANGLES as f32).sin_cos();
            Vec3::new(cosine, 0.0, sine)
        };
        let extent = |axis: Vec3| {
            let ends = corners.iter().map(|corner| corner.dot(axis));
            let ends = ends.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), at| {
                (low.min(at), high.max(at))
            });
            ends.1 - ends.0
        };
        let depths = (0..ANGLES).map(|i| (along(i), extent(along(i))));
        let (normal, depth) = depths.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let width = extent(normal.cross(Vec3::Y));
        let height = self.bounds.max.y - self.bounds.min.y;
        if !(depth <= FLAT * width && height >= UPRIGHT * width) {
            return None;
        }
        let (mut net, mut all) = (0.0, 0.0);
        for triangle in self.triangles() {
            let [a, b, c] = triangle.positions;
            let faces = (b - a).cross(c - a).dot(normal);
            net += faces;
            all += faces.abs();
        }
        let is_one_sided = net.abs() > ONE_SIDED * all;
        let looks = if is_one_sided { net } else { normal.dot(aside) };
        Some(if looks >= 0.0 { normal } else { -normal })
    }
}

fn around((low, high): (Vec3, Vec3), triangle: &Triangle) -> (Vec3, Vec3) {
    triangle.positions.iter().fold((low, high), |(low, high), at| (low.min(*at), high.max(*at)))
}
