//! Boxes of voxels on the device.
use crate::{
    device::{Buffers, TooLarge},
    sprites::Order,
};
use bytemuck::{Pod, Zeroable};
use gobo::{Scene, glam::Mat4, model::Density, wgpu};

/// WGSL: `Grid` of `wgsl/bricks.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Grid {
    index_from_world: [[f32; 4]; 4],
    world_from_index: [[f32; 4]; 4],
    extinction: [f32; 3],
    look: u32,
    anisotropy: f32,
    pad: [u32; 3],
}

/// WGSL: `Brick` of `wgsl/bricks.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Brick {
    origin: [f32; 3],
    grid: u32,
    size: [f32; 3],
    voxels: u32,
    density: f32,
    pad: [u32; 3],
}

/// Value of [`Brick::voxels`] in a brick of constant density.
const ALIKE: u32 = u32::MAX;

/// Bricks of all grids.
#[derive(Debug)]
pub(crate) struct Bricks {
    pub(crate) order: Order,
    pub(crate) buffers: Vec<wgpu::Buffer>,
}

impl Bricks {
    pub(crate) fn of(scene: &Scene, buffers: &Buffers<'_>) -> Result<Self, TooLarge> {
        let (mut centers, mut bricks) = (Vec::new(), Vec::new());
        let mut voxels: Vec<u32> = Vec::new();
        let mut grids = Vec::new();
        for grid in &scene.grids {
            let material = &scene.materials[grid.material as usize];
            if !material.visible {
                continue;
            }
            let world_from_index = Mat4::from(grid.world_from_index);
            for brick in &grid.bricks {
                let half = brick.size().as_vec3() * 0.5;
                let middle = brick.origin.as_vec3() + half;
                centers.push(grid.world_from_index.transform_point3(middle));
                let (first, density) = match &brick.density {
                    Density::Voxels(values) => {
                        let first = voxels.len() as u32;
                        let pair = |two: &[u16]| {
                            u32::from(two[0]) | u32::from(two.get(1).copied().unwrap_or(0)) << 16
                        };
                        voxels.extend(values.bits().chunks(2).map(pair));
                        (first, 0.0)
                    }
                    &Density::Constant { density, .. } => (ALIKE, density),
                };
                bricks.push(Brick {
                    origin: brick.origin.as_vec3().into(),
                    grid: grids.len() as u32,
                    size: brick.size().as_vec3().into(),
                    voxels: first,
                    density,
                    pad: [0; 3],
                });
            }
            grids.push(Grid {
                index_from_world: world_from_index.inverse().to_cols_array_2d(),
                world_from_index: world_from_index.to_cols_array_2d(),
                extinction: (grid.extinction * grid.factor).into(),
                look: grid.material,
                anisotropy: grid.anisotropy,
                pad: [0; 3],
            });
        }
        let sorted: Vec<u32> = (0..centers.len() as u32).collect();
        let buffers = vec![
            buffers.storage("bricks", &bricks)?,
            buffers.storage("order", &sorted)?,
            buffers.storage("grids", &grids)?,
            buffers.storage("voxels", &voxels)?,
        ];
        Ok(Self { order: Order::of(centers), buffers })
    }
}
