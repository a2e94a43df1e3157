//! CPU reference of `wgsl/hit/brick.wgsl`: the part of a ray inside a brick of voxels, and its optical depth;
//! and of `wgsl/project/extent.wgsl`.
use super::brick_light::{Lattice, Thirds};
use super::curve::taken::Taken;
use glam::{BVec3, Mat3, UVec3, Vec2, Vec3, Vec3Swizzles as _, Vec4Swizzles as _};
use gobo::{
    model::{BRICK_SIZE, Voxels},
    records::{BrickRecord, Bricks, GpuView, GridRecord},
};

/// Offset of the two Gauss points from the middle of a ray's stretch in a cell, in lengths of the stretch: `1
/// / sqrt(12)`.
pub const GAUSS: f32 = 0.288_675_13;
/// Ramps of a curve for a brick with voxels of its own.
pub const VOXEL_PARTS: u32 = 3;
/// Least step along an axis, so that no ray is parallel to a face \[voxels\].
pub const LEAST_WAY: f32 = 1e-20;

/// Equal parts of a ray's path through a box of constant density; in a dense grid each has its own light.
pub const EVEN_PARTS: u32 = 25;
/// Last cell of a brick along an axis.
const LAST_CELL: f32 = (BRICK_SIZE - 1) as f32;

/// Tolerance of right angles between a brick's edges, as a share.
pub const SQUARE: f32 = 1e-4;
/// Rounding of the least distance of a right-angled brick, as a share of the distances that it is computed
/// from. Small, so that neighbours stay in order if the eye is close to the plane of their common face.
pub const DISTANCE_ROUNDING: f32 = 4e-6;

/// The part of a ray inside a brick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage {
    /// Distance along the axis at which density begins \[m\].
    pub first: f32,
    /// Start and end of the curve's ramp along the axis \[m\].
    pub ramp: [f32; 2],
    /// Optical depth, per channel.
    pub tau: Vec3,
    /// Absorption in each third of the path.
    pub thirds: Thirds,
}

/// A ray in the grid's index space, from its anchor.
struct IndexRay {
    start: Vec3,
    /// Step per metre along the axis.
    way: Vec3,
    /// Length per metre along the axis.
    metres: f32,
}

impl IndexRay {
    fn new(view: &GpuView, grid: &GridRecord, texel: Vec2) -> Self {
        let slope = (texel - view.size * 0.5) / view.scale;
        let aside = Vec3::new(slope.x, -slope.y, 0.0);
        let anchor = Vec3::from_array(grid.rows.map(|row| row.w));
        let anchor = view.view_from_world.transform_point3(anchor);
        let (start, along) = if view.perspective == 0.0 {
            (aside - anchor, Vec3::NEG_Z)
        } else {
            (-anchor, aside + Vec3::NEG_Z)
        };
        let world_from_view = Mat3::from_mat4(view.view_from_world).transpose();
        let index = |v: Vec3| {
            let v = world_from_view * v;
            Vec3::from_array(grid.rows.map(|row| row.xyz().dot(v)))
        };
        Self { start: index(start), way: never_parallel(index(along)), metres: along.length() }
    }

    /// A ray from a point in world space \[m\]; `toward`: its step per metre.
    fn from_point(grid: &GridRecord, point: Vec3, toward: Vec3) -> Self {
        let anchor = Vec3::from_array(grid.rows.map(|row| row.w));
        let index = |v: Vec3| Vec3::from_array(grid.rows.map(|row| row.xyz().dot(v)));
        Self { start: index(point - anchor), way: never_parallel(index(toward)), metres: 1.0 }
    }

    /// Distances along the axis at which the ray meets the planes through `corner` \[m\].
    fn meets(&self, corner: Vec3) -> Vec3 {
        (corner - self.start) * self.way.recip()
    }

    /// The part of the path inside a box, between two depths \[m\].
    fn within(
        &self,
        [low, high]: [Vec3; 2],
        [near, end]: [f32; 2],
        [part, count]: [u32; 2],
    ) -> Option<[f32; 2]> {
        let (at_low, at_high) = (self.meets(low), self.meets(high));
        let first = at_low.min(at_high).max_element().max(near);
        let last = at_low.max(at_high).min_element().min(end);
        if last.is_nan() || first.is_nan() || first >= last {
            return None;
        }
        if count <= 1 {
            return Some([first, last]);
        }
        let length = (last - first) / count as f32;
        let to = first + length * (part + 1) as f32;
        Some([first + length * part as f32, if part + 1 == count { last } else { to }])
    }
}

fn never_parallel(way: Vec3) -> Vec3 {
    Vec3::select(way.abs().cmplt(Vec3::splat(LEAST_WAY)), Vec3::splat(LEAST_WAY), way)
}

/// A ray's path in one cell of voxels, or in one part of a box of constant density.
struct Stretch {
    /// Start and end along the axis \[m\].
    ends: [f32; 2],
    /// Densities at the two Gauss points.
    densities: [f32; 2],
}

