//! How the pipeline runs on a device.
use crate::{gpu::Tier, model::MAX_PAIRS, stage::profile::Profile};

/// How the pipeline runs on a device.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    pub tier: Tier,
    pub profile: Profile,
    /// Pairs that one batch may hold; what does not fit takes the scatter path.
    pub pair_budget: u32,
    /// As the profile says, or a test.
    pub scatter_tiny: bool,
    /// As the profile says, or a test.
    pub queued: bool,
    /// Whether dithered surfaces become a grey filter.
    pub soften: bool,
    /// Whether dithered casters block each channel by a threshold of its own.
    pub colored: bool,
    /// Radius of the window over which filters and curves are blurred; 0 for none [texels].
    pub blur: u32,
    /// Smaller levels of the filter map.
    pub mips: u32,
    /// Nodes of a curve (K); 0: nearest-depth mode, without curves.
    pub nodes: u32,
    /// Whether the picture is what each pixel costs
    /// ([`read_costs`](super::PreparedPicture::read_costs)).
    pub count_cost: bool,
    /// Whether groups wholly behind an opaque surface are left out, which changes no bit.
    pub hide: bool,
    /// Whether `prepare` counts what lists make, where that is not known: it then submits and waits,
    /// and makes no kernel that nothing needs.
    pub count_first: bool,
}

impl Config {
    pub fn new(tier: Tier, adapter: &wgpu::AdapterInfo) -> Self {
        let profile = Profile::of(adapter);
        Self {
            tier,
            profile,
            pair_budget: MAX_PAIRS,
            scatter_tiny: profile.scatter_tiny,
            queued: profile.queued,
            soften: false,
            colored: false,
            blur: 0,
            mips: 0,
            nodes: 0,
            count_cost: false,
            hide: true,
            count_first: false,
        }
    }

    /// A curve needs its hits in order: tiny casters go through tiles.
    pub(super) fn scatters(&self) -> bool {
        self.scatter_tiny && self.nodes == 0
    }
}
