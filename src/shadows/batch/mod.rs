//! A batch: as many views as share the scratch memory at a time, from casters to maps.
pub mod batch_plan;
mod chunks;
pub mod context;
mod host_chunks;
mod import;
pub mod list;
mod list_plan;
pub(in crate::shadows) mod pages;
mod parts;
pub mod scratch;
mod small;
mod walk;

use crate::shadows::{
    batch::{
        batch_plan::BatchPlan,
        context::{Context, view_uniform},
        import::imports,
        list::List,
        small::{copy_depths, small_triangles},
    },
    views::maps::Maps,
};
use crate::{error::Error, frame::Commands, stage::project::Chunk};
use walk::Walk;
use wgpu::Buffer;

/// The commands of a batch.
#[derive(Debug)]
pub(in crate::shadows) struct Batch {
    /// Commands before those of all batches: they put pages of curves back.
    pub releases: Commands,
    /// Commands from casters to maps.
    pub commands: Commands,
    /// Commands from casters to the pair counts of both lists.
    pub counting: Commands,
    /// Counters of the blocking and of the filtering list.
    pub counters: [Buffer; 2],
    pub inputs: BatchInputs,
}

/// Buffers of a batch whose contents depend on its plan alone.
#[derive(Debug)]
pub(in crate::shadows) struct BatchInputs {
    pub views: Buffer,
    lists: [ListInputs; 2],
    tiny_chunks: Option<Buffer>,
    small_chunks: Option<Buffer>,
    imports: Vec<Buffer>,
    /// Whether our own opaque casters render the batch's depths in each frame.
    is_rendered: bool,
}

#[derive(Debug)]
struct ListInputs {
    /// Chunks of Gaussians, particles and triangles.
    chunks: [Option<Buffer>; 3],
    /// Frustum planes for the host's casters.
    planes: Option<Buffer>,
}

impl BatchInputs {
    /// Writes the contents for another plan, which is [alike](BatchPlan::is_alike).
    pub(in crate::shadows) fn write(&self, queue: &wgpu::Queue, plan: &BatchPlan) {
        fn write<T: bytemuck::NoUninit>(queue: &wgpu::Queue, to: &Buffer, values: &[T]) {
            queue.write_buffer(to, 0, bytemuck::cast_slice(values));
        }
        let chunks = |to: &Option<Buffer>, chunks: &[Chunk]| {
            to.iter().for_each(|to| write(queue, to, chunks));
        };
        write(queue, &self.views, &plan.views);
        for (inputs, list) in self.lists.iter().zip(&plan.lists) {
            inputs.chunks.iter().zip(&list.chunks).for_each(|(to, all)| chunks(to, all));
            if let Some((planes, host)) = inputs.planes.as_ref().zip(list.host.as_ref()) {
                write(queue, planes, &host.planes);
            }
        }
        chunks(&self.tiny_chunks, &plan.lists[1].tiny_chunks);
        chunks(&self.small_chunks, &plan.small_chunks);
        for (to, (view, input)) in self.imports.iter().zip(&plan.depths) {
            write(queue, to, &[import::params(&plan.views[*view], input, self.is_rendered)]);
        }
    }
}

impl Batch {
    pub(in crate::shadows) fn new(
        context: &mut Context<'_, '_>,
        plan: &BatchPlan,
        maps: &Maps,
    ) -> Result<Self, Error> {
        let views = view_uniform(context.allocator, &plan.views);
        let (view_count, tile_count) = (plan.views.len() as u32, plan.tile_count);
        let mut list =
            |i: usize| List::new(context, &plan.lists[i], &views, view_count, tile_count);
        let (blocking, filtering) = (list(0)?, list(1)?);
        let (small, small_chunks) = small_triangles(context, plan, &views)?.unzip();
        // Without opaque casters, the opaque depth of new maps stays 1, as `Maps` initialised it.
        let has_old_depths = plan.kept && small.is_none();
        let by_channel = maps.colored.is_some() && small.is_some();
        let reads_blocking = blocking.footprint_count > 0 || has_old_depths || by_channel;
        // `prepare` may have filled the maps with their values without filtering casters.
        let reads_filtering = filtering.footprint_count > 0 || !plan.cleared;
        let is_rendered = reads_blocking || small.is_some();

        let mut commands = Commands::new();
        if let Some(small) = small {
            commands.append(small);
            if blocking.footprint_count == 0 {
                copy_depths(&mut commands, context.scratch, &plan.views, &maps.opaques);
            }
        }
        let walk = |list, i: usize, tiny| Walk {
            maps,
            plan: &plan.lists[i],
            list,
            views: &views,
            tile_count,
            tiny,
        };
        if reads_blocking {
            commands.append(walk(&blocking, 0, Vec::new()).commands(context)?);
        }
        let (dispatches, imports): (Vec<_>, Vec<_>) =
            imports(context, maps, &plan.views, &plan.depths, is_rendered)?.into_iter().unzip();
        if !dispatches.is_empty() {
            commands.pass("gobo import", dispatches);
        }
        let mut tiny_chunks = None;
        let mut releases = Commands::new();
        if reads_filtering {
            releases = pages::releases(context, plan, maps, &views)?;
            let mut tiny = Vec::new();
            if context.scatters(&plan.lists[1]) {
                let uploaded = context.chunk_buffers(&plan.lists[1], &plan.lists[1].tiny_chunks)?;
                tiny_chunks = uploaded.as_ref().map(|uploaded| uploaded.chunks.clone());
                tiny.extend(uploaded);
                tiny.extend(filtering.chunks.host.as_ref().map(|host| host.buffers.clone()));
            }
            commands.append(walk(&filtering, 1, tiny).commands(context)?);
        }
        let mut counting = blocking.counting();
        counting.append(filtering.counting());
        let counters = [&blocking, &filtering].map(|list| list.counters.clone());
        let lists = [blocking, filtering].map(|list| ListInputs {
            chunks: list.chunks.uploaded.map(|buffers| buffers.map(|buffers| buffers.chunks)),
            planes: list.chunks.host.map(|host| host.planes),
        });
        let inputs = BatchInputs { views, lists, tiny_chunks, small_chunks, imports, is_rendered };
        Ok(Self { releases, commands, counting, counters, inputs })
    }
}
