//! Prepared maps of a frame.
use super::{
    ListCounters, Maps,
    batch::scratch::Scratch,
    casters::host_casters::HostSets,
    read_back::ReadBack,
    smoothing::{blur::Blur, soften::Soften},
    views::cache::MapCache,
};
use crate::{
    error::Error,
    frame::Commands,
    gpu::{Memory, Timeline},
    records::LoadCounters,
};
use std::sync::Arc;

/// Counters of opaque lists, of translucent ones, and of the host's casters.
pub(super) type AllCounters = ((ListCounters, ListCounters), LoadCounters);

/// A scene's maps on the GPU, and the commands that fill them.
#[derive(Debug)]
pub struct PreparedMaps {
    pub maps: Maps,
    /// From casters to the maps of all views that must be rendered.
    pub commands: Commands,
    /// From casters to the number of their pairs.
    pub counting: Commands,
    /// Counters of each batch.
    pub(super) counters: Vec<[ReadBack<ListCounters>; 2]>,
    pub(super) host: Option<Arc<HostSets>>,
    pub(super) soften: Option<Soften>,
    pub(super) blur: Option<Blur>,
    pub(super) scratch: Arc<Scratch>,
    pub(super) cache: MapCache,
    pub(super) culled: u64,
    pub(super) maps_memory: Memory,
    pub(super) scratch_memory: Memory,
    /// Bytes by buffer and texture.
    pub memory: Memory,
}

impl PreparedMaps {
    pub(super) fn is_colored(&self) -> bool {
        self.soften.as_ref().map_or(&self.maps, |soften| &soften.raw).colored.is_some()
    }

    /// Pair capacity of a batch.
    pub fn pair_capacity(&self) -> u32 {
        self.scratch.pair_capacity
    }

    /// Views that [`Self::record`] renders; the others are kept.
    pub fn rendered_count(&self) -> usize {
        self.cache.pending.len()
    }

    pub fn view_count(&self) -> usize {
        self.cache.view_count()
    }

    /// Combinations (caster, view) that are not projected: their groups are outside the view or wholly
    /// behind an opaque surface.
    pub fn culled_count(&self) -> u64 {
        self.culled
    }

    /// Culled combinations that are behind an opaque surface.
    pub fn hidden_count(&self) -> u64 {
        self.cache.hidden_count()
    }

    /// Makes the next [`Pipeline::prepare_again`] render the same views again, for instance because pairs
    /// did not fit.
    pub fn forget(&mut self) {
        self.cache.forget();
    }

    /// Records every stage of every view that must be rendered.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, timeline: &mut Timeline) {
        self.commands.record(encoder, timeline);
        self.cache.mark_recorded();
    }

    /// Counters of the last frame: of opaque lists and of translucent ones, each summed over the batches,
    /// and of the host's casters. Blocks.
    pub(super) fn read_all_counters(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<AllCounters, Error> {
        let loaded = self.loaded().map(|counted| counted.read(device, queue)).transpose()?;
        let lists = self.sum(|counted| counted.read(device, queue))?;
        Ok((lists, loaded.unwrap_or_default()))
    }

    /// Counters of the last frame, `(opaque, translucent)`, summed over the batches. Blocks.
    pub fn read_counters(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<(ListCounters, ListCounters), Error> {
        self.sum(|counted| counted.read(device, queue))
    }

    pub(super) fn record_statistics(&self, encoder: &mut wgpu::CommandEncoder) {
        self.counted().flatten().for_each(|counted| counted.record(encoder));
        if let Some(counted) = self.loaded() {
            counted.record(encoder);
        }
    }

    /// Whether [`Self::take_statistics`] has the recorded counters.
    pub(super) fn has_statistics(&self) -> bool {
        // Polls all, so that all start mapping.
        let loaded = self.loaded().is_none_or(ReadBack::is_ready);
        let lists = self.counted().flatten().filter(|counted| !counted.is_ready()).count() == 0;
        loaded && lists
    }

    pub(super) fn take_statistics(&self) -> Result<AllCounters, Error> {
        let loaded = self.loaded().map(ReadBack::take).transpose()?;
        Ok((self.sum(ReadBack::take)?, loaded.unwrap_or_default()))
    }

    fn counted(&self) -> impl Iterator<Item = [&ReadBack<ListCounters>; 2]> {
        self.counters.iter().map(<[_; 2]>::each_ref)
    }

    fn loaded(&self) -> Option<&ReadBack<LoadCounters>> {
        self.host.as_ref().map(|host| &host.counters)
    }

    fn sum(
        &self,
        read: impl Fn(&ReadBack<ListCounters>) -> Result<ListCounters, Error>,
    ) -> Result<(ListCounters, ListCounters), Error> {
        let mut sums = (ListCounters::default(), ListCounters::default());
        for [opaque, translucent] in self.counted() {
            sums.0.add(&read(opaque)?);
            sums.1.add(&read(translucent)?);
        }
        Ok(sums)
    }
}
