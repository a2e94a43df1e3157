//! Splats of a file, checked one by one.
use super::place::placed;
use crate::{error::Fault, limits::Limit};
use glam::{Mat4, Vec3};
use gobo::model::{Gaussian, GaussianOpacity, Skipped};

/// Degree-0 spherical harmonic, `1 / (2 sqrt(pi))`: colour = 0.5 + this * coefficient (Kerbl et al. 2023).
pub(crate) const HARMONIC: f32 = 0.282_094_8;

/// Word `i` of bytes; the caller checked the length.
pub(super) fn word(bytes: &[u8], i: usize) -> [u8; 4] {
    std::array::from_fn(|byte| bytes[4 * i + byte])
}

/// Says that a number of splats, of `bytes` in all, has no room.
pub(super) fn memory_for(splats: u64, bytes: u64) -> Fault {
    let help = "use a smaller file, or a machine with more memory";
    (format!("no memory for {splats} splats ({} MiB)", bytes >> 20), help)
}

/// The splats of a file.
#[derive(Clone, Debug, Default)]
pub struct SplatCloud {
    /// Splats in the order of the file, of material 0. Opacities of a medium are shares of the largest.
    pub splats: Vec<Gaussian>,
    /// Extinction at the centre of a splat of opacity 1 [1/m], if the file holds a medium.
    pub extinction: Option<f32>,
    /// Splats left out, by reason.
    pub skipped: Skipped,
    /// Ignored parts of the file, a sentence each.
    pub notes: Vec<String>,
    /// Each splat's row in the file; empty where no row was skipped.
    pub rows: Vec<u32>,
    /// Coefficients of higher spherical harmonics that the file has for each splat and channel, beside its
    /// colour.
    pub harmonics: usize,
    /// Number of colours that were outside 0..=1.
    clamped: u64,
}

/// A deviation of 0 becomes this share of the largest: the splat stays flat, without a division by 0.
const FLATTEST: f32 = 1e-6;

impl SplatCloud {
    /// An empty cloud with room for `count` splats.
    pub(crate) fn with_room(count: u64) -> Result<Self, Fault> {
        Limit::Splats.grown(0, count)?;
        let mut cloud = Self::default();
        let bytes = count * size_of::<Gaussian>() as u64;
        let room = cloud.splats.try_reserve_exact(count as usize);
        room.map_err(|_| memory_for(count, bytes))?;
        Ok(cloud)
    }

    /// Adds the next splat of the file if it is valid; normalises its rotation, clamps its colour.
    pub(crate) fn push(&mut self, splat: Gaussian) {
        self.take(valid(splat), splat.color);
    }

    /// Like [`Self::push`], in the space of the file. World space = `world` * the splat's space.
    pub(crate) fn push_placed(&mut self, splat: Gaussian, world: &Mat4) {
        self.take(valid(splat).and_then(|splat| valid(placed(&splat, world))), splat.color);
    }

    fn take(&mut self, checked: Result<Gaussian, &'static str>, color: Vec3) {
        let row = self.splats.len() as u64 + self.skipped.values().sum::<u64>();
        match checked {
            Ok(valid) => {
                self.clamped += u64::from(valid.color != color);
                if !self.skipped.is_empty() {
                    self.rows.push(row as u32);
                }
                self.splats.push(valid);
            }
            Err(reason) => {
                if self.skipped.is_empty() {
                    self.rows = (0..row as u32).collect();
                }
                *self.skipped.entry(reason).or_default() += 1;
            }
        }
    }

    /// Notes that `count` coefficients of higher spherical harmonics are ignored in each splat's colour.
    pub(crate) fn leave_out_harmonics(&mut self, count: usize) {
        self.harmonics = count;
        if count > 0 && !self.splats.is_empty() {
            self.notes.push(format!(
                "{count} coefficients of spherical harmonics of each splat are not shown: its colour is \
                 the same from all sides"
            ));
        }
    }

    /// The whole cloud, with a note about its colours.
    pub(crate) fn finish(mut self) -> Self {
        if self.clamped > 0 {
            self.notes.push(format!("colours of {} splats are clamped to 0 to 1", self.clamped));
        }
        self
    }
}

/// The splat with a unit rotation, a clamped colour and no deviation of 0, or the reason why it cannot be
/// used.
pub fn valid(splat: Gaussian) -> Result<Gaussian, &'static str> {
    let Gaussian { rotation, sigma, color, .. } = splat;
    // Squares of a short quaternion would underflow.
    let longest = rotation.to_array().iter().fold(0.0, |most: f32, part| most.max(part.abs()));
    let flattest = sigma.max_element() * FLATTEST;
    let valid = Gaussian {
        rotation: (rotation / longest).normalize(),
        sigma: sigma.map(|sigma| if sigma == 0.0 { flattest } else { sigma }),
        color: color.clamp(Vec3::ZERO, Vec3::ONE),
        ..splat
    };
    valid.problem(1.0, GaussianOpacity::Splat).map_or(Ok(valid), Err)
}
