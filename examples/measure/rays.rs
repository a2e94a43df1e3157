//! Rays of a sun through the casters of a scene, and errors of stored light along them.
use gobo::{
    glam::{DVec3, UVec2, Vec3},
    model::{Light, LightKind, Receiver, View},
    view::shadow_views,
};
use gobo_scene as scene;
use gobo_scene::{Scene, generate::Chance};
use std::{
    error::Error,
    path::PathBuf,
    sync::atomic::{AtomicU32, Ordering::Relaxed},
};

/// Receivers along a ray, evenly from the near plane to the far one.
pub(crate) const DEPTHS: usize = 128;
/// Most rays tested for casters, for each ray that is used.
const TRIES: usize = 40;

/// A scene file of this text.
pub(crate) fn scene_of(text: &str) -> Result<Scene, Box<dyn Error>> {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let name = format!("rays-{}-{}.toml", std::process::id(), COUNT.fetch_add(1, Relaxed));
    let path = std::env::temp_dir().join(name);
    std::fs::write(&path, text)?;
    let scene = scene::load(&path);
    std::fs::remove_file(&path)?;
    Ok(scene?)
}

/// A file of real casters, in the folder `GOBO_ASSETS` or beside the repository.
pub(crate) fn asset(name: &str) -> Option<PathBuf> {
    let beside = || concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets").into();
    let path = std::env::var_os("GOBO_ASSETS").map_or_else(beside, PathBuf::from).join(name);
    path.is_file().then_some(path)
}

/// Only the Gaussians, grids and strands of a scene, under a sun with curves of `nodes` nodes.
pub(crate) fn under_a_sun(mut scene: Scene, size: u32, nodes: u32) -> Scene {
    let direction = Vec3::new(-0.4, -1.0, -0.3).normalize();
    let kind = LightKind::Directional { direction };
    scene.lights = vec![Light { kind, size: Some(size), ..Light::default() }];
    scene.particles.clear();
    scene.triangles.clear();
    scene.shadow.receiver = Receiver::Curve;
    (scene.shadow.size, scene.shadow.nodes) = (size, nodes);
    scene
}

/// The ray through the middle of a texel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) texel: usize,
    /// Point at light depth 0, world space [m].
    pub(crate) start: DVec3,
    /// Vector from there to light depth 1 [m].
    pub(crate) way: DVec3,
}

impl Ray {
    /// A ray of an orthographic view.
    fn new(view: &View, texel: UVec2) -> Self {
        let world_from_view = view.view_from_world.as_dmat4().inverse();
        let aside = texel.as_dvec2() + 0.5 - view.size.as_dvec2() * 0.5;
        let aside = aside / f64::from(view.scale);
        let at = |depth: f32| DVec3::new(aside.x, -aside.y, -f64::from(depth));
        let [start, end] = [view.near, view.far].map(|d| world_from_view.transform_point3(at(d)));
        let texel = (texel.y * view.size.x + texel.x) as usize;
        Self { texel, start, way: end - start }
    }
}

/// The light depths of the receivers.
pub(crate) fn depths() -> impl Iterator<Item = f64> {
    (0..DEPTHS).map(|i| (i as f64 + 0.5) / DEPTHS as f64)
}

/// Results of `meet` for up to `count` random rays of a scene's light, without those that it rejects.
pub(crate) fn rays<T>(
    scene: &Scene,
    count: usize,
    meet: impl Fn(&Ray) -> Option<T>,
) -> Vec<(Ray, T)> {
    let view = &shadow_views(scene)[0];
    let mut chance = Chance::new(7);
    let random = || {
        let [x, y] = [view.size.x, view.size.y].map(|size| chance.below(size as usize) as u32);
        Ray::new(view, UVec2::new(x, y))
    };
    let all = std::iter::repeat_with(random).take(count * TRIES);
    all.filter_map(|ray| meet(&ray).map(|met| (ray, met))).take(count).collect()
}

/// Errors of light over rays, depths and channels.
#[derive(Clone, Debug, Default)]
pub(crate) struct Errors(Vec<f64>);

impl Errors {
    pub(crate) fn add(&mut self, found: DVec3, expected: DVec3) {
        self.0.extend((found - expected).abs().to_array());
    }

    pub(crate) fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len() as f64
    }

    /// Quantile of the errors at this share.
    pub(crate) fn quantile(&self, share: f64) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[((sorted.len() - 1) as f64 * share) as usize]
    }
}
