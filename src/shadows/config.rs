//! Configuration of a frame, by its source: the device, the host, and tests.
use crate::{
    gpu::Tier,
    model::{CurveMemory, ShadowSettings},
    stage::tuning::Tuning,
};

/// Configuration of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// Tier of the device.
    pub tier: Tier,
    /// Profile of the adapter.
    pub tuning: Tuning,
    /// Settings of the host, with a pair budget within the device's limits.
    pub settings: ShadowSettings,
    /// Choices of tests and of the renderer.
    pub toggles: Toggles,
}

/// Choices of tests and of the renderer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Toggles {
    /// Whether filtering lists with more pairs than fit are walked in parts of their tiles; otherwise the
    /// casters that do not fit are scattered.
    pub parts: bool,
    /// Whether the sums of filtering casters are kept ([`Maps::sums`](super::Maps::sums)) instead of filters,
    /// to merge the maps of shares of the casters.
    pub sums: bool,
    /// Whether tiny particles are scattered: the tuning's value at first.
    pub scatter_tiny: bool,
    /// Whether discs are collected in a queue, if the device can: the tuning's value at first.
    pub queued: bool,
    /// Whether groups wholly behind an opaque surface are culled, which changes no bit.
    pub hide: bool,
    /// Whether pictures count the cost of each pixel.
    pub count_cost: bool,
    /// Whether `prepare` counts the pairs of lists if their number is unknown: it then submits and waits, and
    /// compiles only kernels that are needed.
    pub count_first: bool,
}

impl Config {
    /// The usual configuration on an adapter.
    pub fn new(tier: Tier, adapter: &wgpu::AdapterInfo) -> Self {
        let tuning = Tuning::of(adapter);
        let toggles = Toggles {
            parts: true,
            sums: false,
            scatter_tiny: tuning.scatter_tiny,
            queued: tuning.queued,
            hide: true,
            count_cost: false,
            count_first: false,
        };
        Self { tier, tuning, settings: ShadowSettings::default(), toggles }
    }

    /// Nodes of a curve (K); 0 without curves.
    pub(super) fn nodes(&self) -> u32 {
        self.settings.curve_nodes()
    }

    /// Whether curves may be in pages.
    pub(super) fn counts_curves(&self) -> bool {
        let settings = &self.settings;
        let is_counted = settings.curve_memory == CurveMemory::Counted && self.nodes() > 0;
        is_counted && settings.blur == 0 && !settings.soften && !self.toggles.sums
    }

    /// Whether tiny particles are scattered. With curves they go through tiles, because a curve needs its
    /// hits in order.
    pub(super) fn scatters(&self) -> bool {
        (self.toggles.scatter_tiny || self.toggles.sums) && self.nodes() == 0
    }
}
