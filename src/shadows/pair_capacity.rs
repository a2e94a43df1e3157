//! Pair capacity of a frame, and its growth.

/// Pair capacity of a batch: a guess at first, then what a frame needed.
#[derive(Clone, Copy, Debug)]
pub struct PairCapacity {
    /// `None`: a guess from the number of casters.
    pub pairs: Option<u32>,
    /// Largest capacity that the host allows [pairs].
    pub budget: u32,
}

impl PairCapacity {
    pub fn new(budget: u32) -> Self {
        Self { pairs: None, budget }
    }

    /// Grows to what a frame needed. Returns whether the frame should be rendered again: its capacity was
    /// lower, and the budget and the device allow more.
    pub fn grow(&mut self, needed: u32, capacity: u32) -> bool {
        let refused = self.pairs.is_some_and(|wanted| wanted > capacity);
        let grows = needed > capacity && capacity < self.budget && !refused;
        if grows {
            self.pairs = Some(needed);
        }
        grows
    }

    /// Renders until the pairs fit, or the budget is spent. `frame` renders once with a pair capacity, and
    /// returns how many pairs it needed and its capacity.
    pub fn until_it_fits<T, E>(
        &mut self,
        mut frame: impl FnMut(Option<u32>) -> Result<(T, [u32; 2]), E>,
    ) -> Result<T, E> {
        loop {
            let (rendered, [needed, capacity]) = frame(self.pairs)?;
            if !self.grow(needed, capacity) {
                return Ok(rendered);
            }
        }
    }
}
