//! Light that the hits of a node take, and its depths; as in `wgsl/curve/ray_nodes.wgsl`.

/// Moments of the lost light: the ramp of several hits has their mean depth and variance.
#[derive(Clone, Copy, Debug)]
pub struct Taken {
    /// Depth of the first hit.
    anchor: f32,
    light: f32,
    /// First two moments of the light's depth from `anchor`.
    sum: f32,
    square: f32,
    is_some: bool,
}

impl Taken {
    /// No hit.
    pub const NONE: Self = Self { anchor: 0.0, light: 0.0, sum: 0.0, square: 0.0, is_some: false };

    /// Empty moments of a node that begins at `anchor`.
    pub fn from(anchor: f32) -> Self {
        Self { anchor, is_some: true, ..Self::NONE }
    }

    /// Adds the light that a hit takes between two depths, summed over the channels.
    pub fn add_between(&mut self, span: [f32; 2], light: f32) {
        if !self.is_some {
            *self = Self::from(span[0]);
        }
        self.add_even(span, light);
    }

    /// Adds light that is lost evenly between two depths.
    pub fn add_even(&mut self, [start, end]: [f32; 2], light: f32) {
        let (off, length) = (0.5 * (start + end) - self.anchor, end - start);
        self.light += light;
        self.sum += light * off;
        self.square += light * (off * off + length * length * (1.0 / 12.0));
    }

    /// Span of the ramp of hits between `start` and `end`, within that range.
    pub fn fitted(&self, start: f32, end: f32) -> [f32; 2] {
        if self.light <= 0.0 {
            return [start, end];
        }
        let share = 1.0 / self.light;
        let off = self.sum * share;
        let spread = (self.square * share - off * off).max(0.0);
        let mean = (self.anchor + off).min(end).max(start);
        let half = (3.0 * spread).sqrt().min(mean - start).min(end - mean);
        [mean - half, mean + half]
    }
}
