//! Plan of a frame, made on the CPU: its batches, and the casters that each of their lists projects.
use crate::shadows::{
    Config,
    batch::{list_plan::ListPlan, scratch::Scratch},
    casters::{CasterSet, TriangleExtent, group::Group},
    cull::{PairBound, TileLoadBound},
    views::host_depths::DepthInput,
};
use crate::{
    error::Error,
    model::{Class, View},
    records::{FOOTPRINT_TEXELS, GpuView, MAX_VIEWS, ROW},
    stage::{
        features::{Features, Flags, Simple},
        project::Chunk,
        tuning::Tuning,
    },
    view::atlas::MapSlot,
};
use std::ops::RangeInclusive;

/// Number of tiles at which a batch is full: one map of 2048x2048 texels occupies any device, and the next
/// batch reuses its sums, pairs and segments.
const MAX_TILES: u32 = 16384;

/// Footprints of the host's casters that a batch has room for, of 60 bytes each. Each view has room for all
/// casters, whatever it sees, so more views take more batches, not more memory.
const HOST_FOOTPRINTS: u64 = 3 << 19;

/// Mean number of casters per tile from which it pays to collect discs in batches of eight, and to have
/// separate loops for the nearest casters and the rest.
const DENSE: u32 = 16;

/// Plan of a batch, made on the CPU.
#[derive(Clone, Debug)]
pub struct BatchPlan {
    /// The views.
    pub views: Vec<GpuView>,
    /// Tiles of all views.
    pub tile_count: u32,
    /// Lists as in [`Class::LISTS`]; for the camera, opaque and blended casters.
    pub lists: [ListPlan; 2],
    /// Whether the maps have contents already.
    pub kept: bool,
    /// Whether the maps hold their values without translucent casters.
    pub cleared: bool,
    /// Chunks of small opaque triangles, which are in no list.
    pub small_chunks: Vec<Chunk>,
    /// The host's depth maps by view.
    pub(crate) depths: Vec<(usize, DepthInput)>,
    /// Whether the views are the camera's, which have no sums: a tile's pairs must fit.
    pub camera: bool,
}

/// A view to be rendered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PendingView<'a> {
    pub view: &'a View,
    pub slot: MapSlot,
    /// Indices of the groups that the view may see, in order.
    pub groups: &'a [u32],
    /// The host's depth map.
    pub depth: Option<&'a DepthInput>,
}

impl PendingView<'_> {
    /// Whether our own opaque casters block light in the view.
    fn blocks(&self) -> bool {
        self.depth.is_none_or(|depth| !depth.instead)
    }
}

