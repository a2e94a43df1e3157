//! Bindings of the kernels that read a list of blocking or of filtering casters.
use crate::{
    error::Error,
    gpu::Timeline,
    shadows::{
        context::{ChunkBuffers, Chunks, Context},
        frame::{self, Conditions, Groups, Part, Readers, Role, Step, Work},
        kernels::Kernels,
        list::List,
        maps::Maps,
        scratch::Scratch,
    },
    stage::{bin::Dispatch, features::Features, formula::Number},
};
use wgpu::{BindGroup, Buffer};

/// A list and the bindings of the kernels that read it.
#[derive(Debug)]
pub(super) struct BoundList {
    pub list: List,
    pub readers: Readers,
    pub features: Features,
    conditions: Conditions,
    /// Chunks of tiny particles, uploaded ones and the host's; only if the list filters.
    tiny: Vec<Chunks>,
    /// Bindings of the kernels that the list needs.
    bound: Vec<(Role, BindGroup)>,
}

impl BoundList {
    pub(super) fn blocking(
        context: &mut Context<'_, '_>,
        maps: &Maps,
        list: List,
        features: Features,
        views: &Buffer,
        is_read: bool,
    ) -> Result<Self, Error> {
        let readers = if maps.colored.is_some() { Readers::COLORED } else { Readers::OCCLUDE };
        Self::new(context, maps, list, readers, features, views, &[], is_read)
    }

    /// `tiny`: chunks that may have tiny particles.
    pub(super) fn filtering(
        context: &mut Context<'_, '_>,
        maps: &Maps,
        list: List,
        features: Features,
        views: &Buffer,
        tiny: &[&ChunkBuffers],
        is_read: bool,
    ) -> Result<Self, Error> {
        Self::new(context, maps, list, Readers::ACCUMULATE, features, views, tiny, is_read)
    }

    /// `is_read`: whether the list is recorded.
    #[expect(clippy::too_many_arguments, reason = "each is another owner's")]
    fn new(
        context: &mut Context<'_, '_>,
        maps: &Maps,
        list: List,
        readers: Readers,
        features: Features,
        views: &Buffer,
        tiny: &[&ChunkBuffers],
        is_read: bool,
    ) -> Result<Self, Error> {
        let device = context.allocator.device;
        let conditions =
            list.conditions.with_readers(list.has_segments, !tiny.is_empty(), features.nodes > 0);
        let needed: Vec<_> = frame::kernels(conditions)
            .filter(|_| is_read)
            .filter_map(|(role, sources)| Some((role, readers.variant(role)?, sources)))
            .collect();
        for &(_, variant, _) in &needed {
            context.kernels.plan(device, variant, features)?;
        }
        let resources =
            context.resources(views).and(&maps.resources()).with("counters", list.counters());
        let (mut bound, mut tiny_chunks) = (Vec::new(), Vec::new());
        for (role, variant, sources) in needed {
            let kernel = context.kernels.get(variant, features);
            if role != Role::Tiny {
                let own = frame::bound(sources, &resources, list.choices);
                bound.push((role, kernel.bind(device, &own)?));
                continue;
            }
            for buffers in tiny {
                let resources = resources
                    .clone()
                    .with("tiny_chunks", &buffers.chunks)
                    .with("tiny_params", &buffers.params);
                let own = frame::bound(sources, &resources, list.choices);
                let bindings = kernel.bind(device, &own)?;
                tiny_chunks.push(Chunks { count: buffers.count, bindings });
            }
        }
        Ok(Self { list, readers, features, conditions, tiny: tiny_chunks, bound })
    }

