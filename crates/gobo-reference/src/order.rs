//! CPU reference of `wgsl/hit/hit_order.wgsl`: sorting of one ray's hits by depth.
//!
//! Casters come sorted by their nearest points, so their hits are nearly sorted. The last few hits wait in a
//! sorted buffer; a late one is inserted among them. At equal depths the casters' order decides.

/// Capacity of the buffer \[hits\].
pub const WAITING: usize = 8;

/// Sorted buffer of hits of one ray, the nearest first.
#[derive(Clone, Debug)]
pub struct HitOrder<T> {
    /// Light depths; negative for an empty slot.
    waiting: [(f32, T); WAITING],
    /// Light depth of the last hit that left.
    last: f32,
    /// Number of hits out of order: they came after a hit behind them had left.
    pub late: u32,
}

impl<T: Copy> HitOrder<T> {
    /// An empty buffer; `nothing` fills empty slots.
    pub fn new(nothing: T) -> Self {
        Self { waiting: [(-1.0, nothing); WAITING], last: -1.0, late: 0 }
    }

    /// Adds a hit; returns the one that leaves in exchange.
    pub fn push(&mut self, depth: f32, hit: T) -> Option<(f32, T)> {
        let index = self.waiting.partition_point(|&(waiting, _)| waiting <= depth);
        let leaves = if index == 0 {
            (depth, hit)
        } else {
            let first = self.waiting[0];
            self.waiting.copy_within(1..index, 0);
            self.waiting[index - 1] = (depth, hit);
            first
        };
        (leaves.0 >= 0.0).then(|| {
            self.late += u32::from(leaves.0 < self.last);
            self.last = self.last.max(leaves.0);
            leaves
        })
    }

    /// All waiting hits, in order.
    pub fn drain(&mut self) -> impl Iterator<Item = (f32, T)> {
        let waiting = self.waiting;
        self.waiting.iter_mut().for_each(|(depth, _)| *depth = -1.0);
        waiting.into_iter().filter(|&(depth, _)| depth >= 0.0)
    }
}
