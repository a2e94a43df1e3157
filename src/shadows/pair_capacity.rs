//! Pair capacity of a frame, and its growth.
use crate::model::Counters;

/// Pair capacity of a batch: first a guess, then the number that a frame needed.
#[derive(Clone, Copy, Debug)]
pub struct PairCapacity {
    /// `None`: a guess from the number of casters.
    pub pairs: Option<u32>,
    /// Largest capacity that the host allows \[pairs\].
    pub budget: u32,
    /// Pages of curves; `None`: a guess from the number of tiles.
    pub pages: Option<u32>,
    /// Most pairs that a frame needed; `None` before any was counted.
    seen: Option<u32>,
    /// The last frames of uploaded casters that were counted.
    counted: Option<CountedFrames>,
}

/// Frames of as many uploaded casters.
#[derive(Clone, Copy, Debug)]
pub struct CountedFrames {
    casters: u64,
    /// Most pairs that one needed.
    most: u32,
    /// Whether no tile had several segments.
    pub had_short_tiles: bool,
}

impl CountedFrames {
    /// Pairs that the next frames are expected to need at most.
    pub fn expected(&self) -> u32 {
        roomy(self.most)
    }
}

impl PairCapacity {
    /// Room for pairs within a budget.
    pub fn new(budget: u32) -> Self {
        Self { pairs: None, pages: None, budget, seen: None, counted: None }
    }

    /// Grows to the number that a frame needed and a quarter more. Returns whether the frame should be
    /// rendered again: its capacity was lower, and the budget and the device allow more.
    pub fn grow(&mut self, needed: u32, capacity: u32) -> bool {
        let refused = self.pairs.is_some_and(|wanted| wanted > capacity);
        let grows = needed > capacity && capacity < self.budget && !refused;
        if grows {
            self.pairs = Some(roomy(needed));
        }
        grows
    }

    /// Grows to the number of pages that a frame needed and a quarter more. Returns whether it had too few.
    pub fn grow_pages(&mut self, counters: &Counters) -> bool {
        let is_short = counters.short_tiles > 0;
        if is_short {
            let short = u32::try_from(counters.short_tiles).unwrap_or(u32::MAX);
            self.pages = Some(roomy(counters.page_capacity.saturating_add(short)));
        }
        is_short
    }

    /// Takes note of a frame of casters that the CPU does not know. Once more than [`Self::expected`] would
    /// not fit, the capacity grows to half as much again as the frame needed.
    pub fn see(&mut self, counters: &Counters) {
        let &Counters { pairs_needed, pair_capacity, overflowed, .. } = counters;
        // Too many pairs of neighbours in the list, for any capacity.
        let is_crowded = overflowed > 0 && pairs_needed <= pair_capacity;
        let needed = if is_crowded { u32::MAX } else { pairs_needed };
        let seen = self.seen.unwrap_or(0).max(needed);
        self.seen = Some(seen);
        if !is_crowded && self.expected().is_some_and(|pairs| pairs > pair_capacity) {
            let roomy = seen.saturating_add(seen / 2).min(self.budget);
            self.pairs = self.pairs.max(Some(roomy));
        }
    }

    /// Takes note of a frame of uploaded casters.
    pub fn count(&mut self, counters: &Counters) {
        let &Counters { casters, pairs_needed, pair_capacity, overflowed, segments, .. } = counters;
        let is_crowded = overflowed > 0 && pairs_needed <= pair_capacity;
        let needed = if is_crowded { u32::MAX } else { pairs_needed };
        let before = self.counted_of(casters);
        self.counted = Some(CountedFrames {
            casters,
            most: before.map_or(needed, |before| before.most.max(needed)),
            had_short_tiles: segments == 0 && before.is_none_or(|before| before.had_short_tiles),
        });
    }

    /// Pairs that frames of so many uploaded casters are expected to need at most, if the last that were
    /// counted had as many.
    pub fn counted_of(&self, casters: u64) -> Option<CountedFrames> {
        self.counted.filter(|counted| counted.casters == casters)
    }

    /// Pairs that the next frames of such casters are expected to need at most: a quarter more than any so
    /// far.
    pub fn expected(&self) -> Option<u32> {
        self.seen.map(roomy)
    }
}

/// Capacity for frames that need about as many pairs: of many similar frames some need a few more pairs, and
/// would otherwise be rendered again.
pub fn roomy(pairs: u32) -> u32 {
    pairs.saturating_add(pairs / 4)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(capacity: &mut PairCapacity, pairs_needed: u32, overflowed: u64) -> [Option<u32>; 2] {
        let pair_capacity = capacity.pairs.unwrap_or(1000);
        capacity.see(&Counters { pairs_needed, pair_capacity, overflowed, ..Counters::default() });
        [capacity.expected(), capacity.pairs]
    }

    #[test]
    fn growth_leaves_room_for_a_little_more() {
        let mut capacity = PairCapacity::new(5000);
        assert!(capacity.grow(1000, 500) && !capacity.grow(1200, 1250));
        assert_eq!(capacity.pairs, Some(1250));
    }

    #[test]
    fn as_many_uploaded_casters_are_expected_to_need_as_much() {
        let mut capacity = PairCapacity::new(5000);
        for (casters, pairs_needed, overflowed, segments, expected) in [
            (7, 800, 0, 0, (1000, true)),
            (7, 400, 0, 2, (1000, false)),
            (7, 400, 0, 0, (1000, false)),
            (8, 400, 0, 0, (500, true)),
            (8, 400, 1, 0, (u32::MAX, true)),
        ] {
            capacity.count(&Counters {
                casters,
                pairs_needed,
                pair_capacity: 900,
                overflowed,
                segments,
                ..Counters::default()
            });
            let counted = capacity.counted_of(casters).unwrap();
            assert_eq!((counted.expected(), counted.had_short_tiles), expected);
            assert!(capacity.counted_of(casters + 2).is_none());
        }
    }

    #[test]
    fn a_quarter_more_is_expected_and_half_as_much_again_makes_room() {
        let mut capacity = PairCapacity::new(5000);
        assert_eq!(capacity.expected(), None);
        assert_eq!(seen(&mut capacity, 800, 0), [Some(1000), None]);
        assert_eq!(seen(&mut capacity, 100, 0), [Some(1000), None], "the most so far");
        assert_eq!(seen(&mut capacity, 804, 0), [Some(1005), Some(1206)]);
        assert_eq!(seen(&mut capacity, 4400, 7), [Some(5500), Some(5000)], "the budget");
        assert_eq!(seen(&mut capacity, 900, 7), [Some(u32::MAX), Some(5000)], "neighbours");
    }
}