/// Cuts the views into batches and lists their casters. `kept`: the maps have contents already.
pub(crate) fn batches(
    views: &[PendingView<'_>],
    casters: &CasterSet,
    config: &Config,
    kept: bool,
) -> Result<Vec<BatchPlan>, Error> {
    let most_footprints = u64::from(ROW * 8192 / FOOTPRINT_TEXELS);
    let host = |list: usize| casters.host().map_or(0, |sets| u64::from(sets.spans[list].capacity));
    let most_together = if casters.host().is_some() { HOST_FOOTPRINTS } else { most_footprints };
    let mut plans = Vec::new();
    let mut first = 0;
    let mut footprints = [0; 2];
    let mut tile_count = 0;
    for (i, &PendingView { view, groups, .. }) in views.iter().enumerate() {
        let listed = [0, 1].map(|i| count(casters, groups, &Class::LISTS[i]) + host(i));
        for need in listed {
            let limit = "casters of one class in a view";
            Error::check_limit(limit, most_footprints, need, "split the scene")?;
        }
        let tiles = view.tiles().element_product();
        let is_full = tile_count + tiles > MAX_TILES
            || i - first == MAX_VIEWS
            || views[first].view.projection != view.projection
            || (0..2).any(|i| footprints[i] + listed[i] > most_together);
        if is_full && i > first {
            plans.push(BatchPlan::new(&views[first..i], casters, config, kept));
            (first, tile_count, footprints) = (i, 0, [0; 2]);
        }
        tile_count += tiles;
        footprints = [0, 1].map(|i| footprints[i] + listed[i]);
    }
    if first < views.len() {
        plans.push(BatchPlan::new(&views[first..], casters, config, kept));
    }
    Ok(plans)
}

/// Number of casters of a list in groups.
fn count(casters: &CasterSet, groups: &[u32], list: &RangeInclusive<Class>) -> u64 {
    let groups = groups.iter().map(|&group| &casters.groups()[group as usize]);
    groups.filter(|group| list.contains(&group.class)).map(|group| group.casters.len() as u64).sum()
}

/// Upper bound of the listed groups of the views.
fn bound(
    casters: &CasterSet,
    visible: &[&[u32]],
    views: &[GpuView],
    is_listed: impl Fn(&Group, &GpuView) -> bool,
) -> PairBound {
    let of_view = |(groups, view): (&&[u32], &GpuView)| {
        let groups = groups.iter().map(|&group| &casters.groups()[group as usize]);
        let mut load = TileLoadBound::new(view);
        groups.filter(|group| is_listed(group, view)).for_each(|group| group.count_in(&mut load));
        load.bound()
    };
    visible.iter().zip(views).map(of_view).fold(PairBound::default(), PairBound::and)
}

impl BatchPlan {
    /// Whether opaque casters are rendered, which write every texel's opaque depth.
    pub(crate) fn has_depths(&self) -> bool {
        self.lists[0].footprint_count > 0 || !self.small_chunks.is_empty()
    }

    /// Combinations (caster, view) that are projected, without the host's.
    pub(crate) fn caster_count(&self) -> u64 {
        let uploaded = |list: &ListPlan| {
            list.host.as_ref().map_or(list.footprint_count, |host| host.first_footprint)
        };
        let listed: u64 = self.lists.iter().map(|list| u64::from(uploaded(list))).sum();
        listed + self.small_chunks.iter().map(|chunk| u64::from(chunk.count)).sum::<u64>()
    }

    /// Whether the commands of this plan serve `other`, too, with the same scratch memory: they differ only
    /// in the contents of the [inputs](super::BatchInputs).
    pub(crate) fn is_alike(&self, other: &Self, tuning: &Tuning, scratch: &Scratch) -> bool {
        let place =
            |view: &GpuView| (view.first_tile, view.tiles_x, view.size, view.origin, view.layer);
        let same_depths = |((a, of_a), (b, of_b)): (&(usize, DepthInput), &(usize, DepthInput))| {
            (a, of_a.instead, &of_a.texture) == (b, of_b.instead, &of_b.texture)
        };
        self.views.iter().map(place).eq(other.views.iter().map(place))
            && (self.tile_count, self.kept, self.cleared, self.camera)
                == (other.tile_count, other.kept, other.cleared, other.camera)
            && self.small_chunks.len() == other.small_chunks.len()
            && self.depths.len() == other.depths.len()
            && self.depths.iter().zip(&other.depths).all(same_depths)
            && self
                .lists
                .iter()
                .zip(&other.lists)
                .all(|(list, other)| list.is_alike(other, tuning, scratch, self.tile_count))
    }

    fn new(pending: &[PendingView<'_>], casters: &CasterSet, config: &Config, kept: bool) -> Self {
        let mut tile_count = 0;
        let to_gpu = |&PendingView { view, slot, .. }: &PendingView<'_>| {
            let gpu_view = view.to_gpu(tile_count, slot.origin, slot.layer);
            tile_count += view.tiles().element_product();
            gpu_view
        };
        let views: Vec<_> = pending.iter().map(to_gpu).collect();
        let of_depths = pending.iter().enumerate();
        let depths: Vec<_> =
            of_depths.filter_map(|(i, pending)| Some((i, pending.depth?.clone()))).collect();
        let groups: Vec<_> = pending.iter().map(|pending| pending.groups).collect();
        let groups_that_block: Vec<&[u32]>;
        let mut by_list = [&groups[..]; 2];
        if pending.iter().any(|pending| !pending.blocks()) {
            let of_view = pending.iter().map(|p| if p.blocks() { p.groups } else { &[] });
            groups_that_block = of_view.collect();
            by_list[0] = &groups_that_block;
        }
        let perspective = views[0].perspective > 0.0;
        let has_opaque = casters.has(0) || !depths.is_empty();
        let [mut blocking, mut filtering] = [0, 1].map(|i| {
            let list = &Class::LISTS[i];
            let features = casters.span(list.clone()).features.of_views(perspective, has_opaque);
            ListPlan::new(list, features, casters, by_list[i])
        });
        let is_small = |extent: TriangleExtent, view: &GpuView| extent.is_small(view);
        let small_chunks = blocking.take_triangles(|chunk| {
            let small = casters.triangle_group(chunk.first_caster).triangles;
            small.is_some_and(|extent| is_small(extent, &views[chunk.view as usize]))
        });
        blocking.features.flags.set(Flags::HAS_SMALL, !small_chunks.is_empty());
        let tiny_chunks = filtering.tiny(casters, &groups, &views);
        let [blocking_bound, filtering_bound] = Class::LISTS.map(|list| {
            let is_listed = |group: &Group, view: &GpuView| {
                let small = group.triangles.is_some_and(|extent| is_small(extent, view));
                list.contains(&group.class) && !small
            };
            bound(casters, &groups, &views, is_listed)
        });
        (blocking.bound, filtering.bound) = (blocking_bound, filtering_bound);
        blocking.add_host(casters, 0, &views);
        filtering.add_host(casters, 1, &views);
        if let Some(host) = &mut blocking.host {
            let not_blocked = (0..).zip(pending).filter(|(_, pending)| !pending.blocks());
            not_blocked.for_each(|(view, _)| host.hide(view));
        }
        let nodes = config.nodes();
        let is_dense = filtering.footprint_count >= DENSE * tile_count;
        // Curves of splats have no queue.
        let queued = config.toggles.queued && (nodes == 0 || filtering.features.is_plain());
        let features = filtering.features.of_walk(is_dense, queued);
        // The host's footprints are behind all uploaded ones.
        let in_order = features.simple() == Some(Simple::Splats) && filtering.host.is_none();
        let features = features.with(Flags::SETUPS_IN_ORDER, in_order);
        let softening = config.settings.soften && nodes > 0;
        let features = Features { nodes, ..features.with(Flags::HAS_SOFTENING, softening) };
        let lists = [blocking, ListPlan { tiny_chunks, features, ..filtering }];
        Self { views, tile_count, lists, small_chunks, depths, kept, cleared: false, camera: false }
    }

    /// Plan of the camera, with the casters of the classes of `list` as the first list that are visible in
    /// `around`, a view around the camera's or that itself.
    pub fn of_camera(
        view: GpuView,
        around: &GpuView,
        tile_count: u32,
        casters: &CasterSet,
        list: &RangeInclusive<Class>,
    ) -> Self {
        let visible = casters.visible(around);
        let features = casters.span(list.clone()).features;
        let features = if *list == Class::SOLID {
            features.of_views(false, false).with(Flags::PARALLEL, false)
        } else {
            features.with(Flags::NOT_PLAIN | Flags::NOT_SPLATS, true)
        };
        let bound = bound(casters, &[&visible], &[*around], |group, _| list.contains(&group.class));
        let camera = true;
        let seen =
            ListPlan { bound, camera, ..ListPlan::new(list, features, casters, &[&visible]) };
        let nothing = ListPlan::new(list, Features::NONE, casters, &[]);
        Self {
            views: vec![view],
            tile_count,
            lists: [seen, nothing],
            small_chunks: Vec::new(),
            depths: Vec::new(),
            kept: false,
            cleared: false,
            camera: true,
        }
    }
}
