//! Light that glass and lit surfaces throw, as look-ups read it.
use crate::{
    frame::Commands,
    gpu::{Memory, Timeline},
};
use wgpu::Buffer;

/// Light that glass throws in the maps of all lights that ask for it, and light that lit surfaces send on.
#[derive(Clone, Debug)]
pub struct Caustics {
    /// For each view its first texel, or 0; then the texels of the views.
    pub texels: Buffer,
    /// First texel of each view, 0 for those without.
    pub firsts: Vec<u32>,
    /// Points that send light on, after a head with their number.
    pub bounces: Buffer,
    pub(super) commands: Commands,
    /// Allocated bytes, by name.
    pub memory: Memory,
}

impl Caustics {
    /// Records the thrown light, after the maps.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, timeline: &mut Timeline) {
        self.commands.record(encoder, timeline);
        timeline.end(encoder);
    }
}
