//! Pair counts of lists, taken before any walk.
use super::{
    batch::{batch_plan::BatchPlan, context::view_uniform, list::List, scratch::Scratch},
    prepare::Request,
    statistics::read_list,
};
use crate::{
    error::Error,
    gpu::{Allocator, Memory, Timeline},
};
use std::sync::Arc;

impl Request<'_> {
    /// Replaces the bounds of lists by counts where the bounds leave open whether all pairs fit and every
    /// tile is one segment. Submits and waits. With a slow driver compiler, a first frame takes half the
    /// time, because kernels that are not needed are not compiled.
    ///
    /// Returns the number of pairs of the largest list.
    pub(super) fn count(
        &self,
        plans: &mut [BatchPlan],
        scratch: &Arc<Scratch>,
    ) -> Result<u32, Error> {
        let mut needed = 0;
        for plan in plans {
            for i in 0..plan.lists.len() {
                needed = needed.max(self.count_list(plan, i, scratch)?);
            }
        }
        Ok(needed)
    }

    fn count_list(
        &self,
        plan: &mut BatchPlan,
        i: usize,
        scratch: &Arc<Scratch>,
    ) -> Result<u32, Error> {
        let (queue, device) = (self.queue, self.kernels.device());
        let listed = &plan.lists[i];
        let may_overflow = listed.may_overflow(self.config.tuning.partition, scratch.pair_capacity);
        // The contents of the host's buffers say nothing about later frames.
        if listed.host.is_some() || !(may_overflow || listed.has_segments(&self.config.tuning)) {
            return Ok(0);
        }
        let mut memory = Memory::default();
        let mut allocator = Allocator::new(device, &mut memory);
        let views = view_uniform(&mut allocator, &plan.views);
        let mut context = self.context(&mut allocator, scratch);
        let view_count = plan.views.len() as u32;
        let list = List::new(&mut context, &plan.lists[i], &views, view_count, plan.tile_count)?;
        self.kernels.finish()?;
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut commands = list.counting();
        commands.append(list.tiles);
        commands.record(&mut encoder, &mut Timeline::untimed());
        queue.submit([encoder.finish()]);
        let counters = read_list(device, queue, &list.counters)?;
        let bound = &mut plan.lists[i].bound;
        bound.pairs = bound.pairs.min(counters.pairs_needed.into());
        if counters.overflowed == 0 {
            bound.of_caster = 0;
            if counters.segment_count == 0 {
                bound.of_tile = 0;
            }
        }
        Ok(counters.pairs_needed)
    }
}
