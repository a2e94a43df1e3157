//! What a list has of casters in buffers of the host's: only the device knows how many.
use super::{
    context::{ChunkBuffers, Context},
    host_casters::HostSets,
    kernels::Kernels,
    plan::{HostList, ListPlan},
};
use crate::{
    error::Error,
    gpu::{Resources, Timeline},
    records::{CullParams, Listed, MAX_VIEWS},
    stage::{
        bin::BinParams,
        project::{ProjectParams, grid},
    },
};
use glam::Vec4;
use std::mem::offset_of;
use wgpu::{BindGroup, Buffer, BufferUsages};

/// The chunks that `cull` leaves of a list, and who must know how many.
#[derive(Debug)]
pub(crate) struct HostChunks {
    /// Room for all.
    pub buffers: ChunkBuffers,
    listed: Buffer,
    cull: BindGroup,
    project: BindGroup,
    /// Where the number of footprints goes, with its place [bytes].
    footprint_counts: Vec<(Buffer, u64)>,
}

impl HostChunks {
    pub(crate) fn new(
        context: &mut Context<'_, '_>,
        plan: &ListPlan,
        (host, sets): (&HostList, &HostSets),
        views: &Buffer,
    ) -> Result<Self, Error> {
        let entries = host.entry_count();
        let buffers = context.room_for_chunks(plan, entries)?;
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
        let device = context.allocator.device;
        let resources = Resources::new()
            .with("cull_params", &params)
            .with("cull_planes", &plane_buffer)
            .with("host_groups", &sets.groups)
            .with("listed_counts", &counts)
            .with("listed", &listed)
            .with("chunks", &buffers.chunks);
        let cull = context.kernels.cull_groups.bind(device, &resources)?;
        let resources = context.resources(views).and(&buffers.resources());
        let resources = resources.with("keys", &context.scratch.keys[0]);
        let project = context.kernels.project_particles.bind(device, &resources)?;
        Ok(Self { buffers, listed, cull, project, footprint_counts: Vec::new() })
    }

    /// Who reads how many footprints the list has.
    pub(crate) fn count_into(&mut self, bin_params: &Buffer, sort_count: Option<&Buffer>) {
        let place = offset_of!(BinParams, footprint_count) as u64;
        self.footprint_counts.push((bin_params.clone(), place));
        self.footprint_counts.extend(sort_count.map(|count| (count.clone(), 0)));
    }

    /// What each view may see.
    pub(crate) fn record_cull(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        let mut pass = timeline.pass(encoder, "cull");
        kernels.cull_groups.record(&mut pass, &self.cull, [1, 1, 1]);
        drop(pass);
        let mut tell = |place: usize, to: &Buffer, offset: u64| {
            encoder.copy_buffer_to_buffer(&self.listed, place as u64, to, offset, 4);
        };
        let chunk_count = offset_of!(ProjectParams, chunk_count) as u64;
        tell(offset_of!(Listed, chunk_count), &self.buffers.params, chunk_count);
        for (buffer, offset) in &self.footprint_counts {
            tell(offset_of!(Listed, footprint_end), buffer, *offset);
        }
    }

    pub(crate) fn record_project(&self, kernels: &Kernels, pass: &mut wgpu::ComputePass<'_>) {
        kernels.project_particles.record(pass, &self.project, grid(self.buffers.count));
    }
}

impl HostList {
    /// (view, group).
    pub(crate) fn entry_count(&self) -> u32 {
        self.view_count() * self.groups.len() as u32
    }

    /// The view sees none of them.
    pub(crate) fn hide(&mut self, view: usize) {
        self.planes[6 * view] = Vec4::NEG_W;
    }

    fn view_count(&self) -> u32 {
        (self.planes.len() / 6) as u32
    }
}
