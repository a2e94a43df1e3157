//! Chunks of a list's host casters, whose number only the device knows.
use crate::shadows::{
    batch::{
        context::{ChunkBuffers, Context, padded},
        list_plan::{HostList, ListPlan},
    },
    casters::{host_casters::HostSets, host_kinds::HostKinds},
};
use crate::{
    error::Error,
    frame::Dispatch,
    gpu::Resources,
    records::{CullParams, MAX_VIEWS},
    stage::{features::Features, load},
};
use wgpu::{Buffer, BufferUsages};

/// Chunks that `cull` writes for a list.
#[derive(Debug)]
pub(crate) struct HostChunks {
    /// Capacity for all chunks.
    pub buffers: ChunkBuffers,
    pub kinds: HostKinds,
    /// Six frustum planes of each view.
    pub planes: Buffer,
    /// The culling of the groups against each view. It writes the number of footprints to the parameters of
    /// bin.
    pub cull: Vec<Dispatch>,
}

impl HostChunks {
    /// `bin_params`: the list's, which kernels may write.
    pub(crate) fn new(
        context: &mut Context<'_, '_>,
        plan: &ListPlan,
        (host, sets): (&HostList, &HostSets),
        bin_params: &Buffer,
    ) -> Result<Self, Error> {
        let entries = host.entry_count();
        let buffers = context.written_chunk_buffers(plan, entries)?;
        let values = CullParams {
            view_count: host.view_count(),
            group_count: host.groups.len() as u32,
            first_group: host.groups.start,
            first_caster: sets.first_caster,
            first_footprint: host.first_footprint,
            ..CullParams::default()
        };
        let params = context.allocator.uniform("cull_params", &values);
        let planes = padded(&host.planes, 6 * MAX_VIEWS);
        let planes = context.allocator.filled("cull_planes", &planes, BufferUsages::UNIFORM);
        let none = BufferUsages::empty();
        let counts = context.allocator.storage::<u32>(
            "listed_counts",
            load::listed_length(entries),
            none,
        )?;
        let resources = Resources::new()
            .with("cull_params", &params)
            .with("cull_planes", &planes)
            .with("host_groups", &sets.groups)
            .with("listed_counts", &counts)
            .with("listed_bin_params", bin_params)
            .with("listed_project_params", &buffers.params)
            .with("chunks", &buffers.chunks);
        let kernels = context.kernels;
        let cull = load::cull(entries)
            .into_iter()
            .map(|(desc, groups)| kernels.dispatch(desc, Features::NONE, &resources, groups))
            .collect::<Result<_, _>>()?;
        Ok(Self { buffers, planes, kinds: host.kinds, cull })
    }
}
