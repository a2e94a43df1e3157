//! Bricks of grids as kernels read them.
use crate::model::{
    BRICK_EDGE, BRICK_SIZE, Brick, Class, Density, Grid, Material, Particle, Receives, Voxels,
};
use glam::{DMat3, IVec3, Mat3, UVec2, UVec3, Vec3, Vec3A, Vec4};
use half::f16;
use std::{
    borrow::Cow,
    ops::{Range, RangeTo},
};

/// Texels of a [`BrickRecord`].
pub const BRICK_TEXELS: u32 = 2;
/// Size of a brick's slot in `voxels` \[texels\]: a texel has the voxels of four lines along x.
pub const SLOT_SIZE: UVec3 = UVec3::new(BRICK_EDGE as u32, BRICK_SIZE, BRICK_SIZE);
/// Points along an edge of the lattice at which the light of a thin grid's brick is evaluated: two voxels
/// apart.
pub const LATTICE_EDGE: u32 = 5;
/// The same for a dense grid: the first for which there is room.
const DENSE_EDGES: [u32; 2] = [13, 9];
/// Optical depth of a voxel above which a grid is dense. At this depth, light that is linear over two voxels
/// is off by a twentieth of the brightest at the edge of a cloud.
const DENSE: f32 = 0.25;
/// Points of all lattices up to which those of dense grids are fine: 32 MiB of light.
const MOST_POINTS: u32 = 1 << 21;
/// Records of bricks that a [`GridRecord`] replaces.
const GRID_RECORDS: u32 = 4;
/// [`BrickRecord::density`] of a brick with voxels of its own.
const PLAIN_VOXELS: f32 = -1.0;
/// The same for a brick whose temperatures are in the next slot.
const HOT_VOXELS: f32 = -2.0;

crate::records::texel_struct! {
    /// Values that all bricks of a grid share. Index space is counted from the grid's *anchor*, a voxel in
    /// its middle. All of its bricks place a ray by the same numbers, so that neighbours agree to the last
    /// bit on where it goes from one to the other.
    pub struct GridRecord {
        /// Rows of the linear part of index from world space \[voxels/m\]; after each, a coordinate of the
        /// anchor, world space \[m\].
        pub rows: [Vec4; 3],
        /// Edges of a voxel, world space \[m\]; after each, the extinction at density 1 in a channel [1/m].
        pub edges: [Vec4; 3],
        /// `g` of its phase function.
        pub anisotropy: f32,
        pub material: u32,
        /// Radiance in red of an opaque medium at 1500 K.
        pub emission: f32,
        pub unused: u32,
        /// Points along an edge of the lattices at which the light of its bricks is evaluated.
        pub lattice_edge: u32,
        /// Record of its first brick.
        pub first_brick: u32,
        /// First point of the first brick's lattice, among those of all bricks.
        pub first_point: u32,
        pub unused_word: u32,
    }
}

crate::records::texel_struct! {
    /// A brick of a grid.
    pub struct BrickRecord {
        /// Its lowest voxel, counted from the grid's anchor.
        pub origin: IVec3,
        /// First texel of the grid's record.
        pub grid: u32,
        /// Its first texel in `voxels`; for a brick of constant density, its size \[voxels\].
        pub first_texel: UVec3,
        /// Its density, if it is constant; negative for voxels of its own.
        pub density: f32,
    }
}

/// All bricks of a scene: their records, and the particles that stand for them in the lists of casters.
#[derive(Clone, Debug, Default)]
pub struct Bricks {
    /// Records of the grids, then of the bricks.
    pub records: Vec<BrickRecord>,
    /// For each brick, in order, the sphere around it, with the index of its record as id.
    pub particles: Vec<Particle>,
    /// Voxels of the bricks that have some, in order, each followed by its temperatures if it has some: one
    /// per slot.
    pub voxels: Vec<Voxels>,
    /// Points of the lattices of all bricks.
    pub lattice_points: u32,
    /// Slots of `voxels` in a row, and rows in a layer.
    slots: UVec2,
}

