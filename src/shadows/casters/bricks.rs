//! Bricks of grids on the GPU: their records, and an atlas of their voxels.
use super::upload::{upload, upload_parts};
use crate::{
    error::Error,
    gpu::Allocator,
    model::{BRICK_EDGE, Brick, Grid, Particle},
    records::{Bricks, SLOT_SIZE},
};
use glam::{UVec2, UVec3};
use std::borrow::Cow;

/// Size of a texel of the atlas, which has four voxels \[bytes\].
const TEXEL_BYTES: u32 = 8;

/// Bricks as uploaded.
#[derive(Debug)]
pub(super) struct UploadedBricks {
    pub records: wgpu::Texture,
    /// Voxels, in a slot of 9 x 8 x 8 texels for each brick that has some. A texel has four voxels: its own,
    /// and the next in y, in z and in both, so that two loads fetch all of a cell.
    pub voxels: wgpu::Texture,
    slots: UVec3,
    bricks: Bricks,
    /// Uploaded grids, then the host's.
    grids: Vec<Grid>,
    /// Number of uploaded grids, and of their bricks.
    uploaded: [usize; 2],
}

/// Slots of a brick: for its voxels, and for their temperatures.
fn slots_of(brick: &Brick) -> u32 {
    u32::from(brick.voxels().is_some()) + u32::from(brick.temperature.is_some())
}

/// Slots along each axis for `count` of them, in a cube of edge `most` at most if they fit.
fn slots(count: u32, most: u32) -> UVec3 {
    let side = (1..most).find(|&side| side.saturating_pow(3) >= count).unwrap_or(most);
    let rows = count.div_ceil(side).max(1);
    UVec3::new(side, rows.min(side), rows.div_ceil(side))
}

fn brick_count(grids: &[Grid]) -> usize {
    grids.iter().map(|grid| grid.bricks.len()).sum()
}

impl UploadedBricks {
    pub(super) fn new(
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        uploaded: &[Grid],
        of_host: &[Grid],
    ) -> Result<Self, Error> {
        let grids = [uploaded, of_host].concat();
        let most = allocator.device.limits().max_texture_dimension_3d / SLOT_SIZE.x;
        let all = grids.iter().flat_map(|grid| &grid.bricks);
        let slots = slots(all.map(slots_of).sum(), most);
        let bricks = Bricks::new(&grids, slots.truncate());
        let records = upload(allocator, queue, "bricks", &bricks.records, 0)?;
        let voxels =
            allocator.volume("voxels", wgpu::TextureFormat::Rgba16Float, slots * SLOT_SIZE)?;
        let uploaded = [uploaded.len(), brick_count(uploaded)];
        let new = Self { records, voxels, slots, bricks, grids, uploaded };
        (0..new.row_count()).for_each(|row| new.write_row(queue, row));
        Ok(new)
    }

    pub(super) fn bricks(&self) -> &Bricks {
        &self.bricks
    }

    /// `particles`, then the uploaded bricks.
    pub(super) fn among<'a>(&self, particles: &'a [Particle]) -> Cow<'a, [Particle]> {
        self.bricks.among(particles, ..self.uploaded[1])
    }

    /// For each grid of the host: its bricks, as particles with the indices of their records, and the slot of
    /// the first.
    pub(super) fn of_host(&self) -> impl Iterator<Item = (&[Particle], u32)> {
        let (uploaded, of_host) = self.grids.split_at(self.uploaded[0]);
        let slot_count = |grid: &Grid| grid.bricks.iter().map(slots_of).sum::<u32>();
        let mut at = (self.uploaded[1], uploaded.iter().map(slot_count).sum::<u32>());
        of_host.iter().map(move |grid| {
            let (first, slot) = at;
            at = (first + grid.bricks.len(), slot + slot_count(grid));
            (&self.bricks.particles[first..at.0], slot)
        })
    }

    /// Slots of `voxels` along x and y.
    pub(super) fn slots(&self) -> UVec2 {
        self.slots.truncate()
    }

    fn row_count(&self) -> u32 {
        (self.bricks.voxels.len() as u32).div_ceil(self.slots.x)
    }

    /// Uploads changes. Returns for each brick whether it has changed; `None` if all must be uploaded anew,
    /// because their number or the number with voxels differs.
    pub(super) fn update(
        &mut self,
        queue: &wgpu::Queue,
        uploaded: &[Grid],
        of_host: &[Grid],
    ) -> Option<Vec<bool>> {
        if self.uploaded != [uploaded.len(), brick_count(uploaded)] {
            return None;
        }
        if self.grids.split_at(uploaded.len()) == (uploaded, of_host) {
            return Some(vec![false; self.bricks.particles.len()]);
        }
        let grids = [uploaded, of_host].concat();
        let new = Bricks::new(&grids, self.slots.truncate());
        let counts = |grids: &[Grid], of: &Bricks| (grids.len(), of.records.len(), of.voxels.len());
        if counts(&grids, &new) != counts(&self.grids, &self.bricks) {
            return None;
        }
        let old = std::mem::replace(&mut self.bricks, new);
        self.grids = grids;
        let new = &self.bricks;
        let is_new: Vec<bool> =
            old.voxels.iter().zip(&new.voxels).map(|(old, new)| old != new).collect();
        let rows = is_new.chunks(self.slots.x as usize);
        for (row, _) in (0..).zip(rows).filter(|(_, row)| row.contains(&true)) {
            self.write_row(queue, row);
        }
        let whole = 0..new.records.len() as u32;
        upload_parts(queue, &self.records, &new.records, &[whole]);
        let mut of_voxels = is_new.iter();
        let changed = new.particles.iter().map(|particle| {
            let [before, after] = [&old, new].map(|all| all.records[particle.id as usize]);
            let has_new_voxels =
                of_voxels.by_ref().take(after.slots()).fold(false, |any, it| any | it);
            has_new_voxels || before != after || old.grid(&before) != new.grid(&after)
        });
        Some(changed.collect())
    }

    /// Writes a row of slots.
    fn write_row(&self, queue: &wgpu::Queue, row: u32) {
        let slots = &self.bricks.voxels[(row * self.slots.x) as usize..];
        let slots = &slots[..slots.len().min(self.slots.x as usize)];
        let lines = (0..SLOT_SIZE.z).flat_map(|z| (0..SLOT_SIZE.y).map(move |y| (y, z)));
        let place = |x: u32, y: u32, z: u32| {
            ((z as usize * BRICK_EDGE) + y as usize) * BRICK_EDGE + x as usize
        };
        let mut halves = Vec::with_capacity(slots.len() * SLOT_SIZE.element_product() as usize * 4);
        for (y, z) in lines {
            for voxels in slots {
                for x in 0..SLOT_SIZE.x {
                    let next = [(y, z), (y + 1, z), (y, z + 1), (y + 1, z + 1)];
                    halves.extend(next.map(|(y, z)| voxels.bits()[place(x, y, z)]));
                }
            }
        }
        let width = slots.len() as u32 * SLOT_SIZE.x;
        let y = row % self.slots.y * SLOT_SIZE.y;
        let z = row / self.slots.y * SLOT_SIZE.z;
        queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x: 0, y, z },
                ..self.voxels.as_image_copy()
            },
            bytemuck::cast_slice(&halves),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * TEXEL_BYTES),
                rows_per_image: Some(SLOT_SIZE.y),
            },
            wgpu::Extent3d { width, height: SLOT_SIZE.y, depth_or_array_layers: SLOT_SIZE.z },
        );
    }
}
