//! Grids of voxels: their bricks filter light.
use super::Bounds;
use glam::{Affine3A, IVec3, UVec3, Vec3};
use half::f16;
use std::sync::Arc;

/// Edge of a brick with voxels of its own \[voxels\].
pub const BRICK_SIZE: u32 = 8;
/// Voxels along an edge of a brick: its own and the first of the next brick.
pub const BRICK_EDGE: usize = BRICK_SIZE as usize + 1;
/// Values of a brick.
pub const BRICK_VALUES: usize = BRICK_EDGE * BRICK_EDGE * BRICK_EDGE;
/// Largest size of a brick of constant density \[voxels\].
pub const MAX_BRICK_SIZE: u32 = 1 << 20;
/// Farthest index of a voxel: halves of a voxel are exact in `f32` up to here.
pub const MAX_INDEX: i32 = 1 << 22;

/// A grid of voxels, split into disjoint bricks. Its density is trilinear between voxel centres, which are at
/// whole numbers in index space, also from brick to brick, and 0 outside its bricks.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// World space \[m\] from index space \[voxels\].
    pub world_from_index: Affine3A,
    /// Disjoint boxes of voxels.
    pub bricks: Vec<Brick>,
    /// Optical depth of one metre at density 1 [1/m].
    pub factor: f32,
    /// Colour of extinction, per channel: `T = exp(-tau * extinction)`, where `tau` is `factor` times the
    /// integral of density along the ray \[m\].
    pub extinction: Vec3,
    /// Index into [`crate::model::Scene::materials`]: its shape is [`Shape::Brick`](super::Shape::Brick), its
    /// transfer `filter` or `none`.
    pub material: u32,
    /// `g` of the phase function of Henyey and Greenstein 1941, -1 to 1: above 0, most light is scattered
    /// forward.
    pub anisotropy: f32,
    /// Radiance in red of an opaque medium at 1500 K: bricks with temperatures glow like soot, by `1 - T` of
    /// it.
    pub emission: f32,
}

impl Default for Grid {
    /// An empty grid with voxels of a metre; isotropic, of extinction 1 in each channel.
    fn default() -> Self {
        Self {
            world_from_index: Affine3A::IDENTITY,
            bricks: Vec::new(),
            factor: 1.0,
            extinction: Vec3::ONE,
            material: 0,
            anisotropy: 0.0,
            emission: 1.0,
        }
    }
}

/// A box of a grid. It covers the cells whose lowest corner is one of its voxels: where its density is not
/// constant, `[origin, origin + 8)` with 9 values along each edge, the last of which is the next brick's
/// first.
#[derive(Clone, Debug, PartialEq)]
pub struct Brick {
    /// Its lowest voxel, index space.
    pub origin: IVec3,
    /// Its density.
    pub density: Density,
    /// Temperatures of its voxels \[K\], by which it glows with [`Grid::emission`]; only for voxels.
    pub temperature: Option<Voxels>,
}

/// Density of a brick, before [`Grid::factor`].
#[derive(Clone, Debug, PartialEq)]
pub enum Density {
    /// Trilinear between voxels.
    Voxels(Voxels),
    /// The same throughout a box.
    Constant {
        /// Edges of the box, at least 1 \[voxels\].
        size: UVec3,
        /// Its density.
        density: f32,
    },
}

/// 9 x 9 x 9 halves, x first, shared by clones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Voxels(Arc<[u16; BRICK_VALUES]>);

impl Voxels {
    /// Values of `density` at x, y, z of 0..=8, rounded to halves.
    pub fn new(mut density: impl FnMut(UVec3) -> f32) -> Self {
        let edge = BRICK_EDGE as u32;
        let at = |i: u32| UVec3::new(i % edge, i / edge % edge, i / (edge * edge));
        Self::from_bits(std::array::from_fn(|i| f16::from_f32(density(at(i as u32))).to_bits()))
    }

    /// From the bits of 729 halves, x first.
    pub fn from_bits(bits: [u16; BRICK_VALUES]) -> Self {
        Self(Arc::new(bits))
    }

    /// The bits of 729 halves, x first.
    pub fn bits(&self) -> &[u16; BRICK_VALUES] {
        &self.0
    }

    /// The value at x, y, z of 0..=8.
    pub fn at(&self, voxel: UVec3) -> f32 {
        let [x, y, z] = voxel.to_array().map(|v| v as usize);
        f16::from_bits(self.0[(z * BRICK_EDGE + y) * BRICK_EDGE + x]).to_f32()
    }

    /// All values, x first.
    pub fn values(&self) -> impl Iterator<Item = f32> {
        self.0.iter().map(|&bits| f16::from_bits(bits).to_f32())
    }
}

