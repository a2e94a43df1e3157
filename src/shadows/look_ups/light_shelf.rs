//! What bindings of lights are made of, from frame to frame.
use super::level_store::LevelStore;
use crate::gpu::Shelf;
use std::sync::atomic::{AtomicU32, Ordering};

/// Frames bind the lights anew into what the last frame's bindings were made of, of the first few alive at a
/// time.
#[derive(Debug)]
pub struct LightShelf {
    shelf: Shelf,
    /// Bindings since the last frame.
    bound: AtomicU32,
    pub(super) levels: LevelStore,
}

impl LightShelf {
    pub(in crate::shadows) fn new(queue: &wgpu::Queue) -> Self {
        Self { shelf: Shelf::new(queue), bound: AtomicU32::new(0), levels: LevelStore::default() }
    }

    /// Begins a frame.
    pub(in crate::shadows) fn turn(&self) {
        self.bound.store(0, Ordering::Relaxed);
        self.shelf.turn();
        self.levels.turn();
    }

    /// The maps are drawn anew.
    pub(in crate::shadows) fn redraw(&self) {
        self.levels.redraw();
    }

    /// Maps whose levels were made, in all frames.
    pub(in crate::shadows) fn levels_made(&self) -> u64 {
        self.levels.made()
    }

    /// `None` for a host that binds again and again between frames.
    pub(super) fn take(&self) -> Option<&Shelf> {
        const MOST: u32 = 8;
        (self.bound.fetch_add(1, Ordering::Relaxed) < MOST).then_some(&self.shelf)
    }
}
