//! The subject of a file's own picture: objects on a ground that is far larger, and the front of what
//! is flat and upright.
use glam::Vec3;
use gobo::model::{Bounds, Scene, Triangle};
use std::collections::HashMap;

/// Largest height of a ground, and of its top above everything [widths of everything].
const GROUND_HEIGHT: f32 = 0.01;
/// Least width of a ground [widths of all that there is].
const GROUND_WIDTH: f32 = 0.5;
/// Least width of a piece of a ground [widths of all that there is], and largest height [its widths].
const PIECE: f32 = 0.02;
const FLAT_PIECE: f32 = 0.1;
/// Largest extent of what stands on it [widths of all that there is].
const STANDING: f32 = 0.25;
/// Largest depth of what is flat, and least height [widths].
const FLAT: f32 = 0.15;
const UPRIGHT: f32 = 0.3;
/// Share of its area that looks to one side, from which on that is its front.
const ONE_SIDED: f32 = 0.2;
/// Angles at which depths are looked at, those above and below the level [degrees], and corners that are.
const ANGLES: u32 = 36;
const TILTS: [f32; 5] = [0.0, -12.0, 12.0, -24.0, 24.0];
const MOST_CORNERS: usize = 20_000;

/// The subject of a picture.
pub(super) struct Subject<'a> {
    pub(super) scene: &'a Scene,
    /// Whether a triangle is of a ground; empty without one.
    grounds: Vec<bool>,
    /// Bounds of all but grounds.
    pub(super) bounds: Bounds,
}

impl<'a> Subject<'a> {
    /// `contents`: a box around all that is to be seen.
    pub(super) fn new(scene: &'a Scene, contents: Bounds) -> Self {
        let whole = Self { scene, grounds: Vec::new(), bounds: contents };
        let Scene { gaussians, emissions, grids, triangles, .. } = scene;
        if triangles.is_empty()
            || !(gaussians.is_empty() && emissions.is_empty() && grids.is_empty())
        {
            return whole;
        }
        let size = contents.max - contents.min;
        let width = size.x.max(size.z);
        if size.y > (STANDING + GROUND_HEIGHT) * width {
            return whole;
        }
        let parts = parts(triangles);
        let mut boxes = vec![(Vec3::INFINITY, Vec3::NEG_INFINITY); triangles.len()];
        for (triangle, part) in triangles.iter().zip(&parts) {
            let bounds = &mut boxes[*part as usize];
            *bounds = around(*bounds, triangle);
        }
        let lies = |(low, high): (Vec3, Vec3)| {
            let own = high - low;
            let wide = own.x.max(own.z);
            high.y <= contents.min.y + GROUND_HEIGHT * width
                && own.y <= FLAT_PIECE * wide
                && wide >= PIECE * width
        };
        // Parts without triangles are empty boxes, whose sides are minus infinity.
        let pieces = boxes.iter().filter(|bounds| lies(**bounds)).map(|(low, high)| *high - *low);
        let covered: f32 = pieces.clone().map(|own| own.x * own.z).sum();
        let is_wide = |own: Vec3| own.x.max(own.z) >= GROUND_WIDTH * width;
        if !pieces.clone().any(is_wide) && covered < GROUND_WIDTH * size.x * size.z {
            return whole;
        }
        let grounds: Vec<bool> = parts.iter().map(|part| lies(boxes[*part as usize])).collect();
        let mut rest = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for triangle in triangles.iter().zip(&grounds).filter(|it| !it.1).map(|it| it.0) {
            rest = around(rest, triangle);
        }
        for particle in &scene.particles {
            let reach = Vec3::splat(particle.radius);
            rest = (rest.0.min(particle.center - reach), rest.1.max(particle.center + reach));
        }
        let extent = (rest.1 - rest.0).max_element();
        if !(0.0..=STANDING * width).contains(&extent) {
            return whole;
        }
        Self { grounds, bounds: Bounds { min: rest.0, max: rest.1 }, ..whole }
    }

    /// Whether it stands on a ground of the file's own.
    pub(super) fn has_ground(&self) -> bool {
        !self.grounds.is_empty()
    }

    /// Its triangles.
    pub(super) fn triangles(&self) -> impl Iterator<Item = &'a Triangle> + Clone {
        let is_ground = |number: usize| self.grounds.get(number).is_some_and(|ground| *ground);
        let all = self.scene.triangles.iter().enumerate();
        all.filter(move |(number, _)| !is_ground(*number)).map(|(_, triangle)| triangle)
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
        let along = |i: u32, tilt: f32| {
            let (sine, cosine) = (std::f32::consts::PI * i as f32 / ANGLES as f32).sin_cos();
            let (rise, level) = tilt.to_radians().sin_cos();
            Vec3::new(cosine * level, rise, sine * level)
        };
        let extent = |axis: Vec3| {
            let ends = corners.iter().map(|corner| corner.dot(axis));
            let ends = ends.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), at| {
                (low.min(at), high.max(at))
            });
            ends.1 - ends.0
        };
        let axes = TILTS.into_iter().flat_map(|tilt| (0..ANGLES).map(move |i| along(i, tilt)));
        let depths = axes.map(|axis| (axis, extent(axis)));
        let (normal, depth) = depths.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let width = extent(normal.cross(Vec3::Y).normalize());
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
        let level = normal.with_y(0.0).normalize();
        Some(if looks >= 0.0 { level } else { -level })
    }
}

/// Whether all that there is is one surface that looks up: a cloth, on which nothing stands.
pub(super) fn is_sheet(triangles: &[Triangle]) -> bool {
    let (mut up, mut down) = (0.0, 0.0);
    for triangle in triangles {
        let [a, b, c] = triangle.positions;
        let upward = (b - a).cross(c - a).y;
        (up, down) = (up + upward.max(0.0), down - upward.min(0.0));
    }
    down < 0.05 * up && parts(triangles).iter().all(|part| *part == 0)
}

/// Number of the part of each triangle, that of its first triangle: parts share no corners.
fn parts(triangles: &[Triangle]) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..triangles.len() as u32).collect();
    let root = |parents: &mut Vec<u32>, mut part: u32| {
        while parents[part as usize] != part {
            let above = parents[parents[part as usize] as usize];
            parents[part as usize] = above;
            part = above;
        }
        part
    };
    let mut corners = HashMap::with_capacity(triangles.len());
    for (number, triangle) in (0..).zip(triangles) {
        for corner in triangle.positions {
            // Both zeros are one.
            let place = (corner + Vec3::ZERO).to_array().map(f32::to_bits);
            let other = *corners.entry(place).or_insert(number);
            let [first, second] = [other, number].map(|part| root(&mut parents, part));
            parents[first.max(second) as usize] = first.min(second);
        }
    }
    (0..triangles.len() as u32).map(|part| root(&mut parents, part)).collect()
}

fn around((low, high): (Vec3, Vec3), triangle: &Triangle) -> (Vec3, Vec3) {
    triangle.positions.iter().fold((low, high), |(low, high), at| (low.min(*at), high.max(*at)))
}
