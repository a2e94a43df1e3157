//! A batch: as many views as share the scratch memory at once, from casters to maps.
pub(crate) mod context;
mod host_chunks;
mod import;
pub(crate) mod list;
mod list_plan;
mod parts;
pub(crate) mod plan;
pub(crate) mod scratch;
mod small;
mod walk;

use crate::shadows::{
    batch::{
        context::{Context, view_uniform},
        import::imports,
        list::List,
        plan::Plan,
        small::{copy_depths, small_triangles},
    },
    views::maps::Maps,
};
use crate::{error::Error, frame::Commands};
use walk::Walk;
use wgpu::Buffer;

/// The commands of a batch.
#[derive(Debug)]
pub(in crate::shadows) struct Batch {
    /// From casters to maps.
    pub commands: Commands,
    /// From casters to the number of pairs of both lists.
    pub counting: Commands,
    /// Counters of the blocking and of the filtering list.
    pub counters: [Buffer; 2],
}

impl Batch {
    pub(in crate::shadows) fn new(
        context: &mut Context<'_, '_>,
        plan: &Plan,
        maps: &Maps,
    ) -> Result<Self, Error> {
        let views = view_uniform(context.allocator, &plan.views);
        let (view_count, tile_count) = (plan.views.len() as u32, plan.tile_count);
        let mut list =
            |i: usize| List::new(context, &plan.lists[i], &views, view_count, tile_count);
        let (blocking, filtering) = (list(0)?, list(1)?);
        let small = small_triangles(context, plan, &views)?;
        // Without opaque casters the opaque depth of new maps stays 1, as `Maps` initialised it.
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
        let imports = imports(context, maps, &plan.views, &plan.depths, is_rendered)?;
        if !imports.is_empty() {
            commands.pass("gobo import", imports);
        }
        if reads_filtering {
            let mut tiny = Vec::new();
            if context.scatters(&plan.lists[1]) {
                tiny.extend(context.chunk_buffers(&plan.lists[1], &plan.lists[1].tiny_chunks)?);
                tiny.extend(filtering.host_chunks.clone());
            }
            commands.append(walk(&filtering, 1, tiny).commands(context)?);
        }
        let mut counting = blocking.counting();
        counting.append(filtering.counting());
        Ok(Self { commands, counting, counters: [blocking.counters, filtering.counters] })
    }
}
