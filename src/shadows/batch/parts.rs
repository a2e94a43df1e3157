//! Filtering lists whose pairs did not fit: binned again, a part of the tiles at a time.
//!
//! So every tile has all of its pairs, in order, and the maps have the same bits as with room for all pairs.
//! `part_count` counts the pairs of each tile, and `part_plan` decides: if the recorded parts suffice, they
//! walk all tiles; otherwise casters that did not fit are scattered. Each part takes the next tiles whose
//! pairs there is room for; the kernels that read a list then walk them as usual. Where all pairs fit, all of
//! these kernels are dispatched with no workgroups.
use super::{context::Context, list_plan::ListPlan};
use crate::{
    error::Error,
    frame::{Commands, Dispatch, Work},
    gpu::Resources,
    stage::{
        bin::{self, BinParams, PartParams},
        features::{Features, Flags},
    },
};
use wgpu::BufferUsages;

/// The commands of the parts of a list.
#[derive(Debug)]
pub(crate) struct Parts {
    /// Number of parts that are recorded.
    pub count: u32,
    /// The choice between parts and scattering, after the pairs were written.
    pub plan: Commands,
    /// The reset without which segments of the list would be walked again where no part follows.
    pub first: Dispatch,
    /// The pairs of the next part.
    pub next: [Dispatch; 2],
}

impl Parts {
    /// `None` if all pairs fit. `values`: parameters of bin; `resources`: for the kernel that finds each
    /// tile's pairs; `sorted`: which of the two holds the sorted keys.
    pub(crate) fn new(
        context: &Context<'_, '_>,
        list: &ListPlan,
        values: &BinParams,
        resources: &Resources,
        sorted: usize,
    ) -> Result<Option<Self>, Error> {
        let scratch = context.scratch;
        let toggles = &context.config.toggles;
        let may_part = toggles.parts
            && (!toggles.sums || list.sums_in_tiles())
            && list.may_part(context.config.tuning.partition, scratch.pair_capacity);
        let Some(buffers) = scratch.parts.as_ref().filter(|_| may_part) else {
            return Ok(None);
        };
        let room = scratch.part_room;
        let count = list.most_parts(room, values.tile_count);
        let params = context.kernels.filled(
            "part_params",
            &[PartParams { room, most_parts: count }],
            BufferUsages::UNIFORM,
        );
        // The sort by depth leaves the other free.
        let resources = resources
            .clone()
            .with("tile_pairs", &buffers.tile_pairs)
            .with("part_turn", &buffers.turn)
            .with("part_params", &params)
            .with("sorted", &scratch.keys[sorted])
            .with("keys", &scratch.keys[1 - sorted]);
        let gaussians = list.features.has(Flags::HAS_GAUSSIANS);
        let features = Features::NONE.with(Flags::HAS_GAUSSIANS, gaussians);
        let run = |desc, work: Work| context.kernels.dispatch(desc, features, &resources, work);
        let by = |counts: bin::DispatchEntry| Work::indirect(&scratch.dispatches, counts.offset());
        let mut plan = Commands::new();
        plan.pass(
            "gobo bin",
            [
                run(&bin::PART_CLEAR, values.tile_groups().into())?,
                run(&bin::PART_COUNT, by(bin::DispatchEntry::PartCount))?,
                run(&bin::PART_PLAN, [1, 1, 1].into())?,
            ],
        );
        let next = [
            run(&bin::PART_NEXT, Work::indirect(&buffers.turn, 0))?,
            run(&bin::PART_GATHER, by(bin::DispatchEntry::Part))?,
        ];
        let first = run(&bin::PART_FIRST, [1, 1, 1].into())?;
        Ok(Some(Self { count, plan, first, next }))
    }
}
