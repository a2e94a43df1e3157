//! Filtering lists whose pairs did not fit: binned again, a part of the tiles at a time.
//!
//! Every tile then has all of its pairs, in order, so that the maps have the same bits as with room for all
//! pairs. `part_count` counts the pairs of each tile, and `part_plan` decides: if the parts that are recorded
//! suffice, all tiles are left to them, otherwise what did not fit is scattered. Each part is the next tiles
//! whose pairs there is room for; the kernels that read a list then walk them as usual. Where all pairs fit,
//! all of this is dispatched with no workgroup.
use super::{
    context::Context,
    frame::{self, Choices, KEYS, PAIRS, ResourceChoice, SortOf},
    kernels::Kernels,
    plan::ListPlan,
    scratch::Scratch,
};
use crate::{
    error::Error,
    gpu::{Allocator, Resources, Timeline, filled},
    stage::bin::{Dispatch, PartParams},
};
use wgpu::{BindGroup, Buffer, BufferUsages};

/// Kernels of the parts, bound and ready to be recorded.
#[derive(Debug)]
pub(crate) struct Parts {
    /// Number of parts that are recorded.
    pub most: u32,
    count: BindGroup,
    plan: BindGroup,
    next: BindGroup,
    gather: BindGroup,
}

/// Buffers of the parts, which all lists use one after another.
#[derive(Debug)]
pub(crate) struct PartBuffers {
    /// Pairs of each tile, then before each tile.
    tile_pairs: Buffer,
    /// Workgroup counts of `part_next`, which writes the others.
    turn: Buffer,
}

impl PartBuffers {
    pub(crate) fn new(allocator: &mut Allocator<'_>, tiles: u64) -> Result<Self, Error> {
        let (cleared, indirect) = (BufferUsages::COPY_DST, BufferUsages::INDIRECT);
        Ok(Self {
            tile_pairs: allocator.storage::<u32>("tile_pairs", tiles + 1, cleared)?,
            turn: allocator.storage::<[u32; 4]>("part_turn", 1, indirect)?,
        })
    }
}

/// Sources of bindings. The sort by depth leaves one of its two textures free.
const SOURCES: &[(&str, ResourceChoice)] = &[
    ("sorted", ResourceChoice::Sorted(KEYS, SortOf::Depth)),
    ("keys", ResourceChoice::Sorted([KEYS[1], KEYS[0]], SortOf::Depth)),
    ("pairs", ResourceChoice::Sorted(PAIRS, SortOf::Tile)),
    ("scattered_tiles", ResourceChoice::Curves("nothing_scattered", "scattered_tiles")),
];

impl Parts {
    /// `None` if all pairs fit. `resources`: of the list.
    pub(crate) fn new(
        context: &Context<'_, '_>,
        list: &ListPlan,
        tile_count: u32,
        resources: &Resources<'_>,
        choices: Choices,
    ) -> Result<Option<Self>, Error> {
        let scratch = context.scratch;
        let may_part = context.config.parts
            && list.may_part(context.config.profile.shape, scratch.pair_capacity);
        let Some(own) = scratch.parts.as_ref().filter(|_| may_part) else {
            return Ok(None);
        };
        let room = scratch.part_room;
        let most = list.most_parts(room, tile_count);
        let device = context.allocator.device;
        let params = filled(
            device,
            "part_params",
            &[PartParams { room, most_parts: most }],
            BufferUsages::UNIFORM,
        );
        let resources = resources
            .clone()
            .with("tile_pairs", &own.tile_pairs)
            .with("part_turn", &own.turn)
            .with("part_params", &params);
        let resources = frame::bound(SOURCES, &resources, choices);
        let kernels = &context.kernels;
        Ok(Some(Self {
            most,
            count: kernels.part_count.bind(device, &resources)?,
            plan: kernels.part_plan.bind(device, &resources)?,
            next: kernels.part_next.bind(device, &resources)?,
            gather: kernels.part_gather.bind(device, &resources)?,
        }))
    }

    /// Records the choice between parts and scattering, after the pairs were written.
    pub(crate) fn record_plan(
        &self,
        scratch: &Scratch,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        timeline.step(encoder, "gobo clear");
        if let Some(own) = &scratch.parts {
            encoder.clear_buffer(&own.tile_pairs, 0, None);
        }
        let mut pass = timeline.pass(encoder, "gobo bin");
        let counts = &scratch.dispatches;
        let offset = Dispatch::PartCount.offset();
        kernels.part_count.record_indirect(&mut pass, &self.count, counts, offset);
        kernels.part_plan.record(&mut pass, &self.plan, [1, 1, 1]);
    }

    /// Records the pairs of the next part.
    pub(crate) fn record_next(
        &self,
        scratch: &Scratch,
        kernels: &Kernels,
        pass: &mut wgpu::ComputePass<'_>,
    ) {
        let (counts, offset) = (&scratch.dispatches, Dispatch::Part.offset());
        if let Some(own) = &scratch.parts {
            kernels.part_next.record_indirect(pass, &self.next, &own.turn, 0);
        }
        kernels.part_gather.record_indirect(pass, &self.gather, counts, offset);
    }
}
