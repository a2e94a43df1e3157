//! CPU reference of `wgsl/hit/brick_light.wgsl` and `crates/gobo-picture/wgsl/shade/shade_casters.wgsl`:
//! light that a brick sends along a ray to the eye.
use glam::{UVec3, Vec2, Vec3};
use gobo::records::{BrickRecord, Bricks, GpuView};

/// Parts of a ray's path through a brick; density is taken as even in each.
pub const THIRDS: u32 = 3;
/// Optical depth below which a series is more precise.
pub const SERIES: f32 = 0.02;

/// Light at a lattice of points over a brick's box, faces included.
#[derive(Clone, Debug)]
pub struct Lattice {
    /// Points along an edge.
    pub edge: u32,
    /// Light at the points, x first.
    pub light: Vec<Vec3>,
}

impl Lattice {
    /// Trilinear interpolation between the points; `place`: in the box, 0..1.
    pub(super) fn at(&self, place: Vec3) -> Vec3 {
        let last = (self.edge - 1) as f32;
        let at = place.clamp(Vec3::ZERO, Vec3::ONE) * last;
        let low = at.floor().min(Vec3::splat(last - 1.0));
        let aside = at - low;
        let point = |x, y, z| {
            let [x, y, z] = (low.as_uvec3() + UVec3::new(x, y, z)).to_array();
            self.light[((z * self.edge + y) * self.edge + x) as usize]
        };
        let along_x = |y, z| point(0, y, z).lerp(point(1, y, z), aside.x);
        let along_y = |z| along_x(0, z).lerp(along_x(1, z), aside.y);
        along_y(0).lerp(along_y(1), aside.z)
    }
}

/// Absorption in each third of a ray's path through a brick, with even density in each third.
#[derive(Clone, Copy, Debug)]
pub(super) struct Thirds {
    /// Points at which the ray enters and leaves the box, 0..1.
    pub ends: [Vec3; 2],
    /// Optical depths.
    pub depths: [Vec3; THIRDS as usize],
}

impl Thirds {
    /// Mean light along the path, weighted by absorption.
    pub(super) fn light(&self, lattice: &Lattice) -> Vec3 {
        let at = |part| lattice.at(self.ends[0].lerp(self.ends[1], part));
        let (mut left, mut all, mut sum) = (Vec3::ONE, Vec3::ZERO, Vec3::ZERO);
        let mut before = at(0.0);
        for (tau, end) in self.depths.into_iter().zip([1.0, 2.0, 3.0]) {
            let behind = at(end / THIRDS as f32);
            let passed = (-tau).map(f32::exp);
            let absorbed = left * (1.0 - passed);
            all += absorbed;
            sum += absorbed * (before + (behind - before) * tau.map(mean_way));
            left *= passed;
            before = behind;
        }
        sum / all.max(Vec3::splat(1e-20))
    }
}

/// Mean distance at which light is absorbed on a path of even density and optical depth `tau`, in lengths of
/// the path.
fn mean_way(tau: f32) -> f32 {
    if tau < SERIES { 0.5 - tau / 12.0 } else { 1.0 / tau - 1.0 / (tau.min(80.0).exp() - 1.0) }
}

/// Points of a brick's lattice: positions in the box, 0..1, and in world space \[m\]; `None` where the camera
/// does not see the brick.
pub(super) fn points_of(
    bricks: &Bricks,
    brick: &BrickRecord,
    view: &GpuView,
) -> Option<Vec<(Vec3, Vec3)>> {
    let grid = bricks.grid(brick);
    let (low, size) = (brick.origin.as_vec3(), brick.size());
    let edges = grid.edges.map(glam::Vec4::truncate);
    let anchor = Vec3::from_array(grid.rows.map(|row| row.w));
    let world = |at: Vec3| anchor + edges[0] * at.x + edges[1] * at.y + edges[2] * at.z;
    let lengths = Vec3::from_array(edges.map(Vec3::length));
    let radius = 0.5 * (lengths * size).element_sum();
    let center = view.view_from_world.transform_point3(world(low + size * 0.5));
    let slope = view.size * 0.5 / view.scale;
    let beyond = Vec2::new(center.x, center.y).abs() + center.z * slope;
    let aside = beyond.cmple(radius * (1.0 + slope * slope).map(f32::sqrt)).all();
    let is_seen = aside && -center.z + radius >= view.near && -center.z - radius <= view.far;
    let edge = grid.lattice_edge;
    let point = |i: u32| {
        let cell = UVec3::new(i % edge, i / edge % edge, i / (edge * edge));
        let place = cell.as_vec3() / (edge - 1) as f32;
        (place, world(low + size * place))
    };
    is_seen.then(|| (0..grid.lattice_points()).map(point).collect())
}