impl GridRecord {
    fn new(grid: &Grid, anchor: IVec3) -> Self {
        let world_from_index = grid.world_from_index;
        let linear = Mat3::from(world_from_index.matrix3).as_dmat3();
        let at = linear * anchor.as_dvec3() + world_from_index.translation.as_dvec3();
        let rows: DMat3 = linear.inverse().transpose();
        let extinction = grid.extinction * grid.factor;
        let with = |columns: DMat3, w: Vec3| {
            std::array::from_fn(|i| columns.col(i).as_vec3().extend(w[i]))
        };
        Self {
            rows: with(rows, at.as_vec3()),
            edges: with(linear, extinction),
            anisotropy: grid.anisotropy,
            material: grid.material,
            emission: grid.emission,
            unused: 0,
            lattice_edge: LATTICE_EDGE,
            first_brick: 0,
            first_point: 0,
            unused_word: 0,
        }
    }

    /// Points of a brick's lattice.
    pub fn lattice_points(&self) -> u32 {
        self.lattice_edge.pow(3)
    }

    /// Whether a brick's own voxels shadow its points, instead of a curve's share of them.
    pub fn is_own_shadow(&self, material: &Material) -> bool {
        let by_curve = matches!(material.receives, Receives::Curve | Receives::Others);
        self.lattice_edge > LATTICE_EDGE && by_curve && Class::of(material).casts()
    }
}

/// Whether some voxel of a grid, or some eighth of a box of constant density, has an optical depth above
/// [`DENSE`].
fn is_dense(grid: &Grid) -> bool {
    let linear = grid.world_from_index.matrix3;
    let edges = [linear.x_axis, linear.y_axis, linear.z_axis].map(Vec3A::length);
    let of_density =
        grid.factor * grid.extinction.max_element() * edges.into_iter().fold(0.0, f32::max);
    grid.bricks.iter().any(|brick| {
        let most = match &brick.density {
            // Halves that are not negative are ordered like their bits.
            Density::Voxels(voxels) => {
                f16::from_bits(voxels.bits().iter().copied().max().unwrap_or(0)).to_f32()
            }
            Density::Constant { size, density } => {
                density * size.max_element() as f32 / BRICK_SIZE as f32
            }
        };
        most * of_density > DENSE
    })
}

/// Points along an edge of the lattices of a grid; `first_point`: number of points before them.
fn lattice_edge(grid: &Grid, first_point: u32) -> u32 {
    if !is_dense(grid) {
        return LATTICE_EDGE;
    }
    let fits = |edge: &u32| {
        let points = grid.bricks.len() as u64 * u64::from(edge.pow(3));
        u64::from(first_point) + points <= u64::from(MOST_POINTS)
    };
    DENSE_EDGES.into_iter().find(fits).unwrap_or(LATTICE_EDGE)
}

/// The voxel in the middle of a grid's bricks.
fn anchor(grid: &Grid) -> IVec3 {
    let none = (IVec3::MAX, IVec3::MIN);
    let (min, max) = grid.bricks.iter().fold(none, |(min, max), brick| {
        (min.min(brick.origin), max.max(brick.origin + brick.size().as_ivec3()))
    });
    if min.cmple(max).all() { min + (max - min) / 2 } else { IVec3::ZERO }
}

/// The sphere around a brick, as a particle of its material.
fn particle(grid: &Grid, brick: &Brick, id: u32) -> Particle {
    let corners = grid.corners(brick);
    let center = corners.iter().sum::<Vec3>() / 8.0;
    let radius = corners.iter().map(|corner| corner.distance(center)).fold(0.0, f32::max);
    // Rounding of the corners.
    let slack = center.abs().max_element() * 8.0 * f32::EPSILON;
    let radius = (radius * 1.0001 + slack).max(f32::MIN_POSITIVE);
    Particle { center, radius, material: grid.material, id, ..Particle::default() }
}

