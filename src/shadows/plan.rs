//! Plan of a frame, made on the CPU: its batches, and the casters that each of their lists projects.
use super::{
    Config,
    casters::CasterSet,
    cull::{PairBound, TileLoadBound},
    groups::Group,
    host_depths::DepthInput,
    host_list::HostList,
    small::TriangleExtent,
};
use crate::{
    error::Error,
    model::{Class, View},
    records::{CURVE_SEGMENT, FOOTPRINT_TEXELS, GpuView, MAX_VIEWS, ROW},
    stage::{
        bin::{self, DISC_SEGMENT, SEGMENT_LENGTH},
        features::Features,
        project::Chunk,
        shade::ROUND_LENGTH,
        sort::Shape,
    },
    view::atlas::MapPlace,
};
use std::ops::RangeInclusive;

/// Most tiles of a batch: one map of 4096x4096 texels, whose sums just fit a storage binding.
const MAX_TILES: u32 = 65536;

/// Mean number of casters per tile from which collecting discs in batches of eight pays, and separate loops
/// for the nearest casters and the rest.
const DENSE: u32 = 16;

/// Plan of a batch, made on the CPU.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub views: Vec<GpuView>,
    pub tile_count: u32,
    /// Lists as in [`LISTS`]; for the camera, opaque and blended casters.
    pub lists: [ListPlan; 2],
    /// Whether the maps have contents already.
    pub kept: bool,
    /// Whether the maps have been filled with their values without translucent casters.
    pub cleared: bool,
    /// Chunks of small opaque triangles, which are in no list.
    pub small_chunks: Vec<Chunk>,
    /// The host's depth maps by view.
    pub depths: Vec<(usize, DepthInput)>,
    /// Whether the views are the camera's: without sums, and a tile's pairs must fit.
    pub camera: bool,
}

/// The casters of one list of a batch, as they are projected.
#[derive(Clone, Debug)]
pub(crate) struct ListPlan {
    /// Whether its casters filter light in shadow views.
    pub filters: bool,
    /// Whether it is a list of the camera.
    pub camera: bool,
    pub features: Features,
    pub particle_chunks: Vec<Chunk>,
    /// Those of `particle_chunks` that may have particles on the scatter path.
    pub tiny_chunks: Vec<Chunk>,
    pub triangle_chunks: Vec<Chunk>,
    /// Host casters, whose number is known on the device only.
    pub host: Option<HostList>,
    /// Footprints of particles, then of triangles, then the capacity of the host's casters.
    pub footprint_count: u32,
    pub first_setup: u32,
    /// Upper bound of its pairs.
    pub bound: PairBound,
}

impl ListPlan {
    /// Whether segments are composed one by one.
    pub(crate) fn is_composed(&self) -> bool {
        self.filters && self.features.is_composed()
    }

    /// Pairs that one workgroup walks at a time.
    pub(crate) fn segment_length(&self) -> u32 {
        match self.features {
            _ if self.camera => ROUND_LENGTH,
            Features { nodes: 1.., .. } => CURVE_SEGMENT,
            Features { plain: true, .. } => DISC_SEGMENT,
            _ => SEGMENT_LENGTH,
        }
    }

    /// Whether a tile may have more pairs than a segment.
    pub(crate) fn has_segments(&self) -> bool {
        self.bound.of_tile > self.segment_length()
    }

    /// Whether some footprints' pairs may not fit.
    pub(crate) fn may_overflow(&self, shape: Shape, capacity: u32) -> bool {
        let of_run = u64::from(bin::run_length(shape, self.footprint_count))
            * u64::from(self.bound.of_caster);
        self.bound.pairs > u64::from(capacity) || of_run > u64::from(bin::RUN_PAIRS)
    }

    /// Whether the list goes through parts of its tiles where its pairs do not fit. Lists that block light
    /// scatter what does not fit, which changes no bit, and the picture is binned in parts of its own.
    pub(crate) fn may_part(&self, shape: Shape, capacity: u32) -> bool {
        self.filters && !self.camera && self.may_overflow(shape, capacity)
    }

    /// Least room for the pairs of a part: for those of any tile, and so many that parts are few.
    pub(crate) fn part_room(&self) -> u64 {
        const USUAL: u64 = 1 << 18;
        u64::from(self.bound.of_tile.min(self.footprint_count)).max(USUAL.min(self.bound.pairs))
    }

