//! How the pipeline runs on a device.
use crate::{gpu::Tier, model::MAX_PAIRS, stage::sort};

/// How the pipeline runs on a device.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    pub tier: Tier,
    pub sort: sort::Shape,
    /// Pairs that one batch may hold; what does not fit takes the scatter path.
    pub pair_budget: u32,
    /// Whether particles of at most 2x2 texels skip sort and bin. Off on software adapters, whose
    /// atomics cost more than their sort.
    pub scatter_tiny: bool,
    /// Whether kernels do in loops what is otherwise written out. On SwiftShader, whose compiler
    /// takes a minute for a kernel otherwise and a second so.
    pub rolled: bool,
    /// Whether subgroups may have more than 32 lanes.
    pub wide: bool,
    /// Whether soft discs wait in a queue of eight, one for each lane of a subgroup; changes no bit.
    /// On software adapters with such subgroups, on the native tier, of a device that has
    /// [`FETCH_FEATURES`](crate::gpu::FETCH_FEATURES).
    pub queued: bool,
    /// Whether dithered surfaces become a grey filter.
    pub soften: bool,
    /// Whether dithered casters block each channel by a threshold of its own.
    pub colored: bool,
    /// Of a curve (K); 0: nearest-depth mode, without curves.
    pub nodes: u32,
    /// Whether the picture is what each pixel costs
    /// ([`read_costs`](super::PreparedPicture::read_costs)).
    pub count_cost: bool,
    /// Whether groups wholly behind an opaque surface are left out, which changes no bit.
    pub hide: bool,
}

impl Config {
    pub fn new(tier: Tier, adapter: &wgpu::AdapterInfo) -> Self {
        Self {
            tier,
            sort: sort::Shape::of(adapter),
            pair_budget: MAX_PAIRS,
            scatter_tiny: adapter.device_type != wgpu::DeviceType::Cpu,
            rolled: adapter.driver.starts_with("SwiftShader"),
            wide: adapter.subgroup_max_size > 32,
            queued: adapter.device_type == wgpu::DeviceType::Cpu
                && [adapter.subgroup_min_size, adapter.subgroup_max_size] == [8, 8],
            soften: false,
            colored: false,
            nodes: 0,
            count_cost: false,
            hide: true,
        }
    }

    /// A curve needs its hits in order: tiny casters go through tiles.
    pub(super) fn scatters(&self) -> bool {
        self.scatter_tiny && self.nodes == 0
    }
}
