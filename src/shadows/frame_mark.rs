//! Marks by which a frame shows that it ran.
//!
//! A host may never submit the commands it recorded, for example where its surface is lost, and a submission
//! may be refused. So the last command of a frame copies a mark into a buffer of 4 bytes, and the next
//! `prepare` maps that buffer, without waiting:
//! - it is mapped at once, and holds the mark: the frame ran;
//! - it is mapped at once, without the mark: no commands that use it were submitted;
//! - it is not mapped yet: submitted commands use it. (A browser maps nothing at once, nor does a device that
//!   another thread polls meanwhile: there a later `prepare` finds a frame that was not submitted.)
//!
//! The device refuses commands that use a mapped or destroyed buffer: those of a frame that are submitted
//! after the next `prepare`, which has overwritten the data that they read.
use crate::{error::Error, gpu::filled};
use std::{
    collections::VecDeque,
    sync::{
        Arc,
        atomic::{AtomicU8, AtomicU32, Ordering::SeqCst},
    },
};
use wgpu::{Buffer, BufferUsages, CommandEncoder, Device};

/// Marks kept behind the current one: a recording that comes up to this many frames late is still refused.
const KEPT: usize = 2;

/// The words used as marks; a buffer gets the one that it does not hold.
#[derive(Clone, Debug)]
pub(super) struct Words(Buffer);

impl Words {
    const ALL: [u32; 2] = [1, 2];

    /// Records the copy of the word with index `word` to 4 bytes of a buffer.
    pub(super) fn write(&self, word: u32, encoder: &mut CommandEncoder, to: &Buffer, offset: u64) {
        encoder.copy_buffer_to_buffer(&self.0, u64::from(4 * word), to, offset, 4);
    }

    /// Whether 4 bytes are the word with index `word`.
    pub(super) fn is(word: u32, bytes: &[u8]) -> bool {
        bytes == Self::ALL[word as usize].to_ne_bytes()
    }
}

/// The mark of a frame.
#[derive(Debug)]
pub(super) struct Mark {
    /// Its label is shown in the device's error about commands that come too late.
    buffer: Buffer,
    pub(super) words: Words,
    /// Index of the word that is the mark.
    word: u32,
    /// Number of recordings.
    recordings: AtomicU32,
    state: Arc<AtomicU8>,
}

const IDLE: u8 = 0;
const MAPPING: u8 = 1;
const MAPPED: u8 = 2;
/// Mapped, and the mark is in it.
const RAN: u8 = 3;
/// Not mappable, or without the mark.
const FAILED: u8 = 4;

impl Mark {
    fn new(device: &Device, words: Words) -> Self {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("mark of shadow maps that a later `prepare` has taken over"),
            size: 4,
            usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { buffer, words, word: 0, recordings: AtomicU32::new(0), state: Arc::default() }
    }

    /// The mark of another frame in the same buffer, once its earlier frames record no more.
    fn again(&self) -> Self {
        self.unmap();
        let &Self { ref buffer, ref words, word, ref state, .. } = self;
        let (buffer, words, state) = (buffer.clone(), words.clone(), Arc::clone(state));
        Self { buffer, words, word: 1 - word, recordings: AtomicU32::new(0), state }
    }

    /// Records the mark, behind the commands of the frame.
    pub(super) fn record(&self, encoder: &mut CommandEncoder) {
        self.words.write(self.word, encoder, &self.buffer, 0);
        self.recordings.fetch_add(1, SeqCst);
    }

    fn map(&self) {
        let state = Arc::clone(&self.state);
        state.store(MAPPING, SeqCst);
        self.buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            state.store(if result.is_ok() { MAPPED } else { FAILED }, SeqCst);
        });
    }

    fn unmap(&self) {
        if self.state.load(SeqCst) != IDLE {
            self.buffer.unmap();
            self.state.store(IDLE, SeqCst);
        }
    }

    /// Whether the mark is in the mapped buffer.
    fn is_written(&self) -> bool {
        let mapped = self.buffer.get_mapped_range(..);
        let is_written = mapped.is_ok_and(|bytes| Words::is(self.word, &bytes));
        self.state.store(if is_written { RAN } else { FAILED }, SeqCst);
        is_written
    }
}

/// The marks of all frames of a `Shadows`.
#[derive(Debug)]
pub(super) struct Marks {
    current: Arc<Mark>,
    /// Marks of earlier frames, oldest first, mapped or being mapped.
    earlier: VecDeque<Arc<Mark>>,
}

impl Marks {
    pub(super) fn new(device: &Device) -> Self {
        let words = filled(device, "frame_marks", &Words::ALL, BufferUsages::COPY_SRC);
        let current = Arc::new(Mark::new(device, Words(words)));
        Self { current, earlier: VecDeque::new() }
    }

    /// The mark of the frame prepared last.
    pub(super) fn current(&self) -> Arc<Mark> {
        Arc::clone(&self.current)
    }

    /// Whether the last frame ran or is on its way. [`Self::keep`] or [`Self::turn`] must follow.
    pub(super) fn has_run(&self, device: &Device) -> Result<bool, Error> {
        if self.current.recordings.load(SeqCst) == 0 {
            return Ok(false);
        }
        self.current.map();
        device.poll(wgpu::PollType::Poll).map_err(|error| Error::Lost(error.to_string()))?;
        match self.current.state.load(SeqCst) {
            MAPPED => Ok(self.current.is_written()),
            FAILED => Err(Error::Lost("a mark of its frames cannot be read".to_owned())),
            _ => Ok(true),
        }
    }

    /// Whether all frames that were thought to be on their way ran.
    pub(super) fn have_run(&self) -> bool {
        let mapped = self.earlier.iter().filter(|mark| mark.state.load(SeqCst) == MAPPED);
        mapped.filter(|mark| !mark.is_written()).count() == 0
    }

    /// Keeps the last frame valid.
    pub(super) fn keep(&self) {
        self.current.unmap();
    }

    /// Begins a frame with a new current mark.
    pub(super) fn turn(&mut self, device: &Device) {
        let recordings = self.current.recordings.load(SeqCst);
        if recordings == 0 {
            return;
        }
        self.earlier.retain(|mark| {
            let is_lost = mark.state.load(SeqCst) == FAILED;
            if is_lost {
                mark.buffer.destroy();
            }
            !is_lost
        });
        // Unless the device has not reached it.
        let oldest = self.earlier.front().filter(|mark| mark.state.load(SeqCst) == RAN);
        let next = match oldest.filter(|_| self.earlier.len() >= KEPT) {
            Some(oldest) => {
                let next = oldest.again();
                self.earlier.pop_front();
                next
            }
            None => Mark::new(device, self.current.words.clone()),
        };
        let last = std::mem::replace(&mut self.current, Arc::new(next));
        match last.state.load(SeqCst) {
            MAPPING | RAN if recordings == 1 => self.earlier.push_back(last),
            // Some of its commands may be submitted at any time.
            _ => last.buffer.destroy(),
        }
    }
}
