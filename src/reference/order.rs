//! Twin of `wgsl/hit/hit_order.wgsl`: the hits of one ray, in order of their depths.
//!
//! Casters come in order of their nearest points, their hits nearly so. The last few hits wait, in
//! order; one that comes late finds its place among them. Which one of several at the same depth is
//! first, the order of the casters says.

/// Hits that wait.
pub const WAITING: usize = 8;

/// Hits of one ray that wait, the nearest first.
#[derive(Clone, Debug)]
pub struct HitOrder<T> {
    /// Light depths; negative where none waits.
    waiting: [(f32, T); WAITING],
    /// Light depth of the last that left.
    last: f32,
    /// Hits that came when one behind them had left: their place is lost.
    pub late: u32,
}

impl<T: Copy> HitOrder<T> {
    /// `nothing`: what fills empty places.
    pub fn new(nothing: T) -> Self {
        Self { waiting: [(-1.0, nothing); WAITING], last: -1.0, late: 0 }
    }

    /// A hit comes; the one that makes room for it leaves.
    pub fn push(&mut self, depth: f32, hit: T) -> Option<(f32, T)> {
        let place = self.waiting.partition_point(|&(waiting, _)| waiting <= depth);
        let leaves = if place == 0 {
            (depth, hit)
        } else {
            let first = self.waiting[0];
            self.waiting.copy_within(1..place, 0);
            self.waiting[place - 1] = (depth, hit);
            first
        };
        (leaves.0 >= 0.0).then(|| {
            self.late += u32::from(leaves.0 < self.last);
            self.last = self.last.max(leaves.0);
            leaves
        })
    }

    /// All that wait, in order.
    pub fn drain(&mut self) -> impl Iterator<Item = (f32, T)> {
        let waiting = self.waiting;
        self.waiting.iter_mut().for_each(|(depth, _)| *depth = -1.0);
        waiting.into_iter().filter(|&(depth, _)| depth >= 0.0)
    }
}
