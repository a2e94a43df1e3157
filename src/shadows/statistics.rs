//! Counters of frames, read by blocking or as soon as the device has them.
use super::{ListCounters, Prepared, Shadows, casters::host_casters::HostSets, frame_mark::Words};
use crate::{
    error::Error,
    gpu::{check_alive, read_back, staging},
    model::{Counters, Skipped},
    records::LoadCounters,
};
use std::sync::{
    Arc, Mutex, PoisonError,
    atomic::{AtomicU8, Ordering::SeqCst},
};
use wgpu::{Buffer, CommandEncoder};

/// Counters of a frame on the device.
#[derive(Debug)]
pub(super) struct Counted {
    /// Counters of the opaque and the translucent list of each batch.
    pub lists: Vec<[Buffer; 2]>,
    pub host: Option<Arc<HostSets>>,
}

impl Counted {
    /// Every list's counters, then those of the host's casters, and their sizes \[bytes\].
    fn buffers(&self) -> impl Iterator<Item = (&Buffer, u64)> {
        let lists = self.lists.iter().flatten().map(|list| (list, list.size()));
        let host = self.host.iter().map(|host| (&host.groups, size_of::<LoadCounters>() as u64));
        lists.chain(host)
    }

    fn size(&self) -> u64 {
        self.buffers().map(|(_, size)| size).sum()
    }

    fn copy(&self, encoder: &mut CommandEncoder, to: &Buffer) {
        let mut at = 0;
        for (buffer, size) in self.buffers() {
            encoder.copy_buffer_to_buffer(buffer, 0, to, at, size);
            at += size;
        }
    }
}

/// Properties of a frame that its counters belong to, and counts that no kernel makes.
#[derive(Clone, Debug)]
pub(super) struct Planned {
    pub counters: Counters,
    /// Batches of the frame.
    pub batches: usize,
    pub has_host: bool,
    /// Whether blending depends on the order of the casters.
    pub ordered: bool,
}

impl Planned {
    /// `bytes`: as [`Counted::copy`] copied them.
    fn counters(&self, bytes: &[u8]) -> Counters {
        let (lists, host) = bytes.split_at(2 * self.batches * size_of::<ListCounters>());
        let mut sums = [ListCounters::default(); 2];
        for (i, list) in lists.chunks_exact(size_of::<ListCounters>()).enumerate() {
            sums[i % 2].add(&bytemuck::pod_read_unaligned(list));
        }
        let [opaque, translucent] = sums;
        let host = host.get(..size_of::<LoadCounters>()).filter(|_| self.has_host);
        let loaded: LoadCounters = host.map(bytemuck::pod_read_unaligned).unwrap_or_default();
        let mut skipped = Skipped::new();
        if loaded.skipped > 0 {
            skipped.insert(
                "a number of a host's caster or voxel is out of range",
                loaded.skipped.into(),
            );
        }
        let sum =
            |of: fn(&ListCounters) -> u32| u64::from(of(&opaque)) + u64::from(of(&translucent));
        Counters {
            casters: self.counters.casters + u64::from(loaded.taken),
            visible: sum(|c| c.visible + c.scattered),
            pairs: sum(|c| c.pair_count),
            segments: sum(|c| c.segment_count),
            scattered: sum(|c| c.scattered + c.overflowed),
            overflowed: sum(|c| c.overflowed),
            disordered: sum(|c| c.disordered),
            unordered: u64::from(translucent.overflowed - translucent.in_parts)
                * u64::from(self.ordered),
            short_tiles: translucent.short_tiles.into(),
            pairs_needed: opaque.pairs_needed.max(translucent.pairs_needed),
            skipped,
            ..self.counters.clone()
        }
    }
}

/// Frames whose counters may be on their way at a time.
const SLOTS: usize = 4;

/// Buffers through which counters of frames are read.
#[derive(Debug, Default)]
pub(super) struct Statistics(Mutex<Vec<Slot>>);

#[derive(Debug)]
struct Slot {
    staging: Buffer,
    state: Arc<AtomicU8>,
    /// For copied counters: the frame's number and properties.
    planned: Option<(u64, Planned)>,
    /// Index of the word that the last 4 bytes hold once the copy has run.
    word: u32,
}

const IDLE: u8 = 0;
/// A recording copies counters into it.
const COPIED: u8 = 1;
const MAPPING: u8 = 2;
const MAPPED: u8 = 3;
const FAILED: u8 = 4;

impl Statistics {
    fn slots(&self) -> std::sync::MutexGuard<'_, Vec<Slot>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Size of the counters, and a mark after them \[bytes\].
    fn size(counted: &Counted) -> u64 {
        (counted.size() + 4).next_power_of_two()
    }

    /// Makes room for the counters of a frame, so that recording allocates nothing.
    pub(super) fn reserve(&self, device: &wgpu::Device, counted: &Counted) {
        let size = Self::size(counted);
        let mut slots = self.slots();
        slots.retain(|slot| slot.staging.size() >= size || slot.state.load(SeqCst) != IDLE);
        while slots.len() < SLOTS {
            let staging = staging(device, "counters_readback", size);
            let state = Arc::new(AtomicU8::new(IDLE));
            slots.push(Slot { staging, state, planned: None, word: 0 });
        }
    }

