//! Configuration of a frame, by who chooses: the device, the host, and tests.
use crate::{gpu::Tier, model::ShadowSettings, stage::tuning::Tuning};

/// Configuration of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// The device's.
    pub tier: Tier,
    /// The adapter's.
    pub tuning: Tuning,
    /// The host's; the pair budget within what the device has.
    pub settings: ShadowSettings,
    /// Those of tests and the renderer.
    pub toggles: Toggles,
}

/// Ways of working that tests and the renderer choose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Toggles {
    /// Whether filtering lists with more pairs than fit are walked a part of their tiles at a time;
    /// otherwise the casters that do not fit are scattered.
    pub parts: bool,
    /// Whether all filtering casters are scattered, and their sums kept as they are
    /// ([`Maps::sums`](super::Maps::sums)) instead of filters: maps of shares of the casters are merged from
    /// them.
    pub sums: bool,
    /// Whether tiny particles are scattered: the tuning's value at first.
    pub scatter_tiny: bool,
    /// Whether discs are collected in a queue, if the device can: the tuning's value at first.
    pub queued: bool,
    /// Whether groups wholly behind an opaque surface are culled, which changes no bit.
    pub hide: bool,
    /// Whether pictures count the cost of each pixel.
    pub count_cost: bool,
    /// Whether `prepare` counts the pairs of lists, if that is not known: it then submits and waits, and
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

    /// Whether tiny particles are scattered. A curve needs its hits in order: with curves they go through
    /// tiles.
    pub(super) fn scatters(&self) -> bool {
        (self.toggles.scatter_tiny || self.toggles.sums) && self.nodes() == 0
    }
}
