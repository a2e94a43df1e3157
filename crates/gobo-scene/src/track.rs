//! Animated values: keys and their interpolation.
use glam::{Quat, Vec3, Vec4};

/// Interpolation between keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Constant up to the next key.
    Step,
    #[default]
    Linear,
    /// Cubic with the slope between each key's neighbours (Catmull and Rom 1974); at the first and last key,
    /// the slope to the only neighbour.
    Smooth,
    /// Cubic with the slopes of the file (glTF).
    #[serde(skip)]
    Cubic,
}

/// Keys in the order of their times, with constant extrapolation.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Times \[s\], ascending.
    times: Vec<f32>,
    /// One value per time; for [`Mode::Cubic`] three: slope before, value, slope after [1/s].
    values: Vec<Vec4>,
    mode: Mode,
}

impl Track {
    /// `None` if times are missing, not finite or not ascending, or if values are not finite or of another
    /// number.
    pub fn new(times: Vec<f32>, values: Vec<Vec4>, mode: Mode) -> Option<Self> {
        let each = if mode == Mode::Cubic { 3 } else { 1 };
        let is_whole = !times.is_empty() && values.len() == each * times.len();
        let ascend = times.is_sorted_by(|a, b| a < b) && times.iter().all(|time| time.is_finite());
        (is_whole && ascend && values.iter().all(|value| value.is_finite())).then_some(Self {
            times,
            values,
            mode,
        })
    }

    /// Number of keys.
    pub fn key_count(&self) -> usize {
        self.times.len()
    }

    /// Times of its keys \[s\], ascending.
    pub fn times(&self) -> &[f32] {
        &self.times
    }

    fn value(&self, key: usize) -> Vec4 {
        if self.mode == Mode::Cubic { self.values[3 * key + 1] } else { self.values[key] }
    }

    /// The key before `seconds`, the duration to the next key \[s\], and the elapsed share of it.
    fn segment_at(&self, seconds: f64) -> (usize, f32, f32) {
        let after = self.times.partition_point(|&time| f64::from(time) <= seconds);
        let before = after.saturating_sub(1);
        if after == 0 || after == self.times.len() {
            return (before, 1.0, 0.0);
        }
        let (start, end) = (f64::from(self.times[before]), f64::from(self.times[after]));
        (before, (end - start) as f32, ((seconds - start) / (end - start)) as f32)
    }

    /// Slope at `key` between its neighbours [1/s].
    fn slope(&self, key: usize) -> Vec4 {
        let (low, high) = (key.saturating_sub(1), (key + 1).min(self.times.len() - 1));
        (self.values[high] - self.values[low]) / (self.times[high] - self.times[low])
    }

    fn cubic(&self, key: usize, seconds_apart: f32, t: f32) -> Vec4 {
        let (leaves, arrives) = if self.mode == Mode::Cubic {
            (self.values[3 * key + 2], self.values[3 * key + 3])
        } else {
            (self.slope(key), self.slope(key + 1))
        };
        let (a, b) = (self.value(key), self.value(key + 1));
        let (t2, t3) = (t * t, t * t * t);
        let ends = a * (2.0 * t3 - 3.0 * t2 + 1.0) + b * (3.0 * t2 - 2.0 * t3);
        ends + (leaves * (t3 - 2.0 * t2 + t) + arrives * (t3 - t2)) * seconds_apart
    }

    /// Value at `seconds` from the start.
    pub fn at(&self, seconds: f64) -> Vec4 {
        let (key, seconds_apart, t) = self.segment_at(seconds);
        match self.mode {
            _ if t == 0.0 => self.value(key),
            Mode::Step => self.value(key),
            Mode::Linear => self.value(key).lerp(self.value(key + 1), t),
            Mode::Smooth | Mode::Cubic => self.cubic(key, seconds_apart, t),
        }
    }

    /// Like [`Self::at`], for a rotation: unit, and along the shorter arc between two keys.
    pub fn rotation(&self, seconds: f64) -> Quat {
        let unit = |value: Vec4| {
            let turn = value.try_normalize().map(Quat::from_vec4);
            turn.unwrap_or(Quat::IDENTITY)
        };
        let (key, _, t) = self.segment_at(seconds);
        if self.mode == Mode::Linear && t > 0.0 {
            return unit(self.value(key)).slerp(unit(self.value(key + 1)), t);
        }
        unit(self.at(seconds))
    }
}

/// A constant or animated vector.
#[derive(Clone, Debug, PartialEq)]
pub enum Channel {
    Still(Vec3),
    Moving(Track),
}

impl Channel {
    pub fn at(&self, seconds: f64) -> Vec3 {
        match self {
            Self::Still(value) => *value,
            Self::Moving(track) => track.at(seconds).truncate(),
        }
    }

    pub fn moves(&self) -> bool {
        self.track().is_some()
    }

    pub fn track(&self) -> Option<&Track> {
        match self {
            Self::Still(_) => None,
            Self::Moving(track) => Some(track),
        }
    }
}
