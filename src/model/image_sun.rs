//! The sun of an environment's image.
use super::environment::{RadianceMap, SunDisc};
use glam::Vec3;
use std::f32::consts::PI;

/// The sun of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageSun {
    /// Direction in which its light travels, unit.
    pub direction: Vec3,
    /// Irradiance of a surface that faces it: linear rgb.
    pub irradiance: Vec3,
    /// Angular diameter \[radians\].
    pub angle: f32,
}

/// Largest angle between the middle of an image's sun and its rim \[radians\].
const SUN_REACH: f32 = 0.06;
/// Least ratio of a sun's brightness to the mean around it.
const SUN_EXCESS: f32 = 20.0;
/// Least light of a sun, as a share of the light of a uniform sky as bright as everything else.
const SUN_SHARE: f32 = 0.3;

impl RadianceMap {
    /// Takes the sun out of the map: the texels [`SUN_EXCESS`] times brighter than the mean around the
    /// brightest texel, if they send more light than [`SUN_SHARE`] of all other light to a surface that faces
    /// them.
    pub(super) fn take_sun(&mut self) -> Option<ImageSun> {
        let power = |radiance: Vec3| radiance.element_sum();
        let brightest = (0..self.texels.len())
            .max_by(|&a, &b| power(self.texels[a]).total_cmp(&power(self.texels[b])))?;
        let toward = self.direction(brightest);
        let near = |i: &usize| self.direction(*i).dot(toward) >= SUN_REACH.cos();
        let (disc, around): (Vec<usize>, Vec<usize>) = (0..self.texels.len()).partition(near);
        let mean = |texels: &[usize]| {
            let angle: f32 = texels.iter().map(|&i| self.solid_angle(i)).sum();
            texels.iter().map(|&i| self.texels[i] * self.solid_angle(i)).sum::<Vec3>() / angle
        };
        let all = mean(&around);
        let is_sun = |i: &usize| power(self.texels[*i]) > SUN_EXCESS * power(all);
        let (disc, halo): (Vec<usize>, Vec<usize>) = disc.into_iter().partition(is_sun);
        let sky = if halo.is_empty() { all } else { mean(&halo) };
        let excess = |i: usize| (self.texels[i] - sky).max(Vec3::ZERO) * self.solid_angle(i);
        let irradiance: Vec3 = disc.iter().map(|&i| excess(i)).sum();
        if power(irradiance) <= SUN_SHARE * PI * power(all) {
            return None;
        }
        let weighted = |i: &usize| self.direction(*i) * power(excess(*i));
        let direction = -disc.iter().map(weighted).sum::<Vec3>().normalize_or(toward);
        // A disc as bright as its brightest texel.
        let brightest = power((self.texels[brightest] - sky).max(Vec3::ZERO));
        let angle = power(irradiance) / brightest.max(f32::MIN_POSITIVE);
        let angle = 2.0 * (1.0 - angle / (2.0 * PI)).clamp(-1.0, 1.0).acos();
        disc.iter().for_each(|&i| self.texels[i] = sky);
        Some(ImageSun { direction, irradiance, angle: angle.max(SunDisc::USUAL_ANGLE) })
    }
}
