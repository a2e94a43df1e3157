//! Exposure of a file's own picture, by the light of its own lamps.
use super::rays::{Met, Rays};
use glam::{UVec2, Vec3};
use gobo::model::{Camera, Light, LightKind, Material, Scene};
use std::f32::consts::FRAC_1_PI;

/// Rays of the picture in which light is looked at.
const RAYS: UVec2 = UVec2::new(48, 27);
/// Share of what is seen that may be brighter than white.
const BURNT: f32 = 0.1;
/// Least light of lamps on a tenth of what is seen, beside the usual sky [white], and most stops by which it
/// is raised.
const FAINT: f32 = 0.3;
const MOST_RAISED: f32 = 5.0;
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);
/// Part of the way to a light behind which a surface is not in its shadow.
const SHORT: f32 = 1e-3;

/// Exposure at which all but a tenth of the surfaces that are seen would be at most white if their material
/// was \[stops\]. `sky_follows`: the sky is as bright in the picture at any exposure, and lamps that are
/// faint beside it are raised, unless something glows.
pub(super) fn exposure(scene: &Scene, camera: &Camera, sky_follows: bool) -> f32 {
    let rays = Rays::new(scene.triangles.iter(), &scene.materials);
    let seen = seen(&rays, camera, RAYS);
    let mut light: Vec<f32> = seen.iter().map(|met| luminance(scene, &rays, camera, met)).collect();
    if light.is_empty() {
        return 0.0;
    }
    let rank = (light.len() as f32 * (1.0 - BURNT)) as usize;
    let lamps = *light.select_nth_unstable_by(rank, f32::total_cmp).1;
    let sky = scene.mean_ambient().dot(LUMINANCE);
    let bright = if sky_follows { lamps / (1.0 - sky) } else { lamps + sky };
    if bright > 1.0 && bright.is_finite() {
        return -bright.log2();
    }
    let glows = |material: &Material| material.unlit || material.emission != Vec3::ZERO;
    let is_faint = lamps > 0.0 && lamps < FAINT;
    if sky_follows && is_faint && !scene.materials.iter().any(glows) {
        return (FAINT / lamps).log2().min(MOST_RAISED);
    }
    0.0
}

/// Surfaces that rays through a grid of the picture's places meet.
pub(super) fn seen<'a>(rays: &Rays<'a>, camera: &Camera, count: UVec2) -> Vec<Met<'a>> {
    let forward = (camera.target - camera.eye).normalize_or(Vec3::NEG_Z);
    let right = forward.cross(camera.up).normalize_or(Vec3::X);
    let up = right.cross(forward);
    let slope = (camera.fov_y * 0.5).tan();
    let aspect = camera.size.x as f32 / camera.size.y as f32;
    let places = (0..count.y).flat_map(|y| (0..count.x).map(move |x| UVec2::new(x, y)));
    let met = |place: UVec2| {
        let at = (place.as_vec2() + 0.5) / count.as_vec2() * 2.0 - 1.0;
        let aside = right * (at.x * slope * aspect) - up * (at.y * slope);
        rays.first(camera.eye, forward + aside)
    };
    places.filter_map(met).collect()
}

/// Light of lamps that a surface would scatter to the eye if it was white.
fn luminance(scene: &Scene, rays: &Rays<'_>, camera: &Camera, met: &Met<'_>) -> f32 {
    let material = &scene.materials[met.triangle.material as usize];
    if material.unlit || material.catcher {
        return 0.0;
    }
    let normal = if met.is_front { met.normal } else { -met.normal };
    // Off the surface, so that it does not shadow itself.
    let place = met.place.lerp(camera.eye, SHORT);
    let lamps = scene.lights.iter().map(|light| arriving(light, rays, place, normal));
    lamps.sum::<Vec3>().dot(LUMINANCE) * FRAC_1_PI
}

/// Irradiance by a light.
fn arriving(light: &Light, rays: &Rays<'_>, place: Vec3, normal: Vec3) -> Vec3 {
    let (from, share) = match light.kind {
        LightKind::Directional { direction } => (-direction.normalize_or_zero(), 1.0),
        LightKind::Point { position } => (position - place, 1.0),
        LightKind::Spot { position, direction, angle } => {
            let from = position - place;
            let cosine = -from.normalize_or_zero().dot(direction.normalize_or_zero());
            (from, if cosine > (angle * 0.5).cos() { 1.0 } else { 0.0 })
        }
    };
    let square = from.length_squared().max(1e-4);
    let cosine = from.dot(normal) / square.sqrt();
    let is_lit = share * cosine > 0.0;
    if !is_lit {
        return Vec3::ZERO;
    }
    let end = if matches!(light.kind, LightKind::Directional { .. }) { f32::MAX } else { 1.0 };
    let is_hidden = rays.first(place, from).is_some_and(|met| met.distance < end);
    if is_hidden { Vec3::ZERO } else { light.color * (light.intensity * cosine / square) }
}
