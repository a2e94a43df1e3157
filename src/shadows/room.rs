//! How much room for pairs a frame is given.

/// Room for the pairs of a batch: guessed at first, then what a frame needed.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// `None`: a guess from the number of casters.
    pub pairs: Option<u32>,
    /// The most that the host allows [pairs].
    pub budget: u32,
}

impl Room {
    pub fn new(budget: u32) -> Self {
        Self { pairs: None, budget }
    }

    /// Takes over what a frame needed. Whether it should be rendered again: it had less room than
    /// that, and may have more, of the budget and of the device.
    pub fn grow(&mut self, needed: u32, capacity: u32) -> bool {
        let refused = self.pairs.is_some_and(|asked| asked > capacity);
        let grows = needed > capacity && capacity < self.budget && !refused;
        if grows {
            self.pairs = Some(needed);
        }
        grows
    }

    /// Renders until the pairs fit, or the budget is spent. `frame` renders once, with room for so
    /// many pairs, and says how many it needed and had room for.
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
