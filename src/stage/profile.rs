//! What a device is good at, decided here and nowhere else. A kernel asks for it by overrides and by
//! `choice::` imports; what only llvmpipe needs lies in `wgsl/llvmpipe/` and in [`super::llvmpipe`],
//! and without them nothing but speed is lost.
use super::{llvmpipe, sort::Shape};
use crate::gpu::{Choice, Constant};

/// How work is cut on a device. No choice changes a bit of the maps but for `scatter_tiny`, which
/// moves them by their rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Profile {
    /// How sort and bin cut their lists.
    pub shape: Shape,
    /// Whether particles of at most 2x2 texels skip sort and bin. Not on software adapters, whose
    /// atomics cost more than their sort.
    pub scatter_tiny: bool,
    /// Whether loops over some texels stay loops. On SwiftShader, whose compiler takes a minute for
    /// a kernel otherwise and a second so.
    pub rolled: bool,
    /// Whether subgroups may have more than 32 lanes.
    pub wide: bool,
    /// Whether soft discs wait in a queue of eight, one for each lane of a subgroup. On software
    /// adapters with such subgroups, on the native tier, of a device that has
    /// [`FETCH_FEATURES`](crate::gpu::FETCH_FEATURES).
    pub queued: bool,
    /// Whether tiles go to two cores in turns.
    pub interleaved: bool,
}

impl Profile {
    pub fn of(adapter: &wgpu::AdapterInfo) -> Self {
        let is_software = adapter.device_type == wgpu::DeviceType::Cpu;
        let lanes = [adapter.subgroup_min_size, adapter.subgroup_max_size];
        Self {
            shape: if is_software { Shape::Serial } else { Shape::Wide },
            scatter_tiny: !is_software,
            rolled: adapter.driver.starts_with("SwiftShader"),
            wide: adapter.subgroup_max_size > 32,
            queued: is_software && lanes == [8, 8],
            interleaved: is_software,
        }
    }

    /// Values of overrides.
    pub fn constants(&self) -> [Constant; 2] {
        [("ROLLED", self.rolled), ("WIDE", self.wide)]
            .map(|(name, is)| (name, f64::from(u8::from(is))))
    }

    /// In place of a kernel's own.
    pub fn choices(&self) -> &'static [Choice] {
        if self.interleaved { &[llvmpipe::INTERLEAVED] } else { &[] }
    }
}
