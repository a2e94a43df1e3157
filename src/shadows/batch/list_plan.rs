//! The casters that a list of a batch projects.
use crate::shadows::{
    batch::scratch::Scratch,
    casters::{CasterSet, group::CasterKind, host_casters::planes, host_kinds::HostKinds},
    cull::PairBound,
};
use crate::{
    model::{Class, tiles_of},
    records::{
        BRICK_SEGMENT, CURVE_SEGMENT, GAUSSIAN_TEXELS, GpuView, ORDERED_SEGMENT, SETUP_TEXELS,
    },
    stage::{
        bin::{self, SEGMENT_LENGTH},
        buckets::BUCKET_TILE,
        features::{Features, Flags},
        light_points::ROUND_LENGTH,
        project::Chunk,
        sort::Partition,
        tuning::Tuning,
    },
};
use glam::Vec4;
use std::ops::{Range, RangeInclusive};

/// The casters of one list of a batch, as they are projected.
#[derive(Clone, Debug)]
pub struct ListPlan {
    /// Whether its casters filter light in shadow views.
    pub filters: bool,
    /// Whether it is a list of the camera.
    pub camera: bool,
    pub features: Features,
    /// Chunks of Gaussians, particles and triangles.
    pub chunks: [Vec<Chunk>; 3],
    /// Chunks of particles that may have some on the scatter path.
    pub tiny_chunks: Vec<Chunk>,
    /// Host casters, whose number only the device knows.
    pub(crate) host: Option<HostList>,
    /// Footprints of Gaussians, of particles, of triangles, then the capacity of the host's casters.
    pub footprint_count: u32,
    /// Number of Gaussians' footprints.
    pub gaussian_count: u32,
    /// Footprint of the first triangle.
    pub first_setup: u32,
    /// Upper bound of its pairs.
    pub bound: PairBound,
    /// Pairs that it is expected to need at most, by earlier frames.
    pub(crate) expected: Option<u32>,
    /// Whether no tile had several segments in earlier frames.
    pub(crate) had_short_tiles: bool,
}

