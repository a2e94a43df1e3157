//! Host casters of a list: their number is known on the device only.
use super::{
    casters::CasterSet,
    context::{ChunkBuffers, Context},
    cull::PairBound,
    host_casters::{HostSets, planes},
    plan::ListPlan,
};
use crate::{
    error::Error,
    frame::{Commands, Dispatch},
    gpu::Resources,
    model::tiles_of,
    records::{CullParams, GpuView, Listed, MAX_VIEWS},
    stage::{bin::BinParams, features::Features, load, project::ProjectParams},
};
use glam::Vec4;
use std::{mem::offset_of, ops::Range};
use wgpu::{Buffer, BufferUsages};

/// Host casters of a list.
#[derive(Clone, Debug)]
pub(crate) struct HostList {
    pub groups: Range<u32>,
    /// Six frustum planes of each view.
    pub planes: Vec<Vec4>,
    pub first_footprint: u32,
    /// Most casters that a view may see.
    pub capacity: u32,
}

impl ListPlan {
    /// Expected number of footprints: a caster of the host is seldom visible in more than two views of a
    /// batch.
    pub(crate) fn likely_count(&self) -> u64 {
        const VIEWS: u64 = 2;
        self.host.as_ref().map_or(u64::from(self.footprint_count), |host| {
            let most = u64::from(self.footprint_count - host.first_footprint);
            u64::from(host.first_footprint) + most.min(VIEWS * u64::from(host.capacity))
        })
    }

    /// Adds the host casters behind all uploaded ones.
    pub(crate) fn add_host(&mut self, casters: &CasterSet, list: usize, views: &[GpuView]) {
        let Some(sets) = casters.host().filter(|sets| !sets.spans[list].groups.is_empty()) else {
            return;
        };
        let span = sets.spans[list].clone();
        self.host = Some(HostList {
            groups: span.groups,
            planes: planes(views),
            first_footprint: self.footprint_count,
            capacity: span.capacity,
        });
        self.footprint_count += span.capacity * views.len() as u32;
        // The casters may be anywhere, and of any size.
        let tiles = |view: &GpuView| tiles_of(view.size.as_uvec2()).element_product();
        let most = views.iter().map(tiles).max().unwrap_or(0);
        let pairs = u64::from(span.capacity) * views.iter().map(tiles).map(u64::from).sum::<u64>();
        self.bound = PairBound {
            pairs: self.bound.pairs.saturating_add(pairs),
            of_tile: self.bound.of_tile.saturating_add(span.capacity),
            of_caster: self.bound.of_caster.max(most),
        };
    }
}

/// Chunks that `cull` writes for a list.
#[derive(Debug)]
pub(crate) struct HostChunks {
    /// Capacity for all chunks.
    pub buffers: ChunkBuffers,
    listed: Buffer,
    cull: Dispatch,
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
        let params = context.uniform("cull_params", &values);
        let mut planes = host.planes.clone();
        planes.resize(6 * MAX_VIEWS, Vec4::ZERO);
        let plane_buffer = context.allocator.uniform::<[Vec4; 6 * MAX_VIEWS]>("cull_planes");
        context.queue.write_buffer(&plane_buffer, 0, bytemuck::cast_slice(&planes));
        let none = BufferUsages::empty();
        let counts = context.allocator.storage::<u32>("listed_counts", entries.into(), none)?;
        let listed = context.allocator.storage::<Listed>("listed", 1, BufferUsages::COPY_SRC)?;
        let resources = Resources::new()
            .with("cull_params", &params)
            .with("cull_planes", &plane_buffer)
            .with("host_groups", &sets.groups)
            .with("listed_counts", &counts)
            .with("listed", &listed)
            .with("chunks", &buffers.chunks);
        let kernels = context.kernels;
        let cull = kernels.dispatch(&load::GROUPS, Features::NONE, &resources, [1, 1, 1])?;
        Ok(Self { buffers, listed, cull })
    }

    /// The culling of the groups against each view. The number of footprints goes to the parameters of bin
    /// and to the count of the sort by depth.
    pub(crate) fn cull(&self, bin_params: &Buffer, sort_count: &Buffer) -> Commands {
        const LABEL: &str = "gobo cull";
        let mut commands = Commands::new();
        commands.pass(LABEL, [self.cull.clone()]);
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
        }
        commands
    }
}

impl HostList {
    /// Number of (view, group) combinations.
    pub(crate) fn entry_count(&self) -> u32 {
        self.view_count() * self.groups.len() as u32
    }

    /// Hides all groups from the view.
    pub(crate) fn hide(&mut self, view: usize) {
        self.planes[6 * view] = Vec4::NEG_W;
    }

    fn view_count(&self) -> u32 {
        (self.planes.len() / 6) as u32
    }
}
