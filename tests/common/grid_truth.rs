//! Integrals of a grid's trilinear density along lines, in 64 bits and by definition: a line is cut at every
//! plane through voxels, and Simpson's rule, which is exact for cubics, sums each part.
use gobo::{
    glam::{DAffine3, DMat3, DVec3, UVec3, Vec3A},
    model::{Brick, Density, Grid},
};

/// Optical depth, as a share of the brick's, below which rounding decides whether there is any density.
const SURE: f64 = 1e-4;
/// Distance to a face below which rounding decides the side [voxels].
const TIED: f64 = 1e-5;

pub(crate) struct Line {
    pub(crate) start: DVec3,
    pub(crate) way: DVec3,
}

pub(crate) struct Inside {
    /// Integral of density along the line [m].
    pub(crate) integral: f64,
    /// Start of the first cell with density, in ways.
    pub(crate) begins: f64,
    /// Start of certain density, in ways.
    pub(crate) begins_surely: f64,
    /// How much earlier it may begin, as rounding decides which cell a line along a face is in, in ways.
    pub(crate) sooner: f64,
}

pub(crate) fn index_from_world(grid: &Grid) -> DAffine3 {
    let linear = grid.world_from_index.matrix3;
    let columns = [linear.x_axis, linear.y_axis, linear.z_axis].map(Vec3A::as_dvec3);
    let world_from_index = DAffine3 {
        matrix3: DMat3::from_cols(columns[0], columns[1], columns[2]),
        translation: grid.world_from_index.translation.as_dvec3(),
    };
    world_from_index.inverse()
}

pub(crate) fn constant_size(brick: &Brick) -> Option<DVec3> {
    match brick.density {
        Density::Constant { size, .. } => Some(size.as_dvec3()),
        Density::Voxels(_) => None,
    }
}

/// Density of a brick at a position in index space, relative to its lowest voxel.
fn density(brick: &Brick, cell: DVec3, place: DVec3) -> f64 {
    let voxels = match &brick.density {
        Density::Voxels(voxels) => voxels,
        Density::Constant { density, .. } => return f64::from(*density),
    };
    let mut sum = 0.0;
    for i in 0..8 {
        let corner = UVec3::new(i & 1, i >> 1 & 1, i >> 2);
        let part = place - cell;
        let weight = |axis: usize| if corner[axis] == 1 { part[axis] } else { 1.0 - part[axis] };
        let value = f64::from(voxels.at(cell.as_uvec3() + corner));
        sum += weight(0) * weight(1) * weight(2) * value;
    }
    sum
}