impl Stretch {
    /// Stretches of a ray between two depths in a brick, in order.
    fn all<'a>(
        bricks: &'a Bricks,
        brick: &'a BrickRecord,
        ray: &'a IndexRay,
        [first, last]: [f32; 2],
    ) -> impl Iterator<Item = Self> + 'a {
        let voxels = (brick.density < 0.0).then(|| bricks.voxels_of(brick));
        let low = brick.origin.as_vec3();
        let high = low + brick.size();
        let rises: BVec3 = ray.way.cmpgt(Vec3::ZERO);
        let ahead = Vec3::select(rises, Vec3::ONE, Vec3::ZERO);
        let step = Vec3::select(rises, Vec3::ONE, Vec3::NEG_ONE);
        let mut cell = (ray.start + ray.way * first).floor().clamp(low, high - 1.0);
        let mut t = first;
        let mut part = 0;
        std::iter::from_fn(move || {
            if t >= last {
                return None;
            }
            let Some(voxels) = voxels else {
                part += 1;
                let next = mix(first, last, part as f32 / EVEN_PARTS as f32);
                let next = if part == EVEN_PARTS { last } else { next };
                let ends = [std::mem::replace(&mut t, next), next];
                return Some(Self { ends, densities: [brick.density; 2] });
            };
            let faces = ray.meets(cell + ahead);
            let next = faces.min_element().min(last).max(t);
            let middle = ray.start + ray.way * (0.5 * (t + next)) - cell;
            let apart = ray.way * (GAUSS * (next - t));
            let corner = (cell - low).as_uvec3();
            let density = |at: Vec3| trilinear(voxels, corner, at.clamp(Vec3::ZERO, Vec3::ONE));
            let densities = [middle - apart, middle + apart].map(density);
            let crossed = faces.cmple(Vec3::splat(next));
            cell = Vec3::select(crossed, (cell + step).clamp(low, high - 1.0), cell);
            let ends = [std::mem::replace(&mut t, next), next];
            Some(Self { ends, densities })
        })
    }
}

/// `end`: of the ray, along the axis \[m\]; `part`: index and number of equal parts of the path through the
/// brick. `None` where there is no density.
pub(super) fn passage(
    view: &GpuView,
    bricks: &Bricks,
    brick: &BrickRecord,
    texel: Vec2,
    end: f32,
    part: [u32; 2],
) -> Option<Passage> {
    let grid = bricks.grid(brick);
    let ray = IndexRay::new(view, &grid, texel);
    let low = brick.origin.as_vec3();
    let high = low + brick.size();
    let [first, last] = ray.within([low, high], [view.near, end], part)?;
    let along_box = [first, last].map(|along| (ray.start + ray.way * along - low) / brick.size());
    let of_density = Vec3::from_array(grid.edges.map(|edge| edge.w)) * ray.metres;
    if brick.density >= 0.0 {
        let tau = brick.density * (last - first) * of_density;
        let thirds = Thirds { ends: along_box, depths: [tau / 3.0; 3] };
        let ramp = [first, last];
        return (tau.max_element() > 0.0).then_some(Passage { first, ramp, tau, thirds });
    }
    let (mut begins, mut ends, mut depth) = (last, first, 0.0);
    // Place where light is lost, in the mean of the channels.
    let dim = -of_density.element_sum() / 3.0;
    let (mut light, mut taken) = (1.0, Taken::from(first));
    let at_third = [1.0, 2.0].map(|number| mix(first, last, number / 3.0));
    let mut before_third = [0.0; 2];
    for Stretch { ends: [t, next], densities: [a, b] } in
        Stretch::all(bricks, brick, &ray, [first, last])
    {
        let within = (a + b) * (0.5 * (next - t));
        depth += within;
        for (sum, at) in before_third.iter_mut().zip(at_third) {
            *sum += within * ((at - t) / (next - t).max(LEAST_WAY)).clamp(0.0, 1.0);
        }
        if within > 0.0 {
            (begins, ends) = (begins.min(t), next);
        }
        let behind = (depth * dim).exp();
        taken.add_even([t, next], light - behind);
        light = behind;
    }
    let tau = depth * of_density;
    let ramp = taken.fitted(begins, ends);
    let [one, two] = before_third;
    let depths = [one, two - one, depth - two].map(|within| within.max(0.0) * of_density);
    let thirds = Thirds { ends: along_box, depths };
    (tau.max_element() > 0.0).then_some(Passage { first: begins, ramp, tau, thirds })
}

