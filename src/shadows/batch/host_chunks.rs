//! Chunks of a list's host casters: their number is known on the device only.
use crate::shadows::{
    batch::{
        context::{ChunkBuffers, Context, padded},
        list_plan::{HostList, ListPlan},
    },
    casters::{host_casters::HostSets, host_kinds::HostKinds},
};
use crate::{
    error::Error,
    frame::{Commands, Dispatch},
    gpu::{Resources, Shelf},
    records::{CullParams, Listed, MAX_VIEWS},
    stage::{bin::BinParams, features::Features, load, project::ProjectParams},
};
use std::mem::offset_of;
use wgpu::{Buffer, BufferUsages};

/// Chunks that `cull` writes for a list.
#[derive(Debug)]
pub(crate) struct HostChunks {
    /// Capacity for all chunks.
    pub buffers: ChunkBuffers,
    pub kinds: HostKinds,
    /// Six frustum planes of each view.
    pub planes: Buffer,
    listed: Buffer,
    cull: Vec<Dispatch>,
}

impl HostChunks {
    pub(crate) fn new(
        context: &mut Context<'_, '_>,
        plan: &ListPlan,
        (host, sets): (&HostList, &HostSets),
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
        let listed = context.allocator.storage::<Listed>("listed", 1, BufferUsages::COPY_SRC)?;
        let resources = Resources::new()
            .with("cull_params", &params)
            .with("cull_planes", &planes)
            .with("host_groups", &sets.groups)
            .with("listed_counts", &counts)
            .with("listed", &listed)
            .with("chunks", &buffers.chunks);
        let kernels = context.kernels;
        let cull = load::cull(entries)
            .into_iter()
            .map(|(desc, groups)| kernels.dispatch(desc, Features::NONE, &resources, groups))
            .collect::<Result<_, _>>()?;
        Ok(Self { buffers, planes, kinds: host.kinds, listed, cull })
    }

    /// The culling of the groups against each view. The number of footprints goes to the parameters of bin
    /// and to the count of the sort by depth.
    pub(crate) fn cull(
        &self,
        shelf: Option<&Shelf>,
        bin_params: &Buffer,
        sort_count: &Buffer,
    ) -> Commands {
        const LABEL: &str = "gobo cull";
        let mut commands = Commands::new();
        commands.pass(LABEL, self.cull.clone());
        for (from, to, offset) in [
            (
                offset_of!(Listed, chunk_count),
                &self.buffers.params,
                offset_of!(ProjectParams, chunk_count),
            ),
            (offset_of!(Listed, footprint_end), bin_params, offset_of!(BinParams, footprint_count)),
            (offset_of!(Listed, footprint_end), sort_count, 0),
        ] {
            commands.copy_buffer(LABEL, (&self.listed, from as u64), (to, offset as u64), 4);
            shelf.iter().for_each(|shelf| shelf.rewritten(to));
        }
        commands
    }
}
