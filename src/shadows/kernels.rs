//! Pipelines of one device, by kernel and by features of the batch.
use super::{
    Config,
    frame::{Role, variants},
};
use crate::{
    gpu::{Constant, Kernel, KernelCache, KernelDesc, KernelError, Resources, Tier},
    stage::{
        air, bin, blur, cluster, colored, features::Features, filter, import, levels, llvmpipe,
        load, mask, occlude, profile::Profile, shade, sort::Sort,
    },
};
use std::{
    collections::{HashMap, hash_map::Entry},
    sync::OnceLock,
};

/// Kernels that are specialised to the features of a batch.
#[cfg_attr(not(feature = "picture"), allow(dead_code, reason = "some are the picture's"))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Variant {
    OccludeTiles,
    OccludeSegments,
    OccludeOverflow,
    ColoredTiles,
    ColoredSegments,
    ColoredOverflow,
    ColoredResolve,
    AccumulateTiles,
    AccumulateSegments,
    AccumulateTiny,
    AccumulateOverflow,
    ResolveTiles,
    ResolveOpaque,
    AirScatter,
    CurveColumns,
    BlurNearRows,
    BlurCurveRows,
    BlurCurveColumns,
    ShadeClip,
    ShadeSeen,
    ShadeLayered,
    ShadeLayers,
    ShadeSurfaces,
    ShadePanes,
    ShadeCasters,
    LightPoints,
    LightShares,
    ShadeComposite,
    FirstLevel,
    NextLevel,
    MaskSurfaces,
    HalfMaskSurfaces,
    HostSurfaces,
    HalfHostSurfaces,
    MaskLookUp,
    MaskBlur,
    MaskEnlarge,
}

impl Variant {
    fn desc(self, features: Features) -> &'static KernelDesc {
        let queued = features.nodes == 0 && features.queued;
        match self {
            Self::AccumulateTiles if queued => &llvmpipe::DISC_QUEUE_TILES,
            Self::AccumulateSegments if queued => &llvmpipe::DISC_QUEUE_SEGMENTS,
            Self::OccludeTiles => variants(Role::Tiles, false).choose(features),
            Self::OccludeSegments => variants(Role::Segments, false).choose(features),
            Self::OccludeOverflow => variants(Role::Overflow, false).choose(features),
            Self::ResolveOpaque => variants(Role::Resolve, false).choose(features),
            Self::AccumulateTiny => variants(Role::Tiny, true).choose(features),
            Self::AccumulateTiles => variants(Role::Tiles, true).choose(features),
            Self::AccumulateSegments => variants(Role::Segments, true).choose(features),
            Self::AccumulateOverflow => variants(Role::Overflow, true).choose(features),
            Self::ResolveTiles => variants(Role::Resolve, true).choose(features),
            Self::ColoredTiles => &colored::TILES,
            Self::ColoredSegments => &colored::SEGMENTS,
            Self::ColoredOverflow => &colored::OVERFLOW,
            Self::ColoredResolve => &colored::RESOLVE,
            Self::AirScatter if features.areas => &air::AREA_SCATTER,
            Self::AirScatter => &air::SCATTER,
            Self::CurveColumns => &filter::CURVE_COLUMNS,
            Self::BlurNearRows => &blur::NEAR_ROWS,
            Self::BlurCurveRows => &blur::CURVE_ROWS,
            Self::BlurCurveColumns => &blur::CURVE_COLUMNS,
            Self::ShadeClip => &shade::CLIP,
            Self::ShadeSeen => &shade::SEEN,
            Self::ShadeLayered => &shade::LAYERED,
            Self::ShadeLayers => &shade::LAYERS,
            Self::ShadeSurfaces => &shade::SURFACES,
            Self::ShadePanes => &shade::PANES,
            Self::ShadeCasters => &shade::CASTERS,
            Self::LightPoints if features.areas && features.masks => {
                &shade::AREA_MASKED_LIGHT_POINTS
            }
            Self::LightPoints if features.masks => &shade::MASKED_LIGHT_POINTS,
            Self::LightPoints if features.areas => &shade::AREA_LIGHT_POINTS,
            Self::LightShares if features.areas => &shade::AREA_LIGHT_SHARES,
            Self::LightPoints => &shade::LIGHT_POINTS,
            Self::LightShares => &shade::LIGHT_SHARES,
            Self::ShadeComposite => &shade::COMPOSITE,
            Self::FirstLevel => &levels::FIRST,
            Self::NextLevel => &levels::NEXT,
            Self::MaskSurfaces => &mask::SURFACES,
            Self::HalfMaskSurfaces => &mask::HALF_SURFACES,
            Self::HostSurfaces => &mask::HOST_SURFACES,
            Self::HalfHostSurfaces => &mask::HALF_HOST_SURFACES,
            Self::MaskLookUp if features.areas => &mask::AREA_LOOK_UP,
            Self::MaskLookUp => &mask::LOOK_UP,
            Self::MaskBlur => &mask::BLUR,
            Self::MaskEnlarge => &mask::ENLARGE,
        }
    }
}

