//! Estimates of the CPU reference's time.
use super::{Engine, Renderer};
use glam::{UVec2, Vec3};
use gobo::{
    model::{
        Camera, Light, Material, Particle, Receiver, Scene, ShadowSettings, Transfer, Triangle,
    },
    view::{atlas::AtlasLimits, picture_views, shadow_views},
};
use gobo_reference::{Effort, render_maps, render_picture};
use std::time::{Duration, Instant};

/// Time for which a small scene is rendered again and again.
const PROBED: Duration = Duration::from_millis(40);

impl Renderer {
    /// Whether kernels render, and not the CPU reference.
    pub fn has_device(&self) -> bool {
        matches!(self.engine, Engine::Gpu(_))
    }

    /// Seconds that the CPU reference will take for a frame of the scene, mostly within a factor of three,
    /// from counts of its work and the time of a small scene that it renders here. `None` with a device.
    pub fn estimate(&self, scene: &Scene) -> Option<f64> {
        if self.has_device() {
            return None;
        }
        let probe = probe();
        let (views, _) = picture_views(&probe, &AtlasLimits::CORE);
        let (started, mut runs) = (Instant::now(), 0.0);
        while started.elapsed() < PROBED {
            let (maps, _) = render_maps(&probe, &views);
            render_picture(&probe, &views, &maps, &shadow_views);
            runs += 1.0;
        }
        Some(started.elapsed().as_secs_f64() / runs * work(scene) / work(&probe))
    }
}

/// Work of a frame, in the units of [`Effort`].
fn work(scene: &Scene) -> f64 {
    let (views, _) = picture_views(scene, &AtlasLimits::CORE);
    let Effort { maps, sample } = Effort::new(scene, &views);
    let samples = f64::from(scene.samples.max(1));
    // With an open shutter each sample has its own time and maps.
    let times = if scene.shutter > 0.0 { samples } else { 1.0 };
    times * maps + samples * sample
}

/// Discs above a ground, in curves.
fn probe() -> Scene {
    let ground = [Vec3::new(-2.0, 0.0, 2.0), Vec3::new(2.0, 0.0, 2.0), Vec3::new(0.0, 0.0, -3.0)];
    let opaque = Material { transfer: Transfer::Opaque, ..Material::default() };
    let at = |i: u8| Vec3::from([3, 5, 7].map(|step| f32::from(i.wrapping_mul(step)) / 256.0));
    let particle = |i| Particle { center: at(i), radius: 0.05, ..Particle::default() };
    Scene {
        camera: Camera {
            eye: Vec3::new(0.0, 1.0, 4.0),
            size: UVec2::splat(64),
            ..Camera::default()
        },
        shadow: ShadowSettings {
            size: 128,
            receiver: Receiver::Curve,
            ..ShadowSettings::default()
        },
        materials: vec![Material::default(), opaque],
        particles: (0..=255).map(particle).collect(),
        triangles: vec![Triangle::flat(ground, 1)],
        lights: vec![Light::directional(Vec3::new(-0.3, -1.0, -0.2))],
        ..Scene::default()
    }
}