/// Mean light scattered by a ray's path in a brick of a dense grid, weighted by absorption, cell by cell:
/// light is read at the place of a cell's mean absorption. `end` as in [`passage`].
pub(super) fn dense_light(
    view: &GpuView,
    bricks: &Bricks,
    brick: &BrickRecord,
    texel: Vec2,
    end: f32,
    lattice: &Lattice,
) -> Vec3 {
    let grid = bricks.grid(brick);
    let ray = IndexRay::new(view, &grid, texel);
    let (low, size) = (brick.origin.as_vec3(), brick.size());
    let Some(ends) = ray.within([low, low + size], [view.near, end], [0, 1]) else {
        return Vec3::ZERO;
    };
    let extinction = Vec3::from_array(grid.edges.map(|edge| edge.w));
    let mean = extinction.element_sum() / 3.0;
    let (mut left, mut all, mut sum) = (Vec3::ONE, Vec3::ZERO, Vec3::ZERO);
    for Stretch { ends: [t, next], densities } in Stretch::all(bricks, brick, &ray, ends) {
        let [a, b] = densities.map(|density| density * (0.5 * (next - t)) * ray.metres);
        let passed = (-extinction * (a + b)).map(f32::exp);
        let absorbed = left * (1.0 - passed);
        let before = 1.0 - (-mean * a).exp();
        let behind = (1.0 - before) * (1.0 - (-mean * b).exp());
        let off = GAUSS * (behind - before) / (before + behind).max(1e-20);
        let at = 0.5 * (t + next) + off * (next - t);
        sum += absorbed * lattice.at((ray.start + ray.way * at - low) / size);
        all += absorbed;
        left *= passed;
    }
    sum / all.max(Vec3::splat(1e-20))
}

/// From a point in a brick towards a light at distance `end` \[m\]: the point at which the path leaves the
/// brick, world space \[m\], and the transmittance up to there.
pub(super) fn own_shadow(
    bricks: &Bricks,
    brick: &BrickRecord,
    point: Vec3,
    toward: Vec3,
    end: f32,
) -> (Vec3, Vec3) {
    let grid = bricks.grid(brick);
    let ray = IndexRay::from_point(&grid, point, toward);
    let low = brick.origin.as_vec3();
    let Some(ends) = ray.within([low, low + brick.size()], [0.0, end], [0, 1]) else {
        return (point, Vec3::ONE);
    };
    let within = |part: Stretch| {
        let ([t, next], [a, b]) = (part.ends, part.densities);
        (a + b) * (0.5 * (next - t))
    };
    let depth: f32 = Stretch::all(bricks, brick, &ray, ends).map(within).sum();
    let extinction = Vec3::from_array(grid.edges.map(|edge| edge.w));
    (point + toward * ends[1], (-extinction * depth).map(f32::exp))
}

/// Value of voxels at a position of 0..=8.
pub(super) fn voxel_value(voxels: &Voxels, at: Vec3) -> f32 {
    let corner = at.floor().min(Vec3::splat(LAST_CELL));
    trilinear(voxels, corner.as_uvec3(), at - corner)
}

/// Density at a position in the cell whose first voxel is `corner`.
fn trilinear(voxels: &Voxels, corner: UVec3, at: Vec3) -> f32 {
    let value = |x: u32, y: u32, z: u32| voxels.at(corner + UVec3::new(x, y, z));
    let along_x = |y, z| mix(value(0, y, z), value(1, y, z), at.x);
    let along_y = |z| mix(along_x(0, z), along_x(1, z), at.y);
    mix(along_y(0), along_y(1), at.z)
}

fn mix(a: f32, b: f32, part: f32) -> f32 {
    a + (b - a) * part
}

/// Extent of a brick's box in a view. WGSL: `wgsl/project/extent.wgsl`.
pub(super) struct BrickExtent {
    /// Box in the map \[texels\].
    pub min: Vec2,
    pub max: Vec2,
    /// Along the axis \[m\].
    pub along: [f32; 2],
    /// Upper bound of its nearest point's distance from the origin of view space \[m\].
    pub least: f32,
}

impl BrickExtent {
    /// `half_edges`: of the box, world space \[m\]; `center`: of the box, view space \[m\].
    pub(super) fn new(view: &GpuView, half_edges: &[Vec3; 3], center: Vec3) -> Self {
        let [x, y, z] = half_edges.map(|edge| view.view_from_world.transform_vector3(edge));
        let reach = x.z.abs() + y.z.abs() + z.z.abs();
        let (mut min, mut max) = (Vec2::splat(1e30), Vec2::splat(-1e30));
        for i in 0..8 {
            let sign = |bit: u32| if i & bit == 0 { -1.0 } else { 1.0 };
            let corner = center + x * sign(1) + y * sign(2) + z * sign(4);
            let per_metre = if view.perspective > 0.0 { 1.0 / -corner.z } else { 1.0 };
            let texel = Vec2::new(corner.x, -corner.y) * view.scale * per_metre + view.size * 0.5;
            (min, max) = (min.min(texel), max.max(texel));
        }
        let lengths = Vec3::new(x.length(), y.length(), z.length());
        let skews = Vec3::new(x.dot(y), y.dot(z), z.dot(x)).abs() / (lengths * lengths.yzx());
        let skew = skews.max_element();
        let away = center.length();
        let least = if skew < SQUARE {
            let beside = Vec3::new(center.dot(x), center.dot(y), center.dot(z)).abs() / lengths;
            (beside - lengths).max(Vec3::ZERO).length()
        } else {
            away - (x.abs() + y.abs() + z.abs()).length()
        };
        let rounding = (skew.min(SQUARE) + DISTANCE_ROUNDING) * (away + lengths.element_sum());
        let along = [-center.z - reach, -center.z + reach];
        Self { min, max, along, least: (least - rounding).max(0.0) }
    }
}