impl Bricks {
    /// `slots`: slots of `voxels` in a row, and rows in a layer.
    pub fn new(grids: &[Grid], slots: UVec2) -> Self {
        let mut all = Self { slots, ..Self::default() };
        let mut first_brick = grids.len() as u32 * GRID_RECORDS;
        for grid in grids {
            let first_point = all.lattice_points;
            let lattice_edge = lattice_edge(grid, first_point);
            let record = GridRecord {
                lattice_edge,
                first_brick,
                first_point,
                ..GridRecord::new(grid, anchor(grid))
            };
            let bricks = grid.bricks.len() as u32;
            first_brick += bricks;
            all.lattice_points =
                first_point.saturating_add(bricks.saturating_mul(record.lattice_points()));
            all.records.extend_from_slice(bytemuck::cast_slice::<_, BrickRecord>(&[record]));
        }
        for (index, grid) in (0..).zip(grids) {
            let anchor = anchor(grid);
            for brick in &grid.bricks {
                let (first_texel, density) = match &brick.density {
                    Density::Voxels(voxels) => {
                        let slot = all.voxels.len() as u32;
                        all.voxels.push(voxels.clone());
                        let (row, layer) = (slot / slots.x, slot / slots.x / slots.y);
                        let first_texel = UVec3::new(slot % slots.x, row % slots.y, layer);
                        all.voxels.extend(brick.temperature.clone());
                        let mark =
                            if brick.temperature.is_some() { HOT_VOXELS } else { PLAIN_VOXELS };
                        (first_texel * SLOT_SIZE, mark)
                    }
                    &Density::Constant { size, density } => (size, density),
                };
                let id = all.records.len() as u32;
                let grid_texel = index * GRID_RECORDS * BRICK_TEXELS;
                let origin = brick.origin - anchor;
                all.records.push(BrickRecord { origin, grid: grid_texel, first_texel, density });
                all.particles.push(particle(grid, brick, id));
            }
        }
        all
    }

    /// Indices of the records that are bricks.
    pub fn brick_records(&self) -> Range<u32> {
        let end = self.records.len() as u32;
        end - self.particles.len() as u32..end
    }

    /// `particles`, then the first bricks, up to `end`.
    pub fn among<'a>(&self, particles: &'a [Particle], end: RangeTo<usize>) -> Cow<'a, [Particle]> {
        let bricks = &self.particles[end];
        if bricks.is_empty() {
            return Cow::Borrowed(particles);
        }
        Cow::Owned(particles.iter().chain(bricks).copied().collect())
    }

    /// The voxels of a brick that has some.
    pub fn voxels_of(&self, brick: &BrickRecord) -> &Voxels {
        &self.voxels[self.slot(brick)]
    }

    /// The temperatures of a brick \[K\], if it has some.
    pub fn temperatures_of(&self, brick: &BrickRecord) -> Option<&Voxels> {
        (brick.density == HOT_VOXELS).then(|| &self.voxels[self.slot(brick) + 1])
    }

    /// Slot of the voxels of a brick that has some.
    fn slot(&self, brick: &BrickRecord) -> usize {
        let first_texel = brick.first_texel / SLOT_SIZE;
        ((first_texel.z * self.slots.y + first_texel.y) * self.slots.x + first_texel.x) as usize
    }

    /// Half edges of the box of the brick in record `id`, world space \[m\].
    pub fn half_edges(&self, id: u32) -> [Vec3; 3] {
        let brick = &self.records[id as usize];
        let size = brick.size() * 0.5;
        let edges = self.grid(brick).edges;
        std::array::from_fn(|i| edges[i].truncate() * size[i])
    }

    /// The record of a brick's grid.
    pub fn grid(&self, brick: &BrickRecord) -> GridRecord {
        self.grid_at(brick.grid)
    }

    /// First texels of the grids' records, and these.
    pub fn grids(&self) -> impl Iterator<Item = (u32, GridRecord)> {
        let end = self.brick_records().start * BRICK_TEXELS;
        let first_texels = (0..end).step_by((GRID_RECORDS * BRICK_TEXELS) as usize);
        first_texels.map(|first| (first, self.grid_at(first)))
    }

    fn grid_at(&self, first_texel: u32) -> GridRecord {
        let first = (first_texel / BRICK_TEXELS) as usize;
        let records = &self.records[first..first + GRID_RECORDS as usize];
        bytemuck::pod_read_unaligned(bytemuck::cast_slice(records))
    }
}

impl BrickRecord {
    /// Slots of its voxels and temperatures.
    pub fn slots(&self) -> usize {
        usize::from(self.density < 0.0) + usize::from(self.density == HOT_VOXELS)
    }

    /// Edges of its box \[voxels\].
    pub fn size(&self) -> Vec3 {
        let of_voxels = UVec3::splat(BRICK_SIZE);
        if self.density < 0.0 { of_voxels.as_vec3() } else { self.first_texel.as_vec3() }
    }
}