    /// Parts of the tiles that are recorded, with room for so many pairs in each.
    pub(crate) fn most_parts(&self, room: u32, tile_count: u32) -> u32 {
        /// Each is recorded, needed or not. The pairs of the host's casters have no useful bound.
        const MOST: u64 = 512;
        const MOST_OF_HOST: u64 = 32;
        let most = if self.host.is_some() { MOST_OF_HOST } else { MOST };
        // Two parts that follow each other have more pairs than there is room for in one.
        let enough = self.bound.pairs / u64::from(room.max(1)) * 2 + 2;
        enough.min(u64::from(tile_count) + 1).min(most) as u32
    }

    pub(crate) fn setup_count(&self) -> u32 {
        let end = self.host.as_ref().map_or(self.footprint_count, |host| host.first_footprint);
        end - self.first_setup
    }
}

/// Lists of a shadow view: blocking and filtering casters.
pub(crate) const LISTS: [RangeInclusive<Class>; 2] = [Class::BLOCKING, Class::FILTERING];

/// A view to be rendered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PendingView<'a> {
    pub view: &'a View,
    pub place: MapPlace,
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
) -> Result<Vec<Plan>, Error> {
    let most_footprints = u64::from(ROW * 8192 / FOOTPRINT_TEXELS);
    let mut plans = Vec::new();
    let mut batch = Vec::new();
    let mut footprints = [0; 2];
    let mut tile_count = 0;
    for pending in views {
        let PendingView { view, place, groups, .. } = *pending;
        let host =
            |list: usize| casters.host().map_or(0, |sets| u64::from(sets.spans[list].capacity));
        let listed = [0, 1].map(|i| count(casters, groups, &LISTS[i]) + host(i));
        if let Some(&need) = listed.iter().find(|&&listed| listed > most_footprints) {
            return Err(Error::Limit {
                limit: "casters of one class in a view",
                have: most_footprints,
                need,
                remedy: "split the scene",
            });
        }
        let tiles = view.tiles().element_product();
        let mut gpu_view = view.to_gpu(tile_count, place.origin, place.layer);
        let full = tile_count + tiles > MAX_TILES
            || batch.len() == MAX_VIEWS
            || batch.first().is_some_and(|(v, _): &(GpuView, PendingView<'_>)| {
                v.perspective != gpu_view.perspective
            })
            || (0..2).any(|i| footprints[i] + listed[i] > most_footprints);
        if full && !batch.is_empty() {
            plans.push(Plan::new(std::mem::take(&mut batch), tile_count, casters, config, kept));
            (tile_count, footprints) = (0, [0; 2]);
            gpu_view.first_tile = 0;
        }
        batch.push((gpu_view, *pending));
        tile_count += tiles;
        footprints = [0, 1].map(|i| footprints[i] + listed[i]);
    }
    if !batch.is_empty() {
        plans.push(Plan::new(batch, tile_count, casters, config, kept));
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

impl Plan {
    /// Combinations (caster, view) that are projected, without the host's.
    pub(crate) fn caster_count(&self) -> u64 {
        let uploaded = |list: &ListPlan| {
            list.host.as_ref().map_or(list.footprint_count, |host| host.first_footprint)
        };
        let listed: u64 = self.lists.iter().map(|list| u64::from(uploaded(list))).sum();
        listed + self.small_chunks.iter().map(|chunk| u64::from(chunk.count)).sum::<u64>()
    }

    fn new(
        seen: Vec<(GpuView, PendingView<'_>)>,
        tile_count: u32,
        casters: &CasterSet,
        config: &Config,
        kept: bool,
    ) -> Self {
        let (views, pending): (Vec<_>, Vec<_>) = seen.into_iter().unzip();
        let of_depths = pending.iter().enumerate();
        let depths: Vec<_> =
            of_depths.filter_map(|(i, pending)| Some((i, pending.depth?.clone()))).collect();
        let groups: Vec<_> = pending.iter().map(|pending| pending.groups).collect();
        let none: &[u32] = &[];
        let groups_that_block = pending.iter().map(|p| if p.blocks() { p.groups } else { none });
        let by_list = [groups_that_block.collect(), groups.clone()];
        let perspective = views[0].perspective > 0.0;
        let has_opaque = casters.has(0) || !depths.is_empty();
        let [mut blocking, mut filtering] = [0, 1].map(|i| {
            let (list, groups): (_, &Vec<_>) = (&LISTS[i], &by_list[i]);
            let features = casters.span(list.clone()).features.of_views(perspective, has_opaque);
            ListPlan::new(list, features, casters, groups)
        });
        let is_small = |extent: TriangleExtent, view: &GpuView| extent.is_small(view);
        let small_chunks = blocking.take_triangles(|chunk| {
            let small = casters.triangle_group(chunk.first_caster).triangles;
            small.is_some_and(|extent| is_small(extent, &views[chunk.view as usize]))
        });
        blocking.features.small = !small_chunks.is_empty();
        let tiny_chunks = filtering.tiny(casters, &groups, &views);
        let [blocking_bound, filtering_bound] = LISTS.map(|list| {
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
            let not_blocked = (0..).zip(&pending).filter(|(_, pending)| !pending.blocks());
            not_blocked.for_each(|(view, _)| host.hide(view));
        }
        let dense = filtering.footprint_count >= DENSE * tile_count;
        let features = filtering.features.of_walk(dense, config.queued);
        let softening = config.soften && config.nodes > 0;
        let features = Features { nodes: config.nodes, softening, ..features };
        let lists = [blocking, ListPlan { tiny_chunks, features, ..filtering }];
        Self { views, tile_count, lists, small_chunks, depths, kept, cleared: false, camera: false }
    }

    /// Plan of the camera, with the visible casters of the classes of `list` as the first list.
    #[cfg(feature = "picture")]
    pub(crate) fn of_camera(
        view: GpuView,
        tile_count: u32,
        casters: &CasterSet,
        list: &RangeInclusive<Class>,
    ) -> Self {
        let visible = casters.visible(&view);
        let features = casters.span(list.clone()).features;
        let features = if *list == Class::SOLID {
            features.of_views(false, false)
        } else {
            Features { plain: false, ..features }
        };
        let bound = bound(casters, &[&visible], &[view], |group, _| list.contains(&group.class));
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

impl ListPlan {
    /// Lists the casters of `list` that each view may see.
    fn new(
        list: &RangeInclusive<Class>,
        features: Features,
        casters: &CasterSet,
        visible: &[&[u32]],
    ) -> Self {
        let mut footprint_count = 0;
        let mut chunks_of = |is_triangles| {
            let mut chunks = Vec::new();
            for (view, groups) in (0..).zip(visible) {
                let groups = groups.iter().map(|&group| &casters.groups()[group as usize]);
                for group in groups {
                    if group.is_triangles() == is_triangles && list.contains(&group.class) {
                        let count = group.casters.len() as u32;
                        let (first_caster, first_footprint) =
                            (group.casters.start, footprint_count);
                        chunks.push(Chunk { view, first_caster, count, first_footprint });
                        footprint_count += count;
                    }
                }
            }
            chunks
        };
        let particle_chunks = chunks_of(false);
        let triangle_chunks = chunks_of(true);
        let first_setup = particle_chunks.iter().map(|chunk| chunk.count).sum();
        Self {
            filters: *list == Class::FILTERING,
            camera: false,
            features,
            particle_chunks,
            tiny_chunks: Vec::new(),
            triangle_chunks,
            host: None,
            footprint_count,
            first_setup,
            bound: PairBound::default(),
        }
    }

    /// Those of the particles' chunks that may have tiny particles.
    fn tiny(&self, casters: &CasterSet, visible: &[&[u32]], views: &[GpuView]) -> Vec<Chunk> {
        let groups = casters.groups();
        let extents = visible.iter().flat_map(|visible| {
            let listed = visible.iter().map(|&group| &groups[group as usize]);
            listed
                .filter(|group| group.class == Class::Translucent && !group.is_triangles())
                .map(|group| &group.extent)
        });
        let chunks = self.particle_chunks.iter().zip(extents);
        chunks
            .filter(|(chunk, extent)| extent.may_be_tiny(&views[chunk.view as usize]))
            .map(|(chunk, _)| *chunk)
            .collect()
    }

    /// Removes and returns the triangle chunks that satisfy `is_taken`.
    fn take_triangles(&mut self, is_taken: impl FnMut(&Chunk) -> bool) -> Vec<Chunk> {
        let (taken, mut rest): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.triangle_chunks).into_iter().partition(is_taken);
        self.footprint_count = self.first_setup;
        for chunk in &mut rest {
            chunk.first_footprint = self.footprint_count;
            self.footprint_count += chunk.count;
        }
        self.triangle_chunks = rest;
        taken
    }
}