impl Brick {
    /// Bricks of all cells of which some corner is among the voxels from `min` to `max`, inclusive, and has a
    /// `density` above 0. The density of all other voxels counts as 0. Origins are multiples of 8.
    pub fn of_voxels(min: IVec3, max: IVec3, density: impl Fn(IVec3) -> f32) -> Vec<Self> {
        let size = IVec3::splat(BRICK_SIZE as i32);
        let within = |voxel: IVec3| voxel.cmpge(min).all() && voxel.cmple(max).all();
        let value = |voxel: IVec3| if within(voxel) { density(voxel) } else { 0.0 };
        let (first, last) = ((min - 1).div_euclid(size), max.div_euclid(size));
        let mut bricks = Vec::new();
        for z in first.z..=last.z {
            for y in first.y..=last.y {
                for x in first.x..=last.x {
                    let origin = IVec3::new(x, y, z) * size;
                    let voxels = Voxels::new(|voxel| value(origin + voxel.as_ivec3()));
                    if voxels.values().any(|density| density != 0.0) {
                        bricks.push(Self::new(origin, Density::Voxels(voxels)));
                    }
                }
            }
        }
        bricks
    }

    /// A brick without temperatures.
    pub fn new(origin: IVec3, density: Density) -> Self {
        Self { origin, density, temperature: None }
    }

    /// Edges of its box \[voxels\].
    pub fn size(&self) -> UVec3 {
        match self.density {
            Density::Voxels(_) => UVec3::splat(BRICK_SIZE),
            Density::Constant { size, .. } => size,
        }
    }

    /// Its voxels, unless its density is constant.
    pub fn voxels(&self) -> Option<&Voxels> {
        match &self.density {
            Density::Voxels(voxels) => Some(voxels),
            Density::Constant { .. } => None,
        }
    }

    /// Reason to leave it out, which changes nothing else; `None` if it is valid.
    pub fn problem(&self) -> Option<&'static str> {
        let (size, far) = (self.size(), MAX_INDEX);
        let is_density = |density: f32| density.is_finite() && density >= 0.0;
        if self.origin.cmplt(IVec3::splat(-far)).any() || self.origin.cmpgt(IVec3::splat(far)).any()
        {
            return Some("its origin must be within 4194304 voxels of 0");
        }
        if size.min_element() == 0 || size.max_element() > MAX_BRICK_SIZE {
            return Some("its size must be 1..=1048576 voxels");
        }
        let sound = match &self.density {
            Density::Voxels(voxels) => voxels.values().all(is_density),
            &Density::Constant { density, .. } => is_density(density),
        };
        let temperatures = self.temperature.iter().flat_map(Voxels::values);
        if !temperatures.into_iter().all(is_density) {
            return Some("its temperatures must be at least 0 and finite, as halves up to 65504");
        }
        if self.temperature.is_some() && self.voxels().is_none() {
            return Some("a brick of constant density has no temperatures");
        }
        (!sound).then_some("its densities must be at least 0 and finite, as halves up to 65504")
    }
}

impl Grid {
    /// Fault of the grid itself, apart from its bricks and its material.
    pub fn problem(&self) -> Option<&'static str> {
        /// Least ratio of a grid's volume to that of a box with its edges.
        const FLATTEST: f32 = 1e-4;
        let linear = self.world_from_index.matrix3;
        let edges = linear.x_axis.length() * linear.y_axis.length() * linear.z_axis.length();
        let is_flat = !(linear.determinant().abs() > FLATTEST * edges && edges.is_finite());
        if !self.world_from_index.is_finite() || is_flat {
            return Some("its transform must be finite and invertible");
        }
        if !(self.factor.is_finite() && self.factor >= 0.0) {
            return Some("its factor must be at least 0 and finite");
        }
        if !(self.extinction.is_finite() && self.extinction.min_element() >= 0.0) {
            return Some("its extinction must be at least 0 and finite");
        }
        if self.anisotropy.is_nan() || self.anisotropy.abs() > 1.0 {
            return Some("its anisotropy must be -1 to 1");
        }
        if !(self.emission.is_finite() && self.emission >= 0.0) {
            return Some("its emission must be at least 0 and finite");
        }
        None
    }

    /// Corners of a brick's box in world space \[m\].
    pub fn corners(&self, brick: &Brick) -> [Vec3; 8] {
        let (min, size) = (brick.origin.as_vec3(), brick.size().as_vec3());
        let corners = Bounds { min, max: min + size }.corners();
        corners.map(|corner| self.world_from_index.transform_point3(corner))
    }

    /// Bounds of its bricks.
    pub fn bounds(&self) -> Bounds {
        let corners = self.bricks.iter().flat_map(|brick| self.corners(brick));
        corners.fold(Bounds::EMPTY, |bounds, corner| bounds.with_sphere(corner, 0.0))
    }
}
