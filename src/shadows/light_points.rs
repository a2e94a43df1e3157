//! Light on points: what of each light the maps let through to points of the host's, such as
//! particles, probes and splats.
use super::{AreaLevels, Prepared, kernels::Variant};
use crate::{
    error::Error,
    gpu::{Allocator, Kernel, Memory},
    model::Light,
    stage::{
        hits::Features,
        shade::{PointBatch, point_grid},
    },
};
use wgpu::{BindGroup, Buffer, BufferUsages};

/// Bytes of a vector: three `f32`, without padding.
const VECTOR: u64 = 12;

/// Points on the device. Their buffers have the usage `STORAGE`; a vector is three `f32`, without
/// padding.
#[derive(Clone, Copy, Debug)]
pub struct PointBuffers<'a> {
    /// How many points.
    pub count: u32,
    /// World space [m].
    pub positions: &'a Buffer,
    /// Of surfaces, unit, world space: they lift points off their own surface's shadow. Zero of a
    /// point that is on none; without the buffer none is.
    pub normals: Option<&'a Buffer>,
}

/// Shares of lights that reach some points, ready to be recorded after the maps, any number of times.
#[derive(Debug)]
pub struct LightPoints {
    kernel: Kernel,
    bindings: BindGroup,
    groups: [u32; 3],
    levels: Option<AreaLevels>,
    shares: Buffer,
    memory: Memory,
}

impl Prepared {
    /// What of the `chosen` of `lights` reaches each point: 1 where nothing is between, without
    /// falloff and cosine. Reads the maps as the settings of [`prepare`](crate::Shadows::prepare)
    /// say; a light without views is never shadowed, and points beyond a view's far plane are dark.
    /// `lights` are those that the views were made of.
    ///
    /// # Errors
    /// Where a light cannot be used or is not there, a buffer ends before its points do, or the device
    /// has no room for the shares.
    pub fn light_points(
        &self,
        lights: &[Light],
        chosen: &[usize],
        points: &PointBuffers<'_>,
    ) -> Result<LightPoints, Error> {
        check(points)?;
        let (device, queue) = self.device();
        let maps = self.maps();
        let mut memory = Memory::default();
        let mut allocator = Allocator { device, memory: &mut memory };
        let source = self.light_source(&mut allocator, lights, chosen, true, None)?;
        let answers = u64::from(points.count) * chosen.len() as u64;
        let copied = BufferUsages::COPY_SRC;
        let shares = allocator.storage::<[f32; 3]>("point_shares", answers, copied)?;
        let batch = PointBatch {
            first: 0,
            count: answers as u32,
            has_normals: u32::from(points.normals.is_some()),
        };
        let batch_buffer = allocator.uniform::<PointBatch>("point_batch");
        queue.write_buffer(&batch_buffer, 0, bytemuck::bytes_of(&batch));
        let resources = source
            .resources(maps)
            .with("point_batch", &batch_buffer)
            .with("point_positions", points.positions)
            .with("point_normals", points.normals.unwrap_or(points.positions))
            .with("point_shares", &shares);
        let areas = source.levels.is_some();
        let own = Features { nodes: maps.nodes, gain: maps.gain, ..Features::NONE };
        let features = Features { areas, filters: source.is_filtered, ..own };
        let kernel = self.kernel(Variant::LightShares, features)?;
        let bindings = kernel.bind(device, &resources)?;
        let groups = point_grid(batch.count);
        Ok(LightPoints { kernel, bindings, groups, levels: source.levels, shares, memory })
    }
}

impl LightPoints {
    /// Records the look-up. The maps must have been recorded before.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(levels) = &self.levels {
            levels.record(encoder);
        }
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("gobo light_points"),
            timestamp_writes: None,
        });
        self.kernel.record(&mut pass, &self.bindings, self.groups);
    }

    /// Linear rgb, three `f32` an answer without padding: point by point, chosen light by chosen
    /// light. Usages `STORAGE` and `COPY_SRC`.
    pub fn shares(&self) -> &Buffer {
        &self.shares
    }

    /// Bytes by buffer and texture.
    pub fn memory(&self) -> &Memory {
        &self.memory
    }
}

fn check(points: &PointBuffers<'_>) -> Result<(), Error> {
    let buffers = [Some(points.positions), points.normals];
    let has = buffers.iter().flatten().map(|buffer| buffer.size() / VECTOR).min().unwrap_or(0);
    if has < u64::from(points.count) {
        let problem = "a buffer of points ends before it";
        return Err(Error::Invalid { what: "point", index: has as usize, problem });
    }
    Ok(())
}
