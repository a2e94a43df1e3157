//! Higher spherical harmonics of splats' colours: read for those who write splats again.
use super::cloud::memory_for;
use crate::{error::Fault, limits::Limit};
use glam::Vec3;

/// Coefficients of the spherical harmonics of degree 1 and more: a splat's colour is
/// `0.5 + 0.282 c0 + sum of c_k Y_k(direction)`, and base colours hold the first two (Kerbl et al. 2023,
/// section 4).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Harmonics {
    /// Coefficients per splat and channel: 0, 3, 8, 15 or 24.
    pub count: usize,
    /// Red, green and blue of each coefficient, `count` of them a splat, splat by splat.
    pub coefficients: Vec<[f32; 3]>,
}

impl Harmonics {
    /// Room for the coefficients of `splats` splats.
    pub(crate) fn with_room(count: usize, splats: u64) -> Result<Self, Fault> {
        Limit::Splats.grown(0, splats)?;
        let mut coefficients = Vec::new();
        let numbers = splats as usize * count;
        let room = coefficients.try_reserve_exact(numbers);
        room.map_err(|_| memory_for(splats, (numbers * size_of::<[f32; 3]>()) as u64))?;
        Ok(Self { count, coefficients })
    }

    /// Coefficients of splat `i`.
    pub fn of(&self, i: usize) -> &[[f32; 3]] {
        &self.coefficients[i * self.count..][..self.count]
    }

    /// Those of consecutive splats.
    pub(super) fn of_range(&self, splats: &std::ops::Range<u64>) -> Self {
        let [start, end] = [splats.start, splats.end].map(|i| i as usize * self.count);
        Self { count: self.count, coefficients: self.coefficients[start..end].to_vec() }
    }

    /// Those of some rows.
    pub fn of_rows(&self, rows: &[u32]) -> Self {
        let of = |row: &u32| self.of(*row as usize);
        Self { count: self.count, coefficients: rows.iter().flat_map(of).copied().collect() }
    }

    /// The parts one after the other, each with its number of splats: as many coefficients as the part with
    /// the most, which are 0 where a part has fewer.
    pub(crate) fn joined(parts: &[(&Self, u64)]) -> Result<Self, Fault> {
        let count = parts.iter().map(|(part, _)| part.count).max().unwrap_or(0);
        let splats = parts.iter().fold(0, |sum: u64, (_, splats)| sum.saturating_add(*splats));
        let mut all = Self::with_room(count, splats)?;
        for (part, splats) in parts {
            for i in 0..*splats as usize {
                all.coefficients.extend_from_slice(part.of(i));
                let full = all.coefficients.len() + count - part.count;
                all.coefficients.resize(full, [0.0; 3]);
            }
        }
        Ok(all)
    }

    /// Multiplies the coefficients of splat `i` by a share of each channel.
    pub fn scale(&mut self, i: usize, share: Vec3) {
        for rgb in &mut self.coefficients[i * self.count..][..self.count] {
            *rgb = (Vec3::from_array(*rgb) * share).to_array();
        }
    }

    /// Adds the coefficients of a splat whose channels follow each other, as PLY stores them.
    pub(super) fn push_channels(&mut self, channels: impl Fn(usize) -> f32) {
        let of = |k: usize| [0, 1, 2].map(|channel| channels(channel * self.count + k));
        self.coefficients.extend((0..self.count).map(of));
    }
}

/// Degree of the harmonics with a number of coefficients per channel; `None` if no degree has it.
pub(super) fn degree_of(count: usize) -> Option<u8> {
    (0..=4).find(|&degree| (usize::from(degree) + 1).pow(2) - 1 == count)
}
