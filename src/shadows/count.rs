//! Scratch memory of a frame, and counts of pairs and pages, taken before any walk.
use super::{
    Maps,
    batch::{
        batch_plan::BatchPlan, context::view_uniform, list::List, pages::Pages, scratch::Scratch,
    },
    prepare::Request,
    statistics::read_list,
};
use crate::{
    error::Error,
    gpu::{Allocator, Memory, Timeline, allocated},
};
use std::sync::Arc;

/// Room that lists need.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Needed {
    /// Pairs of the largest list.
    pub pairs: u32,
    /// Pages of the curves of all lists.
    pub pages: u32,
}

/// Scratch memory of the batches, and its size.
type SizedScratch = (Arc<Scratch>, Memory);

impl Request<'_> {
    /// Scratch memory of the batches, an earlier frame's if that is large enough, and its size; then the
    /// number of pages that curves need, if they are counted.
    pub(super) fn scratch(
        &self,
        earlier: Option<SizedScratch>,
        plans: &mut [BatchPlan],
        maps: &Maps,
    ) -> Result<(SizedScratch, Option<u32>), Error> {
        let (device, config) = (self.kernels.device(), self.config);
        let fits = |scratch: &Scratch| scratch.fits(device, config, plans, self.pairs);
        let usable = earlier.filter(|(scratch, _)| fits(scratch));
        let mut scratch = usable.map_or_else(|| self.new_scratch(plans, self.pairs), Ok)?;
        if !config.toggles.count_first {
            return Ok((scratch, None));
        }
        // Curves that are there have their pages.
        let counts_pages = maps.has_pages() && maps.pages.count == 0;
        let pages_of = counts_pages.then_some(maps);
        let mut needed = self.count(plans, &scratch.0, pages_of)?;
        if needed.pairs > scratch.0.pair_capacity {
            scratch = self.new_scratch(plans, Some(needed.pairs))?;
            if pages_of.is_some() {
                needed = self.count(plans, &scratch.0, pages_of)?;
            }
        }
        Ok((scratch, pages_of.map(|_| needed.pages)))
    }

    fn new_scratch(&self, plans: &[BatchPlan], pairs: Option<u32>) -> Result<SizedScratch, Error> {
        let &Self { config, .. } = self;
        let mut memory = Memory::default();
        let mut allocator = Allocator::new(self.kernels.device(), &mut memory);
        let nodes = config.nodes();
        let scratch = allocated(allocator.device, || {
            Scratch::new(&mut allocator, config, plans, pairs, nodes)
        })?;
        Ok((Arc::new(scratch), memory))
    }

    /// Replaces the bounds of lists by counts where the bounds leave open whether all pairs fit and every
    /// tile is one segment. Submits and waits. With a slow driver compiler, a first frame takes half the
    /// time, because kernels that are not needed are not compiled.
    ///
    /// `pages_of`: maps whose curves are to be in pages, and have none yet.
    fn count(
        &self,
        plans: &mut [BatchPlan],
        scratch: &Arc<Scratch>,
        pages_of: Option<&Maps>,
    ) -> Result<Needed, Error> {
        let mut needed = Needed::default();
        for plan in plans {
            for i in 0..plan.lists.len() {
                let pages_of = pages_of.filter(|_| plan.lists[i].filters);
                let of_list = self.count_list(plan, i, scratch, pages_of)?;
                needed.pairs = needed.pairs.max(of_list.pairs);
                needed.pages += of_list.pages;
            }
        }
        Ok(needed)
    }

    fn count_list(
        &self,
        plan: &mut BatchPlan,
        i: usize,
        scratch: &Arc<Scratch>,
        pages_of: Option<&Maps>,
    ) -> Result<Needed, Error> {
        let (queue, device) = (self.queue, self.kernels.device());
        let listed = &plan.lists[i];
        let may_overflow = listed.may_overflow(self.config.tuning.partition, scratch.pair_capacity);
        // The contents of the host's buffers say nothing about later frames.
        if listed.host.is_some() {
            return Ok(Needed { pairs: 0, pages: pages_of.map_or(0, |_| plan.tile_count) });
        }
        let is_open = may_overflow || listed.has_segments(&self.config.tuning);
        let pages_of = pages_of.filter(|_| listed.footprint_count > 0);
        if !is_open && pages_of.is_none() {
            return Ok(Needed::default());
        }
        let mut memory = Memory::default();
        let mut allocator = Allocator::new(device, &mut memory);
        let views = view_uniform(&mut allocator, &plan.views);
        let mut context = self.context(&mut allocator, scratch);
        let view_count = plan.views.len() as u32;
        let list = List::new(&mut context, &plan.lists[i], &views, view_count, plan.tile_count)?;
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut commands = list.counting();
        commands.append(list.tiles.clone());
        if let Some(maps) = pages_of {
            // There is none yet: all tiles with casters are short of one.
            let pages = Pages { context: &context, maps, list: &list, views: &views };
            commands.pass("gobo bin", [pages.give(plan.tile_count)?]);
        }
        self.kernels.finish()?;
        commands.record(&mut encoder, &mut Timeline::untimed());
        queue.submit([encoder.finish()]);
        let counters = read_list(device, queue, &list.counters)?;
        let is_whole = counters.overflowed == counters.in_parts;
        let pages = if is_whole { counters.short_tiles } else { plan.tile_count };
        let needed = Needed { pairs: counters.pairs_needed, pages };
        if !is_open {
            return Ok(needed);
        }
        let bound = &mut plan.lists[i].bound;
        bound.pairs = bound.pairs.min(counters.pairs_needed.into());
        if counters.overflowed == 0 {
            bound.of_caster = 0;
            if counters.segment_count == 0 {
                bound.of_tile = 0;
            }
        }
        Ok(needed)
    }
}
