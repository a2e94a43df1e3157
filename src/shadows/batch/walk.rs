//! The kernels that walk a list of blocking or of filtering casters.
use crate::shadows::{
    batch::{
        context::{ChunkBuffers, Context},
        list::List,
        list_plan::ListPlan,
        pages::Pages,
    },
    views::maps::Maps,
};
use crate::{
    error::Error,
    frame::{Commands, Work},
    stage::{accumulate, bin, colored, occlude, resolve},
};
use wgpu::Buffer;

/// Inputs of a walk.
pub(super) struct Walk<'a> {
    pub maps: &'a Maps,
    pub plan: &'a ListPlan,
    pub list: &'a List,
    pub views: &'a Buffer,
    pub tile_count: u32,
    /// Chunks that may have tiny particles, uploaded ones and the host's.
    pub tiny: Vec<ChunkBuffers>,
}

impl Walk<'_> {
    /// All stages from casters to maps.
    pub(super) fn commands(&self, context: &Context<'_, '_>) -> Result<Commands, Error> {
        let Self { maps, plan, list, tiny, .. } = self;
        let (features, scratch) = (plan.features, context.scratch);
        let (mut kernels, label, last) = match (plan.filters, &maps.colored) {
            (true, _) => (accumulate::kernels(features), "gobo accumulate", "gobo resolve"),
            (false, None) => (occlude::kernels(features), "gobo occlude", "gobo occlude"),
            (false, Some(_)) => (colored::KERNELS, "gobo occlude", "gobo occlude"),
        };
        if plan.filters && maps.sums.is_some() {
            kernels.resolve = &resolve::SUMS_ALONE;
            if plan.sums_in_tiles() {
                kernels = accumulate::SUM_KERNELS;
            }
        }
        let composed = scratch.composed.as_ref().filter(|_| plan.is_composed());
        let resources = context
            .resources(self.views)
            .and(&maps.resources())
            .with("counters", &list.counters)
            .with("pairs", &scratch.pairs[list.sorted_pairs])
            .with("partials", composed.unwrap_or(&scratch.partials));
        let run = |desc, work: Work| context.kernels.dispatch(desc, features, &resources, work);
        let by = |counts: bin::DispatchEntry| Work::indirect(&scratch.dispatches, counts.offset());
        let overflows = list.footprint_count > 0
            && plan.may_overflow(context.config.tuning.partition, context.pair_capacity(plan));
        // Segments of a tile, or its pairs and scattered casters, are merged; tiles of curves read scattered
        // casters themselves.
        let may_scatter = !tiny.is_empty() || overflows;
        let merges =
            plan.has_segments(&context.config.tuning) || (may_scatter && features.nodes == 0);

        let tuning = &context.config.tuning;
        let [x, y, _] = bin::tile_grid(self.tile_count.div_ceil(tuning.tile_run(kernels.tiles)));
        let shares = tuning.tile_shares(kernels.tiles);
        let tiles = run(kernels.tiles, [x, y, shares].into())?;
        let (mut read, mut resolve) = (vec![tiles], Vec::new());
        if merges {
            read.push(run(kernels.segments, by(bin::DispatchEntry::Segment))?);
            resolve.push(run(kernels.resolve, by(bin::DispatchEntry::Merged))?);
        }
        let mut commands = list.clear.clone();
        commands.append(list.project.clone());
        if !tiny.is_empty() {
            let run = |chunks: &ChunkBuffers| {
                let groups = [chunks.count.min(accumulate::TINY_GROUPS), 1, 1];
                let resources = resources.clone().and(&chunks.resources());
                context.kernels.dispatch(&accumulate::TINY, features, &resources, groups)
            };
            commands.pass(label, tiny.iter().map(run).collect::<Result<Vec<_>, _>>()?);
        }
        commands.append(list.sort.clone());
        commands.append(list.pairs.clone());
        if let Some(parts) = &list.parts {
            commands.append(parts.plan.clone());
        }
        if overflows {
            commands.pass(label, [run(kernels.overflow, by(bin::DispatchEntry::Overflow))?]);
        }
        commands.append(list.tiles.clone());
        let pages = Pages { context, maps, list, views: self.views };
        let gives_pages = plan.filters && maps.has_pages();
        let lanes = self.tile_count.div_ceil(bin::TILE_LANES);
        let give = |work: Work| {
            gives_pages.then(|| pages.give_all(&work)).transpose().map(Option::unwrap_or_default)
        };
        commands.pass("gobo bin", give([lanes, 1, 1].into())?);
        commands.pass(label, read.clone());
        commands.pass(last, resolve.clone());
        if let Some(parts) = &list.parts {
            read[0] = read[0].with_work(by(bin::DispatchEntry::Part));
            let given = give(by(bin::DispatchEntry::Part))?;
            let part = [&parts.next[..], &given, &read, &resolve].concat();
            let all = (0..parts.count).flat_map(|_| part.iter().cloned());
            commands.pass(label, merges.then(|| parts.first.clone()).into_iter().chain(all));
        }
        Ok(commands)
    }
}
