//! Volumes from arrays.
use crate::{
    contents::{Added, FARTHEST},
    fault::Fault,
    state::{State, check_limit},
};
use gobo::{
    Brick, Grid, Material, Shape,
    glam::{Affine3A, IVec3, Mat4, Vec3},
    model::Skipped,
};
use gobo_scene::Limit;

/// Range of densities in which half floats are precise.
const PRECISE: std::ops::RangeInclusive<f32> = 0.0625..=60_000.0;

/// Densities, x slowest, channels next to each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Voxels<'a> {
    pub(crate) values: &'a [f32],
    pub(crate) size: [usize; 3],
    /// Channels: 1, or 3 that absorb red, green and blue.
    pub(crate) channels: usize,
    pub(crate) world_from_index: Mat4,
    pub(crate) factor: f32,
    pub(crate) color: Vec3,
    pub(crate) albedo: Vec3,
    pub(crate) anisotropy: f32,
    pub(crate) casts: bool,
    pub(crate) visible: bool,
}

impl State {
    pub(crate) fn add_volume(&mut self, voxels: Voxels<'_>) -> Result<Added, Fault> {
        let Voxels { values, size, channels, world_from_index, factor, color, albedo, .. } = voxels;
        let [_, ny, nz] = size;
        let (mut most, mut wrong) = (0.0_f32, 0);
        for &value in values {
            if value.is_finite() && value >= 0.0 { most = most.max(value) } else { wrong += 1 }
        }
        let scale = if most > 0.0 && !PRECISE.contains(&most) { most } else { 1.0 };
        let last = IVec3::from(size.map(|size| size as i32)) - 1;
        let grid = |channel: usize| {
            let value = |at: IVec3| {
                let [x, y, z] = at.to_array().map(|i| i as usize);
                let value = values[((x * ny + y) * nz + z) * channels + channel];
                if value.is_finite() && value >= 0.0 { value / scale } else { 0.0 }
            };
            let is_empty = values.is_empty();
            Grid {
                world_from_index: Affine3A::from_mat4(world_from_index),
                bricks: if is_empty {
                    Vec::new()
                } else {
                    Brick::of_voxels(IVec3::ZERO, last, value)
                },
                factor: factor * scale,
                // Each channel is a grid that absorbs no other channel.
                extinction: if channels == 1 { color } else { color * Vec3::AXES[channel] },
                material: self.scene.materials.len() as u32,
                anisotropy: voxels.anisotropy,
                ..Grid::default()
            }
        };
        let grids: Vec<_> = (0..channels).map(grid).collect();
        let count = grids.iter().map(|grid| grid.bricks.len()).sum();
        let have: usize = self.scene.grids.iter().map(|grid| grid.bricks.len()).sum();
        check_limit(Limit::Bricks, have, count)?;
        check_limit(Limit::Materials, self.scene.materials.len(), 1)?;
        for grid in &grids {
            if let Some(problem) = grid.problem() {
                let message = format!("volume: {problem}");
                return Err(Fault::input(message, "change its spacing or matrix"));
            }
            let bounds = grid.bounds();
            let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
            if !bounds.is_empty() && (farthest.is_nan() || farthest > FARTHEST) {
                return Err(Fault::input(
                    "volume: it reaches beyond 1e7 m",
                    "move it, or make it smaller",
                ));
            }
        }
        self.scene.materials.push(Material {
            name: format!("volume {}", self.scene.grids.len()),
            shape: Shape::Brick,
            tint: albedo.extend(1.0),
            casts: voxels.casts,
            visible: voxels.visible,
            ..Material::default()
        });
        self.scene.grids.extend(grids);
        let mut skipped = Skipped::new();
        if wrong > 0 {
            skipped.insert("voxel below 0 or not finite", wrong);
        }
        self.skip(skipped.clone());
        Ok((count, skipped))
    }
}