/// A kernel that is planned when something is first bound to it.
#[derive(Debug)]
pub(crate) struct OnDemand {
    desc: &'static KernelDesc,
    tier: Tier,
    constants: Vec<Constant>,
    cache: KernelCache,
    planned: OnceLock<Kernel>,
}

impl OnDemand {
    /// Bindings of the kernel, for `prepare`.
    pub(crate) fn bind(
        &self,
        device: &wgpu::Device,
        resources: &Resources<'_>,
    ) -> Result<wgpu::BindGroup, KernelError> {
        let kernel = match self.planned.get() {
            Some(kernel) => kernel,
            None => {
                let Self { desc, tier, constants, cache, .. } = self;
                let kernel = cache.plan(device, desc, *tier, &[], constants)?;
                self.planned.get_or_init(|| kernel)
            }
        };
        kernel.bind(device, resources)
    }

    /// `bindings` are the kernel's own, so it has been planned.
    pub(crate) fn record(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bindings: &wgpu::BindGroup,
        groups: [u32; 3],
    ) {
        if let Some(kernel) = self.planned.get() {
            kernel.record(pass, bindings, groups);
        }
    }

    /// As [`Self::record`], with workgroup counts of a buffer.
    pub(crate) fn record_indirect(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bindings: &wgpu::BindGroup,
        counts: &wgpu::Buffer,
        offset: u64,
    ) {
        if let Some(kernel) = self.planned.get() {
            kernel.record_indirect(pass, bindings, counts, offset);
        }
    }
}

/// The kernels of one pipeline, each compiled when a scene first needs it.
#[cfg_attr(not(feature = "picture"), allow(dead_code, reason = "some are the picture's"))]
#[derive(Debug)]
pub struct Kernels {
    pub(crate) tier: Tier,
    pub(crate) cull_groups: OnDemand,
    pub(crate) project_particles: OnDemand,
    pub(crate) project_triangles: OnDemand,
    pub(crate) import_depths: OnDemand,
    pub(crate) occlude_small: OnDemand,
    pub(crate) sort: Sort,
    pub(crate) bin_count: OnDemand,
    pub(crate) bin_scan: OnDemand,
    pub(crate) bin_emit: OnDemand,
    pub(crate) bin_tiles: OnDemand,
    pub(crate) part_count: OnDemand,
    pub(crate) part_plan: OnDemand,
    pub(crate) part_next: OnDemand,
    pub(crate) part_gather: OnDemand,
    pub(crate) air_sum: OnDemand,
    pub(crate) cluster_count: OnDemand,
    pub(crate) cluster_scan: OnDemand,
    pub(crate) cluster_emit: OnDemand,
    pub(crate) filter_rows: OnDemand,
    pub(crate) filter_columns: OnDemand,
    pub(crate) curve_rows: OnDemand,
    pub(crate) colored_rows: OnDemand,
    pub(crate) colored_columns: OnDemand,
    pub(crate) blur_near_columns: OnDemand,
    pub(crate) blur_rows: OnDemand,
    pub(crate) blur_columns: OnDemand,
    pub(crate) filter_mip: OnDemand,
    pub(crate) profile: Profile,
    variants: HashMap<(Variant, Features), Kernel>,
    cache: KernelCache,
}