    /// Records the copy of a frame's counters, if a slot is free.
    fn record(&self, encoder: &mut CommandEncoder, prepared: &Prepared) {
        let counted = &prepared.commands.counted;
        let is_free = |slot: &&mut Slot| {
            slot.state.load(SeqCst) == IDLE && slot.staging.size() >= Self::size(counted)
        };
        let mut slots = self.slots();
        if let Some(slot) = slots.iter_mut().find(is_free) {
            counted.copy(encoder, &slot.staging);
            let end = slot.staging.size() - 4;
            prepared.mark.words.write(slot.word, encoder, &slot.staging, end);
            slot.planned = Some((prepared.frame, prepared.planned.clone()));
            slot.state.store(COPIED, SeqCst);
        }
    }

    /// The counters of the first frame that were not taken yet, if the device has them.
    fn take(&self, device: &wgpu::Device) -> Result<Option<Counters>, Error> {
        let lost = |error: String| Error::Lost(error);
        let mut slots = self.slots();
        for slot in slots.iter().filter(|slot| slot.state.load(SeqCst) == COPIED) {
            slot.state.store(MAPPING, SeqCst);
            let state = Arc::clone(&slot.state);
            slot.staging.map_async(wgpu::MapMode::Read, .., move |result| {
                state.store(if result.is_ok() { MAPPED } else { FAILED }, SeqCst);
            });
        }
        device.poll(wgpu::PollType::Poll).map_err(|error| lost(error.to_string()))?;
        // In order, even if another thread polls between the answers of two slots.
        let is_back = |slot: &&mut Slot| matches!(slot.state.load(SeqCst), MAPPED | FAILED);
        let number = |slot: &&mut Slot| slot.planned.as_ref().map(|(frame, _)| *frame);
        let waiting = slots.iter_mut().filter(|slot| slot.planned.is_some());
        let Some(slot) = waiting.min_by_key(number).filter(is_back) else { return Ok(None) };
        let planned = slot.planned.take();
        if slot.state.swap(IDLE, SeqCst) == FAILED {
            return Err(lost("its counters cannot be read".to_owned()));
        }
        let mapped = slot.staging.get_mapped_range(..);
        let bytes = mapped.map_err(|error| lost(error.to_string()))?;
        // Without the mark, the frame did not run.
        let has_run = Words::is(slot.word, &bytes[bytes.len() - 4..]);
        let counters = planned.filter(|_| has_run).map(|(_, planned)| planned.counters(&bytes));
        drop(bytes);
        slot.staging.unmap();
        slot.word ^= u32::from(has_run);
        Ok(counters)
    }
}

/// The counters of a list, after all commands submitted before. Blocks.
pub(super) fn read_list(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    counters: &Buffer,
) -> Result<ListCounters, Error> {
    let bytes = read_back(device, queue, counters.size(), |encoder, to| {
        encoder.copy_buffer_to_buffer(counters, 0, to, 0, counters.size());
    })?;
    Ok(bytemuck::pod_read_unaligned(&bytes[..size_of::<ListCounters>()]))
}

impl Prepared {
    /// Counters of the last recorded frame, once it was submitted. Blocks until the device is done.
    ///
    /// # Errors
    /// If a later [`Shadows::prepare`] has taken the maps over, or the device is lost.
    pub fn counters(&self) -> Result<Counters, Error> {
        self.check_usable()?;
        let (device, queue) = self.device();
        let copy = |encoder: &mut _, to: &_| self.commands.counted.copy(encoder, to);
        let bytes = read_back(device, queue, self.commands.counted.size(), copy)?;
        Ok(self.planned.counters(&bytes))
    }

    /// Records the copy of the frame's counters, which [`Shadows::statistics`] returns: after
    /// [`Self::record`], in the same submission or a later one. Does nothing while the counters of four
    /// frames wait to be taken.
    ///
    /// # Errors
    /// Those of [`Self::record`].
    pub fn record_statistics(&self, encoder: &mut CommandEncoder) -> Result<(), Error> {
        self.check_current()?;
        self.statistics.record(encoder, self);
        Ok(())
    }
}

impl Shadows {
    /// Counters of frames with [`Prepared::record_statistics`], one frame after the other, as soon as the
    /// device has them: mostly a frame or two late, even if a later frame has taken the maps over. Call it
    /// once a frame, after the submission; it does not block. Frames that did not run have none. The pair
    /// capacity grows to the number that the frame needed, as by [`Self::grow_from`].
    ///
    /// # Errors
    /// If the device is lost.
    pub fn statistics(&mut self) -> Result<Option<Counters>, Error> {
        let (device, _) = self.device();
        check_alive(device)?;
        let counters = self.statistics.take(device)?;
        if let Some(counters) = &counters {
            self.grow_from(counters);
        }
        Ok(counters)
    }
}