impl Line {
    /// Range of ways in which the line is in a box of index space.
    fn clipped(
        &self,
        start: DVec3,
        way: DVec3,
        low: DVec3,
        high: DVec3,
        ways: [f64; 2],
    ) -> [f64; 2] {
        let [mut from, mut to] = ways;
        for axis in 0..3 {
            let [a, b] = [low[axis], high[axis]].map(|plane| (plane - start[axis]) / way[axis]);
            if way[axis] != 0.0 {
                (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
            } else if start[axis] < low[axis] || start[axis] >= high[axis] {
                to = from;
            }
        }
        [from, to]
    }

    /// Length inside a box of `size` voxels, enlarged by `grow` on all sides [m].
    pub(crate) fn chord(
        &self,
        grid: &Grid,
        origin: DVec3,
        size: DVec3,
        grow: f64,
        ways: [f64; 2],
    ) -> f64 {
        let index = index_from_world(grid);
        let (start, way) = (index.transform_point3(self.start), index.transform_vector3(self.way));
        let linear = grid.world_from_index.matrix3;
        let edges =
            [linear.x_axis, linear.y_axis, linear.z_axis].map(|axis| f64::from(axis.length()));
        let more = grow / DVec3::from_array(edges);
        let [from, to] = self.clipped(start, way, origin - more, origin + size + more, ways);
        (to - from).max(0.0) * self.way.length()
    }

    /// Stretches of the line in cells of a brick, in ways, and the integral of density along each [m].
    fn parts(&self, grid: &Grid, brick: &Brick, ways: [f64; 2]) -> Vec<([f64; 2], f64)> {
        let index = index_from_world(grid);
        let start = index.transform_point3(self.start) - brick.origin.as_dvec3();
        let way = index.transform_vector3(self.way);
        let size = brick.size().as_dvec3();
        let [from, to] = self.clipped(start, way, DVec3::ZERO, size, ways);
        if from >= to {
            return Vec::new();
        }
        let mut cuts = vec![from, to];
        if constant_size(brick).is_none() {
            for axis in (0..3).filter(|&axis| way[axis] != 0.0) {
                let planes = (1..8).map(|plane| (f64::from(plane) - start[axis]) / way[axis]);
                cuts.extend(planes.filter(|&cut| cut > from && cut < to));
            }
            cuts.sort_by(f64::total_cmp);
        }
        let part = |cut: &[f64]| {
            let at = |part: f64| start + way * (cut[0] + (cut[1] - cut[0]) * part);
            // A line along the last face belongs to the cells before it.
            let cell = at(0.5).floor().clamp(DVec3::ZERO, DVec3::splat(7.0));
            let value = |part: f64| density(brick, cell, at(part));
            let mean = (value(0.0) + 4.0 * value(0.5) + value(1.0)) / 6.0;
            ([cut[0], cut[1]], mean * (cut[1] - cut[0]) * self.way.length())
        };
        cuts.windows(2).map(part).collect()
    }

    /// Integral of a brick's density between two positions, in ways.
    pub(crate) fn integral(&self, grid: &Grid, brick: &Brick, ways: [f64; 2]) -> Option<Inside> {
        let parts = self.parts(grid, brick, ways);
        let integral: f64 = parts.iter().map(|part| part.1).sum();
        let after = |share: f64| {
            let mut sum = 0.0;
            parts.iter().find_map(|&([begins, _], own)| {
                sum += own;
                (sum > integral * share).then_some(begins)
            })
        };
        // Along a face, or through an edge: two cuts at one position.
        let index = index_from_world(grid);
        let (start, way) = (index.transform_point3(self.start), index.transform_vector3(self.way));
        let cell = 1.0 / way.length();
        let is_along = (0..3).any(|axis| {
            let off = start[axis] - start[axis].round();
            way[axis].abs() < TIED * way.length() && off.abs() < TIED
        });
        let is_short = |[from, to]: [f64; 2]| to - from < TIED * cell;
        let is_tied = is_along || parts.iter().any(|part| is_short(part.0));
        let sooner = if is_tied { 3_f64.sqrt() * cell } else { 0.0 };
        Some(Inside { integral, begins: after(0.0)?, begins_surely: after(SURE)?, sooner })
    }

    /// Stretches of the line in cells with density, in ways, and its integral along each [m].
    pub(crate) fn stretches(&self, grid: &Grid, ways: [f64; 2]) -> Vec<([f64; 2], f64)> {
        let parts = grid.bricks.iter().flat_map(|brick| self.parts(grid, brick, ways));
        parts.filter(|part| part.1 > 0.0).collect()
    }

    /// Integrals of density up to `count` depths, in the middles of as many equal parts of `ways` [m]; linear
    /// between faces of cells.
    pub(crate) fn optical_depths(&self, grid: &Grid, ways: [f32; 2], count: usize) -> Vec<f64> {
        let ways = ways.map(f64::from);
        let parts = self.stretches(grid, ways);
        let up_to = |number: usize| {
            let end = ways[0] + (ways[1] - ways[0]) * (number as f64 + 0.5) / count as f64;
            let share = |[from, to]: [f64; 2]| ((end - from) / (to - from)).clamp(0.0, 1.0);
            parts.iter().map(|&(stretch, own)| own * share(stretch)).sum()
        };
        (0..count).map(up_to).collect()
    }
}
