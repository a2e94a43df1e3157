//! Pipelines of one device, by kernel and by what the batch holds.
use super::Config;
use crate::{
    gpu::{Kernel, KernelDesc, Tier},
    stage::{
        accumulate, bin, filter, hits::Features, occlude, project, resolve, shade, sort::Sort,
    },
};
use std::collections::HashMap;

/// Kernels that are specialised to what a batch holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Variant {
    OccludeTiles,
    OccludeSegments,
    OccludeOverflow,
    AccumulateTiles,
    AccumulateSegments,
    AccumulateTiny,
    AccumulateOverflow,
    ResolveTiles,
    ResolveOpaque,
    ShadeSeen,
    ShadeSurfaces,
    ShadeCasters,
    ShadeLayers,
    ShadeComposite,
}

impl Variant {
    fn desc(self, tier: Tier, features: Features) -> &'static KernelDesc {
        let [core, native] = match self {
            Self::AccumulateTiles if features.plain => {
                [&accumulate::DISC_TILES_CORE, &accumulate::DISC_TILES_NATIVE]
            }
            Self::AccumulateSegments if features.plain => {
                [&accumulate::DISC_SEGMENTS_CORE, &accumulate::DISC_SEGMENTS_NATIVE]
            }
            Self::OccludeTiles => [&occlude::TILES_CORE, &occlude::TILES_NATIVE],
            Self::OccludeSegments => [&occlude::SEGMENTS_CORE, &occlude::SEGMENTS_NATIVE],
            Self::OccludeOverflow => [&occlude::OVERFLOW_CORE, &occlude::OVERFLOW_NATIVE],
            Self::AccumulateTiles => [&accumulate::TILES_CORE, &accumulate::TILES_NATIVE],
            Self::AccumulateSegments => [&accumulate::SEGMENTS_CORE, &accumulate::SEGMENTS_NATIVE],
            Self::AccumulateTiny => [&accumulate::TINY_CORE, &accumulate::TINY_NATIVE],
            Self::AccumulateOverflow => [&accumulate::OVERFLOW_CORE, &accumulate::OVERFLOW_NATIVE],
            Self::ResolveTiles => [&resolve::TILES_CORE, &resolve::TILES_NATIVE],
            Self::ResolveOpaque => [&resolve::OPAQUE_CORE, &resolve::OPAQUE_NATIVE],
            Self::ShadeSeen => [&shade::SEEN_CORE, &shade::SEEN_NATIVE],
            Self::ShadeSurfaces => [&shade::SURFACES_CORE, &shade::SURFACES_NATIVE],
            Self::ShadeCasters => [&shade::CASTERS_LIT; 2],
            Self::ShadeLayers => [&shade::LAYERS_CORE, &shade::LAYERS_NATIVE],
            Self::ShadeComposite => [&shade::COMPOSITE_CORE, &shade::COMPOSITE_NATIVE],
        };
        if tier == Tier::Core { core } else { native }
    }
}

/// Made once; the specialised kernels when a scene first needs them.
#[derive(Debug)]
pub struct Kernels {
    pub(crate) tier: Tier,
    pub(crate) project_particles: Kernel,
    pub(crate) project_triangles: Kernel,
    pub(crate) sort: Sort,
    pub(crate) bin_count: Kernel,
    pub(crate) bin_scan: Kernel,
    pub(crate) bin_emit: Kernel,
    pub(crate) bin_ranges: Kernel,
    pub(crate) bin_segments: Kernel,
    pub(crate) bin_dispatch: Kernel,
    pub(crate) filter_rows: Kernel,
    pub(crate) filter_columns: Kernel,
    variants: HashMap<(Variant, Features), Kernel>,
}

impl Kernels {
    pub(super) fn new(device: &wgpu::Device, config: Config) -> Self {
        let kernel = |desc| Kernel::new(device, desc, &[]);
        Self {
            tier: config.tier,
            project_particles: kernel(&project::PARTICLES),
            project_triangles: kernel(&project::TRIANGLES),
            sort: Sort::new(device, config.sort),
            bin_count: kernel(&bin::COUNT),
            bin_scan: kernel(&bin::SCAN),
            bin_emit: kernel(&bin::EMIT),
            bin_ranges: kernel(&bin::RANGES),
            bin_segments: kernel(&bin::SEGMENTS),
            bin_dispatch: kernel(&bin::DISPATCH),
            filter_rows: kernel(&filter::ROWS),
            filter_columns: kernel(&filter::COLUMNS),
            variants: HashMap::new(),
        }
    }

    /// For `prepare`: makes the kernel where there is none yet.
    pub(crate) fn make(
        &mut self,
        device: &wgpu::Device,
        variant: Variant,
        features: Features,
    ) -> &Kernel {
        let desc = variant.desc(self.tier, features);
        self.variants
            .entry((variant, features))
            .or_insert_with(|| Kernel::new(device, desc, &features.constants(desc.constants)))
    }

    /// For `record`.
    ///
    /// # Panics
    /// Where `prepare` has not made the kernel.
    pub(crate) fn get(&self, variant: Variant, features: Features) -> &Kernel {
        &self.variants[&(variant, features)]
    }
}
