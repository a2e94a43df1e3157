//! Light at points of the host, such as particles, probes and splats: the share of each light that the shadow
//! maps transmit.
use crate::shadows::{AreaLevels, Prepared};
use crate::{
    error::{Error, Input},
    frame::Commands,
    gpu::{Allocator, Memory, Shelf, Timeline, allocated},
    model::Light,
    stage::{
        features::Flags,
        light_points::{PointBatch, light_shares, point_grid},
    },
};
use wgpu::{Buffer, BufferUsages};

/// Size of a vector, three `f32` without padding \[bytes\].
const VECTOR: u64 = 12;

/// Points on the device. Their buffers have the usage `STORAGE`; a vector is three `f32`, without padding.
#[derive(Clone, Copy, Debug)]
pub struct PointBuffers<'a> {
    /// Number of points.
    pub count: u32,
    /// Positions, world space \[m\].
    pub positions: &'a Buffer,
    /// Surface normals, unit, world space: they offset points off their own surface's shadow. Zero for a
    /// point on no surface; without the buffer no point is on a surface.
    pub normals: Option<&'a Buffer>,
}

/// Look-up of the lights' shares at some points, ready to be recorded after the maps, any number of times.
/// After the next [`prepare`](crate::Shadows::prepare), a look-up of as many points takes over its buffers:
/// submit the recorded commands of a frame before you prepare the next.
#[derive(Debug)]
pub struct LightPoints {
    levels: Option<AreaLevels>,
    commands: Commands,
    shares: Buffer,
    memory: Memory,
}

impl Prepared {
    /// The share of the `chosen` of `lights` that reaches each point: 1 if nothing is in between, without
    /// falloff and cosine. Reads the maps by the settings of [`prepare`](crate::Shadows::prepare). A light
    /// without views is never shadowed. A point behind the far plane of its view is dark, or lit for
    /// cascades. `lights` are those that the views were made of.
    ///
    /// # Errors
    /// If a light is invalid or does not exist, a buffer is shorter than its points, a later `prepare` has
    /// taken the maps over, or the device is lost or out of memory for the shares.
    pub fn light_points(
        &self,
        lights: &[Light],
        chosen: &[usize],
        points: &PointBuffers<'_>,
    ) -> Result<LightPoints, Error> {
        self.points_on(self.light_shelf.take(), lights, chosen, points)
    }

    /// Like [`Self::light_points`], with buffers that live as long as the returned value: for many points,
    /// some at a time.
    ///
    /// # Errors
    /// Those of [`Self::light_points`].
    pub fn some_light_points(
        &self,
        lights: &[Light],
        chosen: &[usize],
        points: &PointBuffers<'_>,
    ) -> Result<LightPoints, Error> {
        self.points_on(None, lights, chosen, points)
    }

    fn points_on(
        &self,
        shelf: Option<&Shelf>,
        lights: &[Light],
        chosen: &[usize],
        points: &PointBuffers<'_>,
    ) -> Result<LightPoints, Error> {
        self.check_usable()?;
        check(points)?;
        let (device, maps) = (self.device().0, self.maps());
        allocated(device, || {
            let mut memory = Memory::default();
            let mut allocator = Allocator { shelf, ..Allocator::new(device, &mut memory) };
            let source = self.light_source(&mut allocator, lights, chosen, true, None)?;
            let answers = u64::from(points.count) * chosen.len() as u64;
            let copied = BufferUsages::COPY_SRC;
            let shares = allocator.storage::<[f32; 3]>("point_shares", answers, copied)?;
            let batch = PointBatch {
                has_normals: u32::from(points.normals.is_some()),
                ..PointBatch::of(0, answers as u32)
            };
            let batch_buffer = allocator.uniform("point_batch", &batch);
            let resources = source
                .resources
                .clone()
                .with("point_batch", &batch_buffer)
                .with("point_positions", points.positions)
                .with("point_normals", points.normals.unwrap_or(points.positions))
                .with("point_shares", &shares);
            let features = maps.features();
            let features = features.with(Flags::HAS_FILTERS, source.is_filtered);
            let levels = source.levels;
            levels.iter().try_for_each(AreaLevels::compile)?;
            let thrown = self.caustics.as_ref().map(|caustics| &caustics.texels);
            let resources = resources.with_any("caustics", thrown);
            let desc = light_shares(levels.is_some(), thrown.is_some());
            let mut commands = Commands::new();
            let groups = point_grid(batch.count);
            let look_up = self.kernels_on(shelf).dispatch(desc, features, &resources, groups)?;
            commands.pass("gobo light_points", [look_up]);
            commands.compile()?;
            Ok(LightPoints { levels, commands, shares, memory })
        })
    }
}

impl LightPoints {
    /// Records the look-up. The maps must have been recorded before.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        let timeline = &mut Timeline::untimed();
        self.levels.iter().for_each(|levels| levels.record(encoder, timeline));
        self.commands.record(encoder, timeline);
    }

    /// Shares, linear rgb, three `f32` each without padding: point by point, chosen light by chosen light.
    /// Usages `STORAGE` and `COPY_SRC`.
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
        return Err(Input::Point.invalid(has as usize, problem));
    }
    Ok(())
}