impl ListPlan {
    /// Lists the casters of `list` that each view may see.
    pub(in crate::shadows) fn new(
        list: &RangeInclusive<Class>,
        features: Features,
        casters: &CasterSet,
        visible: &[&[u32]],
    ) -> Self {
        let mut footprint_count = 0;
        let mut chunks_of = |kind| {
            let mut chunks = Vec::new();
            for (view, groups) in (0..).zip(visible) {
                let groups = groups.iter().map(|&group| &casters.groups()[group as usize]);
                for group in groups {
                    if group.kind() == kind && list.contains(&group.class) {
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
        let chunks = [CasterKind::Gaussians, CasterKind::Particles, CasterKind::Triangles]
            .map(&mut chunks_of);
        let count = |chunks: &Vec<Chunk>| chunks.iter().map(|chunk| chunk.count).sum::<u32>();
        let [gaussian_count, particle_count, _] = chunks.each_ref().map(count);
        Self {
            filters: *list == Class::FILTERING,
            camera: false,
            features,
            chunks,
            tiny_chunks: Vec::new(),
            host: None,
            footprint_count,
            gaussian_count,
            first_setup: gaussian_count + particle_count,
            bound: PairBound::default(),
            expected: None,
            had_short_tiles: false,
        }
    }

    /// Chunks of particles that may have tiny ones.
    pub(in crate::shadows) fn tiny(
        &self,
        casters: &CasterSet,
        visible: &[&[u32]],
        views: &[GpuView],
    ) -> Vec<Chunk> {
        let groups = casters.groups();
        let extents = visible.iter().flat_map(|visible| {
            let listed = visible.iter().map(|&group| &groups[group as usize]);
            listed
                .filter(|group| {
                    group.class == Class::Translucent && group.kind() == CasterKind::Particles
                })
                .map(|group| &group.extent)
        });
        let [_, particles, _] = &self.chunks;
        let chunks = particles.iter().zip(extents);
        chunks
            .filter(|(chunk, extent)| extent.may_be_tiny(&views[chunk.view as usize]))
            .map(|(chunk, _)| *chunk)
            .collect()
    }

    /// Removes and returns the triangle chunks that satisfy `is_taken`.
    pub(in crate::shadows) fn take_triangles(
        &mut self,
        is_taken: impl FnMut(&Chunk) -> bool,
    ) -> Vec<Chunk> {
        let [.., triangles] = &mut self.chunks;
        let (taken, mut rest): (Vec<_>, Vec<_>) =
            std::mem::take(triangles).into_iter().partition(is_taken);
        self.footprint_count = self.first_setup;
        for chunk in &mut rest {
            chunk.first_footprint = self.footprint_count;
            self.footprint_count += chunk.count;
        }
        *triangles = rest;
        taken
    }

    /// Whether the commands of this list serve `other`, too: see
    /// [`BatchPlan::is_alike`](super::batch_plan::BatchPlan::is_alike).
    pub(crate) fn is_alike(
        &self,
        other: &Self,
        tuning: &Tuning,
        scratch: &Scratch,
        tile_count: u32,
    ) -> bool {
        let (partition, capacity) = (tuning.partition, scratch.pair_capacity);
        let decided = |list: &Self| {
            let chunk_counts = (list.chunks.each_ref().map(Vec::len), list.tiny_chunks.len());
            (
                (list.filters, list.camera, list.features, chunk_counts),
                (list.footprint_count, list.gaussian_count, list.first_setup),
                (list.has_segments(tuning), scratch.has_buckets(list, tuning)),
                (list.may_overflow(partition, capacity), list.may_part(partition, capacity)),
                list.most_parts(scratch.part_room, tile_count),
                list.host.as_ref().map(HostList::shape),
            )
        };
        decided(self) == decided(other)
    }

    /// Whether segments are composed one by one.
    pub(crate) fn is_composed(&self) -> bool {
        self.filters && self.features.is_composed()
    }

    /// Whether sums that are kept are made tile by tile; else all casters are scattered.
    pub(crate) fn sums_in_tiles(&self) -> bool {
        self.filters && self.features.nodes == 0 && !self.is_composed()
    }

    /// Pairs that one workgroup walks at a time.
    pub(crate) fn segment_length(&self, tuning: &Tuning) -> u32 {
        match self.features {
            _ if self.camera => ROUND_LENGTH,
            Features { nodes: 1.., flags, .. } if flags.contains(Flags::HAS_BRICKS) => {
                BRICK_SEGMENT
            }
            Features { nodes: 1.., flags, .. }
                if flags.intersects(Flags::HAS_OVER | Flags::HAS_VOLUMES) =>
            {
                ORDERED_SEGMENT
            }
            Features { nodes: 1.., .. } => CURVE_SEGMENT,
            features if features.has(Flags::QUEUED) || features.is_plain() => tuning.disc_segment,
            _ => SEGMENT_LENGTH,
        }
    }

    /// Whether a tile may have more pairs than a segment.
    pub(crate) fn has_segments(&self, tuning: &Tuning) -> bool {
        self.bound.of_tile > self.segment_length(tuning)
    }

    /// Pairs of the buckets that it may be binned by; 0 if it may not.
    pub(crate) fn bucket_room(&self, tuning: &Tuning, capacity: u32) -> u64 {
        let bound = &self.bound;
        let is_few = bound.pairs <= u64::from(tuning.bucket_pairs.min(capacity))
            && (bound.of_tile <= BUCKET_TILE || self.had_short_tiles)
            && tuning.partition == Partition::Wide;
        if is_few && !self.camera && self.host.is_none() { bound.pairs } else { 0 }
    }

    /// Whether some footprints' pairs may not fit.
    pub(crate) fn may_overflow(&self, partition: Partition, capacity: u32) -> bool {
        let of_caster = u64::from(self.bound.of_caster);
        // Rows of outlines take turns of their own.
        let outlined = self.features.has(Flags::HAS_GAUSSIANS);
        let turns = if outlined { 3 * of_caster + 2 } else { of_caster };
        let of_run = u64::from(bin::run_length(self.footprint_count)) * turns;
        let is_long = partition == Partition::Serial && of_run > u64::from(bin::RUN_PAIRS);
        self.bound.pairs > u64::from(capacity) || is_long
    }

    /// Whether the list goes through parts of its tiles where its pairs do not fit. Lists that block light
    /// scatter what does not fit, which changes no bit, and the picture is binned in parts of its own.
    /// A list has no parts while the pairs of earlier frames fit with room to spare, because each part is
    /// recorded, needed or not. Composed lists always have them: scattered casters are out of order.
    pub(crate) fn may_part(&self, partition: Partition, capacity: u32) -> bool {
        let may_scatter = self.host.is_some() || !self.is_composed();
        let fits = may_scatter && self.expected.is_some_and(|pairs| pairs <= capacity);
        self.filters && !self.camera && !fits && self.may_overflow(partition, capacity)
    }

    /// Least room for the pairs of a part: for the pairs of any tile, and enough that parts are few.
    pub(crate) fn part_room(&self) -> u64 {
        const USUAL: u64 = 1 << 18;
        u64::from(self.bound.of_tile.min(self.footprint_count)).max(USUAL.min(self.bound.pairs))
    }

    /// Number of recorded parts of the tiles, with room for `room` pairs in each.
    pub(crate) fn most_parts(&self, room: u32, tile_count: u32) -> u32 {
        /// Each part is recorded, needed or not, and the pairs of the host's casters have no useful bound.
        const MAX: u64 = 512;
        const MAX_HOST_PARTS: u64 = 32;
        let most = if self.host.is_some() { MAX_HOST_PARTS } else { MAX };
        // Two consecutive parts together have more pairs than one has room for.
        let enough = self.bound.pairs / u64::from(room.max(1)) * 2 + 2;
        enough.min(u64::from(tile_count) + 1).min(most) as u32
    }

    /// Setups of triangles, plus those whose room uploaded and host Gaussians take.
    pub(crate) fn setup_count(&self) -> u32 {
        let end = self.host.as_ref().map_or(self.footprint_count, |host| host.first_footprint);
        let of_host = self.host.as_ref().filter(|host| host.kinds.gaussians);
        // Their setups begin at a whole one.
        let of_host = of_host.map_or(0, |_| gaussian_room(self.footprint_count - end + 1));
        self.gaussian_setups() + end - self.first_setup + of_host
    }

    /// Footprint with the host's Gaussian setup 0, modulo 2^32: host setups are behind all others.
    pub(crate) fn host_setup_origin(&self) -> u32 {
        self.host.as_ref().map_or(0, |host| {
            let before = self.gaussian_setups() + host.first_footprint - self.first_setup;
            let texels = u64::from(before) * u64::from(SETUP_TEXELS);
            host.first_footprint.wrapping_sub(texels.div_ceil(GAUSSIAN_TEXELS.into()) as u32)
        })
    }

    /// Number of triangle setups whose room the Gaussians before them take.
    pub(crate) fn gaussian_setups(&self) -> u32 {
        gaussian_room(self.gaussian_count)
    }

    /// Footprint with setup 0, modulo 2^32.
    pub fn setup_origin(&self) -> u32 {
        self.first_setup.wrapping_sub(self.gaussian_setups())
    }

    /// Expected number of footprints: a host caster is seldom visible in more than two views of a batch.
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
            kinds: span.kinds,
            planes: planes(views, span.kinds),
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

/// Number of triangle setups whose room `count` setups of Gaussians take.
fn gaussian_room(count: u32) -> u32 {
    let texels = u64::from(count) * u64::from(GAUSSIAN_TEXELS);
    texels.div_ceil(SETUP_TEXELS.into()) as u32
}

/// Host casters of a list.
#[derive(Clone, Debug)]
pub(crate) struct HostList {
    pub groups: Range<u32>,
    pub kinds: HostKinds,
    /// Six frustum planes of each view.
    pub planes: Vec<Vec4>,
    pub first_footprint: u32,
    /// Most casters that a view may see.
    pub capacity: u32,
}

impl HostList {
    /// All but the planes.
    fn shape(&self) -> (Range<u32>, u32, u32, usize) {
        (self.groups.clone(), self.first_footprint, self.capacity, self.planes.len())
    }

    /// Number of (view, group) combinations.
    pub(crate) fn entry_count(&self) -> u32 {
        self.view_count() * self.groups.len() as u32
    }

    /// Hides all groups from the view.
    pub(crate) fn hide(&mut self, view: usize) {
        self.planes[6 * view] = Vec4::NEG_W;
    }

    pub(crate) fn view_count(&self) -> u32 {
        (self.planes.len() / 6) as u32
    }
}
