//! Importance of a light in the picture, which sets the size of its maps.
use crate::model::{Camera, Light, LightKind, MIN_MAP_SIZE, Moment, Scene, TILE_SIZE};
use glam::Vec3;

/// Most halvings of a map.
const MAX_HALVINGS: u32 = 3;
/// Smallest halved map \[texels\].
const SMALLEST: u32 = 64;

/// Edge of the maps of a scene's light that sets none \[texels\]: for a light that moves or is seen by a
/// moving camera, the largest over the moments of the scene's course.
pub(super) fn usual_size(scene: &Scene, index: usize) -> u32 {
    let light = &scene.lights[index];
    let most = if light.caustics > 0 { light.largest_caustic_map() } else { u32::MAX };
    let size = scene.shadow.size.min(most);
    let changes = [scene.course.moves_camera(), scene.course.changes_light(index)];
    let of = |moment: &Moment| {
        let camera = if changes[0] { &moment.camera } else { &scene.camera };
        let light = if changes[1] { &moment.lights[index] } else { light };
        map_size(light, camera, size)
    };
    let sizes = scene.moments().iter().map(of);
    sizes.max().unwrap_or_else(|| map_size(light, &scene.camera, size))
}

/// Edge of a light's maps \[texels\]: `size` if the light's sphere of influence may fill the picture's
/// height, halved for each halving of the share that it can fill.
fn map_size(light: &Light, camera: &Camera, size: u32) -> u32 {
    let share = share_of_picture(light, camera);
    let halvings = if share > 0.0 {
        (-share.log2()).floor().clamp(0.0, MAX_HALVINGS as f32) as u32
    } else {
        MAX_HALVINGS
    };
    let least = size.clamp(MIN_MAP_SIZE, SMALLEST);
    if halvings == 0 {
        size
    } else {
        (size >> halvings).next_multiple_of(TILE_SIZE).max(least).min(size)
    }
}

/// Diameter of the light's sphere of influence on screen \[heights of the picture\].
fn share_of_picture(light: &Light, camera: &Camera) -> f32 {
    let position = match light.kind {
        LightKind::Directional { .. } => return 1.0,
        LightKind::Spot { position, .. } | LightKind::Point { position } => position,
    };
    let (reach, away) = (light.reach(), position - camera.eye);
    let distance = away.length();
    if distance <= reach {
        return 1.0;
    }
    let forward: Vec3 = (camera.target - camera.eye).normalize();
    if away.dot(forward) <= -reach {
        return 0.0;
    }
    let slope = reach / (distance * distance - reach * reach).sqrt();
    (slope / (camera.fov_y * 0.5).tan()).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    #[test]
    fn far_lights_get_smaller_maps() {
        let camera = Camera {
            eye: Vec3::ZERO,
            target: Vec3::NEG_Z,
            up: Vec3::Y,
            fov_y: std::f32::consts::FRAC_PI_2,
            size: UVec2::new(200, 100),
        };
        // A light with a reach of 1 m.
        let size = |position, size| {
            let kind = LightKind::Point { position };
            map_size(&Light { kind, intensity: 0.01, ..Light::default() }, &camera, size)
        };
        let at = |z: f32| size(Vec3::new(0.0, 0.0, -z), 1024);
        assert_eq!([0.5, 1.2, 2.5, 5.0, 10.0, 1e5].map(at), [1024, 1024, 512, 256, 128, 128]);
        assert_eq!(size(Vec3::Z * 5.0, 1024), 128, "behind the camera");
        assert_eq!(size(Vec3::Z * 5.0, 48), 48, "small ones stay");
        assert_eq!(size(Vec3::NEG_Z * 2.5, 200), 112, "whole tiles");
        let sun = Light { intensity: 0.0, ..Light::default() };
        assert_eq!(map_size(&sun, &camera, 1000), 1000);
    }
}
