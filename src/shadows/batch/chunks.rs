//! Chunks of a list's casters, and their projection.
use crate::shadows::batch::{
    context::{ChunkBuffers, Context},
    host_chunks::HostChunks,
    list_plan::ListPlan,
};
use crate::shadows::casters::host_kinds::HostKinds;
use crate::{
    error::Error,
    frame::{Commands, Kernels},
    gpu::Resources,
    stage::{
        features::Features,
        project::{GAUSSIANS, PARTICLES, TRIANGLES, grid},
    },
};
use wgpu::Buffer;

/// Chunks of a list.
#[derive(Debug)]
pub(crate) struct Chunks {
    /// Chunks of Gaussians, particles and triangles.
    pub uploaded: [Option<ChunkBuffers>; 3],
    /// Chunks of host casters, whose number only the device knows.
    pub host: Option<HostChunks>,
}

impl Chunks {
    /// `bin_params`: the list's, which kernels may write where it has host casters.
    pub(super) fn new(
        context: &mut Context<'_, '_>,
        plan: &ListPlan,
        bin_params: &Buffer,
    ) -> Result<Self, Error> {
        let [gaussians, particles, triangles] =
            plan.chunks.each_ref().map(|chunks| context.chunk_buffers(plan, chunks));
        let host = plan.host.as_ref().zip(context.casters.host());
        let host = host.map(|host| HostChunks::new(context, plan, host, bin_params)).transpose()?;
        Ok(Self { uploaded: [gaussians?, particles?, triangles?], host })
    }

    /// Culls the host's chunks, then projects all chunks.
    pub(super) fn project(
        &self,
        kernels: &Kernels,
        features: Features,
        resources: &Resources,
    ) -> Result<Commands, Error> {
        let mut commands = Commands::new();
        if let Some(host) = &self.host {
            commands.pass("gobo cull", host.cull.iter().cloned());
        }
        let [gaussians, particles, triangles] = self.uploaded.each_ref().map(Option::as_ref);
        let host = |is_there: fn(&HostKinds) -> bool| {
            let host = self.host.as_ref().filter(|host| is_there(&host.kinds));
            host.map(|host| &host.buffers)
        };
        let all = [
            (&GAUSSIANS, gaussians),
            (&PARTICLES, particles),
            (&TRIANGLES, triangles),
            // Each kernel takes the host's chunks of its kind.
            (&GAUSSIANS, host(|kinds| kinds.gaussians)),
            (&PARTICLES, host(|kinds| kinds.particles)),
        ];
        let there = all.into_iter().filter_map(|(desc, chunks)| Some((desc, chunks?)));
        let project = |(desc, chunks): (_, &ChunkBuffers)| {
            let resources = resources.clone().and(&chunks.resources());
            kernels.dispatch(desc, features, &resources, grid(chunks.count))
        };
        commands.pass("gobo project", there.map(project).collect::<Result<Vec<_>, _>>()?);
        Ok(commands)
    }
}