    /// Records all stages from casters to maps.
    pub(super) fn record(
        &self,
        scratch: &Scratch,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        let list = &self.list;
        for (part, steps) in frame::parts() {
            match part {
                Part::Clear => {
                    timeline.step(encoder, "gobo clear");
                    scratch.clear(list, encoder);
                }
                Part::Project => list.record_project(kernels, encoder, timeline),
                Part::Sort => drop(list.record_sort(kernels, encoder, timeline)),
                Part::Pairs => {
                    let is_listed = list.record_pairs(kernels, encoder, timeline);
                    if let Some(parts) = list.parts.as_ref().filter(|_| is_listed) {
                        parts.record_plan(scratch, kernels, encoder, timeline);
                    }
                }
                Part::Tiles => list.record_tiles(kernels, encoder, timeline),
                Part::Tiny | Part::Overflow | Part::Read | Part::Resolve => {
                    // Every frame has a time for these two, also one without segments.
                    let is_timed = matches!(part, Part::Read | Part::Resolve);
                    if is_timed || steps.iter().any(|step| self.conditions.hold(step.when)) {
                        let Readers { stage, last, .. } = self.readers;
                        let label = if part == Part::Resolve { last } else { stage };
                        let mut pass = timeline.pass(encoder, label);
                        self.record_steps(steps, scratch, kernels, &mut pass);
                    }
                }
            }
        }
        self.record_parts(scratch, kernels, encoder, timeline);
    }

    /// Records the walk of the tiles part by part, for lists whose pairs may not fit.
    fn record_parts(
        &self,
        scratch: &Scratch,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        let Some(parts) = &self.list.parts else { return };
        let mut pass = timeline.pass(encoder, self.readers.stage);
        for _ in 0..parts.most {
            parts.record_next(scratch, kernels, &mut pass);
            for step in [Part::Read, Part::Resolve].into_iter().flat_map(frame::steps) {
                let Work::Kernel { role, groups, .. } = step.work else { continue };
                let holds = self.conditions.hold(step.when);
                let Some(variant) = self.readers.variant(role).filter(|_| holds) else { continue };
                let dispatch = match groups {
                    Groups::Counts(_) => Dispatch::Part,
                    Groups::Indirect(dispatch) => dispatch,
                };
                let kernel = kernels.get(variant, self.features);
                let (counts, offset) = (&scratch.dispatches, dispatch.offset());
                let bound = self.bound.iter().filter(|(of, _)| *of == role);
                bound.for_each(|(_, it)| kernel.record_indirect(&mut pass, it, counts, offset));
            }
        }
    }

    fn record_steps(
        &self,
        steps: &[Step],
        scratch: &Scratch,
        kernels: &Kernels,
        pass: &mut wgpu::ComputePass<'_>,
    ) {
        for step in steps.iter().filter(|step| self.conditions.hold(step.when)) {
            let Work::Kernel { role, groups, .. } = step.work else { continue };
            let Some(variant) = self.readers.variant(role) else { continue };
            let kernel = kernels.get(variant, self.features);
            let bound = self.bound.iter().filter(|(of, _)| *of == role).map(|(_, it)| it);
            match groups {
                Groups::Counts(groups) if role == Role::Tiny => {
                    for Chunks { count, bindings } in &self.tiny {
                        let numbers = self.list.numbers.with(Number::TinyChunks, *count);
                        kernel.record(pass, bindings, groups.map(|n| n.count(&numbers)));
                    }
                }
                Groups::Counts(groups) => {
                    let groups = groups.map(|n| n.count(&self.list.numbers));
                    bound.for_each(|bindings| kernel.record(pass, bindings, groups));
                }
                Groups::Indirect(dispatch) => {
                    let (counts, offset) = (&scratch.dispatches, dispatch.offset());
                    bound.for_each(|it| kernel.record_indirect(pass, it, counts, offset));
                }
            }
        }
    }

    /// Records the stages from casters to pairs.
    pub(super) fn record_counts(
        &self,
        scratch: &Scratch,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        timeline.step(encoder, "gobo clear");
        scratch.clear(&self.list, encoder);
        self.list.record_project(kernels, encoder, timeline);
        self.list.record_emit(kernels, encoder, timeline);
    }
}
