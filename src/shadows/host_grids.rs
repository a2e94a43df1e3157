//! Grids of voxels that a host has on the device.
use super::views::host_depths::NO_TEXTURE;
use crate::{
    error::{Error, Input},
    gpu::{Kernel, has_texture},
    model::{BRICK_SIZE, BRICK_VALUES, Bounds, Brick, Density, Grid, Voxels},
};
use glam::{IVec3, UVec3};
use std::sync::LazyLock;
use wgpu::{BindGroup, Texture, TextureDimension, TextureSampleType, TextureUsages};

/// Most bricks of all of a host's grids together: 2.4 GB of voxels.
const MAX_BRICKS: u64 = 1 << 19;

/// Reader of a host's voxels: a kernel that calls WGSL of the host.
#[derive(Clone, Debug)]
pub struct GridLoader {
    pub(super) kernel: Kernel,
}

/// Source of the voxels of a host's grid.
#[derive(Clone, Copy, Debug)]
pub(super) enum VoxelSource<'a> {
    /// First channel of a volume texture.
    Texture(&'a Texture),
    /// Any resources that the loader reads.
    Loader(&'a GridLoader, &'a BindGroup),
}

/// A grid whose voxels a host has on the device, read when the frame runs, so that the CPU never sees them.
/// Voxel (i, j, k) has its centre at (i, j, k) in index space; outside, density is 0. The device makes bricks
/// of 8^3 voxels; those without density cast nothing. A density that is negative, infinite, NaN or above
/// 65,504 counts as 0 and is counted as skipped.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct HostGrid<'a> {
    pub(super) source: VoxelSource<'a>,
    pub(super) size: UVec3,
    pub(super) grid: &'a Grid,
    pub(super) version: Option<u64>,
}

impl<'a> HostGrid<'a> {
    /// The grid whose density is the first channel of `texture`: three-dimensional, of any float or
    /// normalised format, with the usage `TEXTURE_BINDING`. `grid` gives everything else; its own bricks are
    /// empty.
    pub fn new(texture: &'a Texture, grid: &'a Grid) -> Self {
        let size = texture.size();
        let size = UVec3::new(size.width, size.height, size.depth_or_array_layers);
        Self { source: VoxelSource::Texture(texture), size, grid, version: None }
    }

    /// The grid of `size` voxels that `loader` reads. `bindings`: of the loader's layout. `grid` gives
    /// everything else; its own bricks are empty.
    pub fn loaded(
        loader: &'a GridLoader,
        bindings: &'a BindGroup,
        size: impl Into<[u32; 3]>,
        grid: &'a Grid,
    ) -> Self {
        let size = UVec3::from_array(size.into());
        Self { source: VoxelSource::Loader(loader, bindings), size, grid, version: None }
    }

    /// Sets a version that changes when the voxels do: while it stays, maps may be kept. Without a version,
    /// maps that may see the grid are rendered in every frame.
    #[must_use]
    pub fn version(self, version: u64) -> Self {
        Self { version: Some(version), ..self }
    }

    /// Number of bricks along each axis: for the cells from the one before the first voxel to that of the
    /// last.
    pub(super) fn bricks(&self) -> UVec3 {
        (self.size - 1) / BRICK_SIZE + 2
    }

    fn check(&self, device: &wgpu::Device) -> Result<(), &'static str> {
        if let VoxelSource::Texture(texture) = self.source {
            let sample = texture.format().sample_type(None, None);
            if texture.dimension() != TextureDimension::D3 {
                return Err("its texture must have three dimensions");
            }
            if !matches!(sample, Some(TextureSampleType::Float { .. })) {
                return Err("its texture's format must be one of floats or normalised numbers");
            }
            if !texture.usage().contains(TextureUsages::TEXTURE_BINDING) {
                return Err("the usage of its texture lacks TEXTURE_BINDING");
            }
            if !has_texture(device, texture) {
                return Err(NO_TEXTURE);
            }
        }
        if self.size.min_element() == 0 {
            return Err("it must have a voxel along each axis");
        }
        if !self.grid.bricks.is_empty() {
            return Err("its bricks must be empty: they are made of its voxels");
        }
        self.grid.problem().map_or(Ok(()), Err)
    }

    /// Box around all bricks of the grid, world space \[m\].
    pub(super) fn bounds(&self) -> Bounds {
        let edge = BRICK_SIZE as f32;
        let low = IVec3::splat(-(BRICK_SIZE as i32)).as_vec3();
        let bounds = Bounds { min: low, max: low + self.bricks().as_vec3() * edge };
        let to_world = |corner| self.grid.world_from_index.transform_point3(corner);
        bounds
            .corners()
            .into_iter()
            .fold(Bounds::EMPTY, |all, corner| all.with_sphere(to_world(corner), 0.0))
    }

    /// The grid with a brick wherever there may be density, in order.
    fn with_bricks(&self, voxels: &Voxels) -> Grid {
        let bricks = self.bricks();
        let place = |i: u32| {
            UVec3::new(i % bricks.x, i / bricks.x % bricks.y, i / (bricks.x * bricks.y)).as_ivec3()
        };
        let brick = |i| {
            let origin = (place(i) - 1) * BRICK_SIZE as i32;
            Brick::new(origin, Density::Voxels(voxels.clone()))
        };
        let bricks = (0..bricks.element_product()).map(brick).collect();
        Grid { bricks, ..self.grid.clone() }
    }
}

/// The grids with their bricks, whose voxels the device writes.
pub(super) fn with_bricks(
    device: &wgpu::Device,
    grids: &[HostGrid<'_>],
) -> Result<Vec<Grid>, Error> {
    let mut count = 0_u64;
    for (index, grid) in grids.iter().enumerate() {
        grid.check(device).map_err(|problem| Input::HostGrid.invalid(index, problem))?;
        let bricks = grid.bricks().to_array().map(u64::from);
        count = count.saturating_add(bricks.into_iter().fold(1, u64::saturating_mul));
    }
    let remedy = "make the grids smaller or coarser";
    Error::check_limit("bricks of the host's grids", MAX_BRICKS, count, remedy)?;
    // A single one for all frames, which are compared by it.
    static EMPTY: LazyLock<Voxels> = LazyLock::new(|| Voxels::from_bits([0; BRICK_VALUES]));
    Ok(grids.iter().map(|grid| grid.with_bricks(&EMPTY)).collect())
}
