//! Pages of the curves of a batch: put back before all batches, and given to tiles with casters.
use super::{
    batch_plan::BatchPlan,
    context::{Context, map_groups},
    list::List,
};
use crate::{
    error::Error,
    frame::{Commands, Dispatch, Work},
    gpu::{KernelDesc, Resources},
    model::TILE_SIZE,
    shadows::views::maps::Maps,
    stage::{bin::TILE_LANES, curve, features::Features},
};
use wgpu::Buffer;

/// Tiles of a workgroup that puts pages back, in x and y.
const RELEASED: u32 = 8;

/// Commands that put back the pages of all views of a batch.
pub(super) fn releases(
    context: &Context<'_, '_>,
    plan: &BatchPlan,
    maps: &Maps,
    views: &Buffer,
) -> Result<Commands, Error> {
    let mut commands = Commands::new();
    if maps.has_pages() {
        let resources = maps.resources().with("views", views);
        let groups = map_groups(&plan.views, RELEASED * TILE_SIZE);
        let (desc, features) = (&curve::RELEASE_PAGES, Features::NONE);
        commands
            .pass("gobo clear", [context.kernels.dispatch(desc, features, &resources, groups)?]);
    }
    Ok(commands)
}

/// Pages for the tiles of a list.
pub(in crate::shadows) struct Pages<'a, 'd> {
    pub context: &'a Context<'a, 'd>,
    pub maps: &'a Maps,
    pub list: &'a List,
    pub views: &'a Buffer,
}

impl Pages<'_, '_> {
    /// Gives one to each of `tiles` tiles that has casters.
    pub(in crate::shadows) fn give(&self, tiles: u32) -> Result<Dispatch, Error> {
        self.run(&curve::GIVE_PAGES, [tiles.div_ceil(TILE_LANES), 1, 1].into())
    }

    /// The same, and takes them back if there were too few. `work`: an invocation for each tile or more.
    pub(super) fn give_all(&self, work: &Work) -> Result<Vec<Dispatch>, Error> {
        let pages = &self.maps.pages;
        let mut dispatches = vec![self.run(&curve::GIVE_PAGES, work.clone())?];
        if pages.count < pages.tile_count() {
            dispatches.push(self.run(&curve::SETTLE_PAGES, work.clone())?);
        }
        Ok(dispatches)
    }

    fn run(&self, desc: &'static KernelDesc, work: Work) -> Result<Dispatch, Error> {
        let Self { context, maps, list, views } = self;
        let resources: Resources = context
            .resources(views)
            .and(&maps.resources())
            .with("bin_params", &list.params)
            .with("counters", &list.counters);
        Ok(context.kernels.dispatch(desc, Features::NONE, &resources, work)?)
    }
}
