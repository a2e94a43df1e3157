//! CPU reference of `crates/gobo-picture/wgsl/shade/shading.wgsl`: shares of light that surfaces, particles
//! and bricks send to the eye.
use super::{Point, PointKind};
use crate::air::phase;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI, TAU};

/// Share of the light that a point of albedo 1 sends to the eye.
pub(super) fn scattered(kind: PointKind, cosine: f32) -> f32 {
    match kind {
        PointKind::Solid | PointKind::Cover | PointKind::Leaf => cosine.max(0.0) * FRAC_1_PI,
        PointKind::Pane => cosine.abs() * FRAC_1_PI,
        // Isotropic.
        PointKind::Particle | PointKind::Strand | PointKind::Brick { .. } => 0.25 * FRAC_1_PI,
    }
}

/// Share of light in a strand's highlight, in its own colour: 0.04 from the surface of hair, and the light
/// returned from inside.
pub const SHEEN: f32 = 0.2;

/// Share of the light from `toward` that a strand of albedo 1 sends to the eye: the mean over the width of a
/// diffuse cylinder, and a highlight along the cone of mirrored light (Kajiya and Kay 1989), whose light the
/// diffuse part lacks.
pub(super) fn strand_scattered(point: &Point, toward: Vec3) -> f32 {
    let Point { normal: axis, to_eye, roughness, .. } = *point;
    let (along_light, along_eye) = (axis.dot(toward), axis.dot(to_eye));
    let sines = [along_light, along_eye].map(|cosine| (1.0 - cosine * cosine).max(1e-6).sqrt());
    let cosine = (toward.dot(to_eye) - along_light * along_eye) / (sines[0] * sines[1]);
    let angle = cosine.clamp(-1.0, 1.0).acos();
    let evenly = ((PI - angle) * angle.cos() + angle.sin()) * 0.25;
    let width = (roughness * roughness).max(0.04);
    let exponent = 2.0 / (width * width) - 1.0;
    let power = (sines[0] * sines[1] - along_light * along_eye).max(1e-6).powf(exponent);
    // The integral of a cosine's power is sqrt(TAU / (exponent + 0.5)), slightly less at small exponents.
    let lobe = 0.5 * ((exponent + 0.5) / TAU).sqrt() * power;
    // As wide a part of the highlight's cone is seen as of the strand itself: the mean square of the sine
    // over the lobe.
    let mirrored = SHEEN * (1.0 + exponent * sines[0] * sines[0]) / (exponent + 2.0);
    sines[0] * FRAC_1_PI * ((1.0 - mirrored) * evenly + SHEEN * lobe)
}

/// Orders of scattering in a brick.
pub const ORDERS: u32 = 4;
/// Transmittance that maps store as 0.
pub const DARKEST: f32 = 1.0 / 1024.0;

/// Share of the light that a brick scatters to the eye by multiple scattering, where `passed` comes straight
/// (Wrenninge, Kulla and Lundqvist 2013). Each order adds a part of the light missing after the one before:
/// where nothing is lost, the phase function alone scatters, and nowhere is there more light than comes in.
pub(super) fn phase_of_orders(passed: Vec3, cosine: f32, g: f32, albedo: Vec3) -> Vec3 {
    let mut light = (passed - DARKEST).max(Vec3::ZERO) / (1.0 - DARKEST);
    let (mut before, mut sum, mut share, mut lobe) = (Vec3::ZERO, Vec3::ZERO, Vec3::ONE, g);
    for _ in 0..ORDERS {
        sum += share * (light - before).max(Vec3::ZERO) * phase(cosine, lobe);
        before = light;
        light = light.map(f32::sqrt);
        share *= 0.5 * albedo;
        lobe *= 0.5;
    }
    sum
}

/// Reflectance of glass at normal incidence.
pub const HEAD_ON: f32 = 0.04;

/// Rise of reflectance from 0 head-on to 1 at 90 degrees (Schlick 1994).
pub(super) fn rising(cosine: f32) -> f32 {
    (1.0 - cosine).clamp(0.0, 1.0).powi(5)
}

/// Reflectance of an opaque surface for the environment; metal in its own colour.
pub(super) fn mirrored_solid(albedo: Vec3, metallic: f32, cosine: f32, roughness: f32) -> Vec3 {
    let head_on = Vec3::splat(HEAD_ON).lerp(albedo, metallic);
    head_on + (head_on.max(Vec3::splat(1.0 - roughness)) - head_on) * rising(cosine)
}

/// Specular highlight of a point, by its reflectance.
pub(super) fn highlight(point: &Point, toward: Vec3) -> Vec3 {
    let Point { normal, to_eye, roughness, gloss, albedo, metallic, .. } = *point;
    let head_on = Vec3::splat(HEAD_ON).lerp(albedo, metallic);
    let middle = (toward + to_eye).normalize();
    lobe(normal, middle, roughness) * gloss.mirrored(to_eye.dot(middle), head_on)
}

/// Highlight per unit of reflectance: Blinn 1977, normalised so that it sends out all light that arrives
/// head-on, and never more; exponent from the roughness as in Walter et al. 2007, section 6.
pub(super) fn lobe(normal: Vec3, middle: Vec3, roughness: f32) -> f32 {
    let width = (roughness * roughness).max(0.04);
    let exponent = 2.0 / (width * width) - 1.0;
    let lobe = normal.dot(middle).max(1e-6).powf(exponent);
    (exponent + 6.0) * (FRAC_1_PI / 8.0) * lobe
}
