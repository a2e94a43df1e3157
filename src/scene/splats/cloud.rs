//! Splats of a file, checked one by one.
use super::{Fault, placed};
use crate::{
    model::{FARTHEST, Skipped},
    scene::limits::Limit,
};
use glam::{Mat4, Quat, Vec3};

/// An anisotropic Gaussian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat {
    /// Centre [m].
    pub center: Vec3,
    /// Rotation from its own axes, unit.
    pub rotation: Quat,
    /// Standard deviations along its own axes [m].
    pub sigma: Vec3,
    /// Opacity at its centre, 0..=1; of a medium the share of the cloud's [`Cloud::extinction`].
    pub opacity: f32,
    /// Base colour, 0..=1.
    pub color: Vec3,
}

/// The splats of a file.
#[derive(Clone, Debug, Default)]
pub struct Cloud {
    /// Splats in the order of the file.
    pub splats: Vec<Splat>,
    /// Extinction at the centre of a splat of opacity 1 [1/m], if the file holds a medium.
    pub extinction: Option<f32>,
    /// Splats left out, by reason.
    pub skipped: Skipped,
    /// What of the file is ignored, a sentence each.
    pub notes: Vec<String>,
    /// Row of the file of each splat; empty where no row was skipped.
    pub rows: Vec<u32>,
    /// Colours that were outside 0..=1.
    clamped: u64,
}

/// A deviation of 0 becomes this share of the largest: a flat splat without a division by 0.
const FLATTEST: f32 = 1e-6;

impl Cloud {
    /// An empty cloud with room for `count` splats.
    pub(in crate::scene) fn with_room(count: u64) -> Result<Self, Fault> {
        Limit::Splats.grown(0, count)?;
        let mut cloud = Self::default();
        let bytes = count * size_of::<Splat>() as u64;
        let help = "use a smaller file, or a machine with more memory";
        let fault = || (format!("no memory for {count} splats ({} MiB)", bytes >> 20), help);
        cloud.splats.try_reserve_exact(count as usize).map_err(|_| fault())?;
        Ok(cloud)
    }

    /// Adds the next splat of the file if it is valid; normalises its rotation, clamps its colour.
    pub(super) fn push(&mut self, splat: Splat) {
        self.take(valid(splat), splat.color);
    }

    /// Like [`Self::push`], in the space of the file. World space = `world` * the splat's space.
    pub(in crate::scene) fn push_placed(&mut self, splat: Splat, world: &Mat4) {
        self.take(valid(splat).and_then(|splat| valid(placed(&splat, world))), splat.color);
    }

    fn take(&mut self, checked: Result<Splat, &'static str>, color: Vec3) {
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

    /// Notes what is left out of each splat's colour: `count` coefficients of higher spherical harmonics.
    pub(in crate::scene) fn leave_out_harmonics(&mut self, count: usize) {
        if count > 0 && !self.splats.is_empty() {
            self.notes.push(format!(
                "{count} coefficients of spherical harmonics of each splat are not read: its colour is \
                 the same from all sides"
            ));
        }
    }

    /// The whole cloud, with a note about its colours.
    pub(in crate::scene) fn finish(mut self) -> Self {
        if self.clamped > 0 {
            self.notes.push(format!("colours of {} splats are clamped to 0 to 1", self.clamped));
        }
        self
    }
}

fn valid(splat: Splat) -> Result<Splat, &'static str> {
    let Splat { center, rotation, sigma, opacity, color } = splat;
    let is_finite = center.is_finite()
        && rotation.is_finite()
        && sigma.is_finite()
        && opacity.is_finite()
        && color.is_finite();
    if !is_finite {
        return Err("splat not finite");
    }
    if center.abs().max_element().max(sigma.max_element()) > FARTHEST {
        return Err("splat too far");
    }
    // Squares of a short quaternion would vanish.
    let longest = rotation.to_array().iter().fold(0.0, |most: f32, part| most.max(part.abs()));
    if longest == 0.0 {
        return Err("splat without rotation");
    }
    let flattest = sigma.max_element() * FLATTEST;
    if sigma.min_element() < 0.0 || flattest <= 0.0 {
        return Err("splat without extent");
    }
    if !(0.0..=1.0).contains(&opacity) {
        return Err("opacity out of range");
    }
    Ok(Splat {
        rotation: (rotation / longest).normalize(),
        sigma: sigma.max(Vec3::splat(flattest)),
        color: color.clamp(Vec3::ZERO, Vec3::ONE),
        ..splat
    })
}
