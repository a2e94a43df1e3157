//! Configuration of the pipeline on a device.
use crate::{gpu::Tier, model::MAX_PAIRS, stage::profile::Profile};

/// Configuration of the pipeline on a device.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    pub tier: Tier,
    pub profile: Profile,
    /// Pair capacity of one batch. Filtering lists with more pairs are walked a part of their tiles at a time.
    pub pair_budget: u32,
    /// Whether they are; otherwise casters past the budget are scattered, as tests of that path ask.
    pub parts: bool,
    /// The profile's value, or a test's.
    pub scatter_tiny: bool,
    /// The profile's value, or a test's.
    pub queued: bool,
    /// Whether dithered surfaces become a grey filter.
    pub soften: bool,
    /// Whether dithered casters use a threshold of their own per channel.
    pub colored: bool,
    /// Radius of the window over which filters and curves are blurred; 0 for none [texels].
    pub blur: u32,
    /// Smaller levels of the filter map.
    pub mips: u32,
    /// Nodes of a curve (K); 0: nearest-depth mode, without curves.
    pub nodes: u32,
    /// Whether the picture counts the cost of each pixel
    /// ([`read_costs`](crate::shadows::PreparedPicture::read_costs)).
    pub count_cost: bool,
    /// Whether groups wholly behind an opaque surface are culled, which changes no bit.
    pub hide: bool,
    /// Whether `prepare` counts the pairs of lists, if that is not known: it then submits and waits, and
    /// compiles only kernels that are needed.
    pub count_first: bool,
}

impl Config {
    pub fn new(tier: Tier, adapter: &wgpu::AdapterInfo) -> Self {
        let profile = Profile::of(adapter);
        Self {
            tier,
            profile,
            pair_budget: MAX_PAIRS,
            parts: true,
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

    /// Whether tiny particles are scattered. A curve needs its hits in order: with curves they go through
    /// tiles.
    pub(super) fn scatters(&self) -> bool {
        self.scatter_tiny && self.nodes == 0
    }
}
