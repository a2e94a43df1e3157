//! Counters of a frame, read by blocking or as soon as the device has them.
use super::{ListCounters, Prepared, casters::host_casters::HostSets, read_back::ReadBack};
use crate::{
    error::Error,
    model::{Counters, Skipped},
    records::LoadCounters,
};
use std::sync::Arc;

/// Counters on the device.
#[derive(Debug)]
pub(super) struct Counted {
    /// Of the opaque and the translucent list of each batch.
    pub lists: Vec<[ReadBack<ListCounters>; 2]>,
    pub host: Option<Arc<HostSets>>,
}

/// Counters of a frame, summed over the batches.
struct Sums {
    opaque: ListCounters,
    translucent: ListCounters,
    loaded: LoadCounters,
}

impl Counted {
    fn lists(&self) -> impl Iterator<Item = &ReadBack<ListCounters>> {
        self.lists.iter().flatten()
    }

    fn loaded(&self) -> Option<&ReadBack<LoadCounters>> {
        self.host.as_ref().map(|host| &host.counters)
    }

    /// Whether all recorded counters can be taken.
    fn is_ready(&self) -> bool {
        // Polls all, so that all start mapping.
        let loaded = self.loaded().is_none_or(ReadBack::is_ready);
        let lists = self.lists().filter(|counted| !counted.is_ready()).count() == 0;
        loaded && lists
    }

    fn sums(
        &self,
        of_list: impl Fn(&ReadBack<ListCounters>) -> Result<ListCounters, Error>,
        of_host: impl Fn(&ReadBack<LoadCounters>) -> Result<LoadCounters, Error>,
    ) -> Result<Sums, Error> {
        let loaded = self.loaded().map(of_host).transpose()?.unwrap_or_default();
        let (mut opaque, mut translucent) = Default::default();
        for [of_opaque, of_translucent] in &self.lists {
            ListCounters::add(&mut opaque, &of_list(of_opaque)?);
            ListCounters::add(&mut translucent, &of_list(of_translucent)?);
        }
        Ok(Sums { opaque, translucent, loaded })
    }
}

impl Prepared {
    /// Counters of the last recorded frame, once it was submitted. Blocks until the device is done.
    ///
    /// # Errors
    /// If a later [`Shadows::prepare`](crate::shadows::Shadows::prepare) has taken the maps over, or the device is
    /// lost.
    pub fn counters(&self) -> Result<Counters, Error> {
        self.check_current()?;
        let (device, queue) = self.device();
        let sums = self.counted.sums(|it| it.read(device, queue), |it| it.read(device, queue))?;
        Ok(self.counters_of(&sums))
    }

    /// Records the copy of the counters that [`Self::statistics`] returns: after [`Self::record`], in the
    /// same submission or a later one. Does nothing until the previous statistics were taken.
    ///
    /// # Errors
    /// Those of [`Self::record`].
    pub fn record_statistics(&self, encoder: &mut wgpu::CommandEncoder) -> Result<(), Error> {
        self.check_current()?;
        self.counted.lists().for_each(|counted| counted.record(encoder));
        self.counted.loaded().into_iter().for_each(|counted| counted.record(encoder));
        Ok(())
    }

    /// Counters of the frame before [`Self::record_statistics`], if the device has them already: mostly a
    /// frame or two late. Call it after the submission; it does not block.
    ///
    /// # Errors
    /// Those of [`Self::counters`].
    pub fn statistics(&self) -> Result<Option<Counters>, Error> {
        self.check_current()?;
        let (device, _) = self.device();
        // Asks before and after polling: the first call starts the mapping.
        let was_ready = self.counted.is_ready();
        device.poll(wgpu::PollType::Poll).map_err(|error| Error::Lost(error.to_string()))?;
        if !(was_ready || self.counted.is_ready()) {
            return Ok(None);
        }
        let sums = self.counted.sums(ReadBack::take, ReadBack::take)?;
        Ok(Some(self.counters_of(&sums)))
    }

    fn counters_of(&self, Sums { opaque, translucent, loaded }: &Sums) -> Counters {
        let mut skipped = Skipped::new();
        if loaded.skipped > 0 {
            skipped.insert("a number of a host's caster is out of range", loaded.skipped.into());
        }
        let sum = |of: fn(&ListCounters) -> u32| u64::from(of(opaque)) + u64::from(of(translucent));
        Counters {
            casters: self.planned.casters + u64::from(loaded.taken),
            visible: sum(|c| c.visible + c.scattered),
            pairs: sum(|c| c.pair_count),
            segments: sum(|c| c.segment_count),
            scattered: sum(|c| c.scattered + c.overflowed),
            overflowed: sum(|c| c.overflowed),
            disordered: sum(|c| c.disordered),
            unordered: u64::from(translucent.overflowed - translucent.in_parts)
                * u64::from(self.ordered),
            pairs_needed: opaque.pairs_needed.max(translucent.pairs_needed),
            skipped,
            ..self.planned.clone()
        }
    }
}
