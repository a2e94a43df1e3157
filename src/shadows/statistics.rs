//! Counters of a frame, read by blocking or as soon as the device has them.
use super::{ListCounters, Prepared, PreparedMaps, prepared_maps::AllCounters};
use crate::{
    error::Error,
    model::{Counters, Skipped},
};

impl Prepared {
    /// Counters of the last recorded frame, once it was submitted. Blocks until the device is done.
    ///
    /// # Errors
    /// If a later [`Shadows::prepare`](crate::shadows::Shadows::prepare) has taken the maps over, or the device is
    /// lost.
    pub fn counters(&self) -> Result<Counters, Error> {
        let (device, queue) = self.device();
        self.with_maps(|maps| Ok(self.counters_of(maps, maps.read_all_counters(device, queue)?)))
    }

    /// Records the copy of the counters that [`Self::statistics`] returns: after [`Self::record`], in the
    /// same submission or a later one. Does nothing until the previous statistics were taken.
    ///
    /// # Errors
    /// Those of [`Self::record`].
    pub fn record_statistics(&self, encoder: &mut wgpu::CommandEncoder) -> Result<(), Error> {
        self.with_maps(|maps| {
            maps.record_statistics(encoder);
            Ok(())
        })
    }

    /// Counters of the frame before [`Self::record_statistics`], if the device has them already: mostly a
    /// frame or two late. Call it after the submission; it does not block.
    ///
    /// # Errors
    /// Those of [`Self::counters`].
    pub fn statistics(&self) -> Result<Option<Counters>, Error> {
        let (device, _) = self.device();
        self.with_maps(|maps| {
            // Asks before and after polling: the first call starts the mapping.
            let was_ready = maps.has_statistics();
            device.poll(wgpu::PollType::Poll).map_err(|error| Error::Lost(error.to_string()))?;
            if !(was_ready || maps.has_statistics()) {
                return Ok(None);
            }
            Ok(Some(self.counters_of(maps, maps.take_statistics()?)))
        })
    }

    fn counters_of(
        &self,
        maps: &PreparedMaps,
        ((opaque, translucent), loaded): AllCounters,
    ) -> Counters {
        let mut skipped = Skipped::new();
        if loaded.skipped > 0 {
            skipped.insert("a number of a host's caster is out of range", loaded.skipped.into());
        }
        let sum =
            |of: fn(&ListCounters) -> u32| u64::from(of(&opaque)) + u64::from(of(&translucent));
        Counters {
            casters: self.caster_count + u64::from(loaded.taken),
            views_rendered: maps.rendered_count() as u64,
            views_kept: (maps.view_count() - maps.rendered_count()) as u64,
            culled: maps.culled_count(),
            hidden: maps.hidden_count(),
            visible: sum(|c| c.visible + c.scattered),
            pairs: sum(|c| c.pair_count),
            segments: sum(|c| c.segment_count),
            scattered: sum(|c| c.scattered + c.overflowed),
            overflowed: sum(|c| c.overflowed),
            disordered: sum(|c| c.disordered),
            unordered: u64::from(translucent.overflowed - translucent.in_parts)
                * u64::from(self.ordered),
            pairs_needed: opaque.pairs_needed.max(translucent.pairs_needed),
            pair_capacity: maps.pair_capacity(),
            skipped,
            ..Counters::default()
        }
    }
}
