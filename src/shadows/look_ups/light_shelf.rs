//! Objects of lights' bindings, kept from frame to frame.
use super::level_store::LevelStore;
use crate::gpu::Shelf;
use std::sync::atomic::{AtomicU32, Ordering};

/// Objects that the next frame's bindings of lights take over, for the first few bindings alive at a time.
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

    /// States that the maps are drawn anew.
    pub(in crate::shadows) fn redraw(&self) {
        self.levels.redraw();
    }

    /// Maps whose levels were made, in all frames.
    pub(in crate::shadows) fn levels_made(&self) -> u64 {
        self.levels.made()
    }

    /// Objects for a binding; `None` for a host that binds again and again between frames.
    pub(super) fn take(&self) -> Option<&Shelf> {
        const MOST: u32 = 8;
        (self.bound.fetch_add(1, Ordering::Relaxed) < MOST).then_some(&self.shelf)
    }
}