impl Kernels {
    pub(crate) fn new(config: Config, cache: KernelCache) -> Self {
        let Profile { shape, .. } = config.profile;
        let make = |desc, constants| OnDemand {
            desc,
            tier: config.tier,
            constants,
            cache: cache.clone(),
            planned: OnceLock::new(),
        };
        let kernel = |desc| make(desc, Vec::new());
        let of_list = |role| kernel(variants(role, false).otherwise);
        let of_bin = |role| make(variants(role, false).otherwise, vec![bin::workgroup_size(shape)]);
        Self {
            tier: config.tier,
            cull_groups: kernel(&load::GROUPS),
            project_particles: of_list(Role::ProjectParticles),
            project_triangles: of_list(Role::ProjectTriangles),
            import_depths: kernel(&import::DEPTHS),
            occlude_small: kernel(&occlude::SMALL),
            sort: Sort::sharing(shape, cache.clone()),
            bin_count: of_bin(Role::BinCount),
            bin_scan: of_list(Role::BinScan),
            bin_emit: of_bin(Role::BinEmit),
            bin_tiles: of_list(Role::BinTiles),
            part_count: kernel(&bin::PART_COUNT),
            part_plan: kernel(&bin::PART_PLAN),
            part_next: kernel(&bin::PART_NEXT),
            part_gather: kernel(&bin::PART_GATHER),
            air_sum: kernel(&air::SUM),
            cluster_count: kernel(&cluster::COUNT),
            cluster_scan: kernel(&cluster::SCAN),
            cluster_emit: kernel(&cluster::EMIT),
            filter_rows: kernel(&filter::ROWS),
            filter_columns: kernel(&filter::COLUMNS),
            curve_rows: kernel(&filter::CURVE_ROWS),
            colored_rows: kernel(&colored::ROWS),
            colored_columns: kernel(&colored::COLUMNS),
            blur_near_columns: kernel(&blur::NEAR_COLUMNS),
            blur_rows: kernel(&blur::ROWS),
            blur_columns: kernel(&blur::COLUMNS),
            filter_mip: kernel(&blur::FILTER_MIP),
            profile: config.profile,
            variants: HashMap::new(),
            cache,
        }
    }

    /// Specialises kernels that are planned from now on to another profile of the same shape.
    pub(crate) fn follow(&mut self, profile: Profile) {
        debug_assert_eq!(profile.shape, self.profile.shape, "other kernels than variants have it");
        if profile != self.profile {
            self.profile = profile;
            self.variants.clear();
        }
    }

    /// Plans a kernel, for `prepare`, which ends with [`Self::finish`].
    pub(crate) fn plan(
        &mut self,
        device: &wgpu::Device,
        variant: Variant,
        features: Features,
    ) -> Result<&Kernel, KernelError> {
        match self.variants.entry((variant, features)) {
            Entry::Occupied(planned) => Ok(planned.into_mut()),
            Entry::Vacant(place) => {
                let mut constants = features.constants();
                constants.extend(self.profile.constants());
                let desc = variant.desc(features);
                Ok(place.insert(self.cache.plan(
                    device,
                    desc,
                    self.tier,
                    self.profile.choices(),
                    &constants,
                )?))
            }
        }
    }

    /// Kernel of a list that is not specialised to its casters.
    pub(crate) fn of_list(&self, role: Role) -> Option<&OnDemand> {
        match role {
            Role::ProjectParticles => Some(&self.project_particles),
            Role::ProjectTriangles => Some(&self.project_triangles),
            Role::BinCount => Some(&self.bin_count),
            Role::BinScan => Some(&self.bin_scan),
            Role::BinEmit => Some(&self.bin_emit),
            Role::BinTiles => Some(&self.bin_tiles),
            Role::Tiny | Role::Overflow | Role::Tiles | Role::Segments | Role::Resolve => None,
        }
    }

    /// Compiles all planned kernels.
    pub(crate) fn finish(&self) -> Result<(), KernelError> {
        self.cache.finish()
    }

    pub(crate) fn cache(&self) -> &KernelCache {
        &self.cache
    }

    /// A kernel that no frame needs.
    pub(crate) fn other(
        &self,
        device: &wgpu::Device,
        desc: &KernelDesc,
        constants: &[Constant],
    ) -> Result<Kernel, KernelError> {
        self.cache.kernel(device, desc, self.tier, &[], constants)
    }

    /// A planned kernel, for `record`.
    ///
    /// # Panics
    /// If `prepare` has not planned the kernel.
    pub(crate) fn get(&self, variant: Variant, features: Features) -> &Kernel {
        &self.variants[&(variant, features)]
    }
}
