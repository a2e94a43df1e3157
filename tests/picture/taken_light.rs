//! Light of particles and voxels that the pictures through the samples of a pixel share.
use crate::common::{
    TIERS, Tier, gpu,
    scenes::{empty, light, material, random_discs},
    tiers,
};
use gobo::{
    LightKind, Shadows, Transfer,
    glam::{UVec2, Vec3},
    gpu::{Gpu, Timeline},
    model::View,
    shadows::Config,
    view::shadow_views,
};
use gobo_picture::{
    RenderOptions, Renderer,
    picture::{FirstLight, Kept, PictureCapacity, PictureRequest, PreparedPicture},
};
use gobo_reference::MeanPicture;
use gobo_scene::Scene;

/// Translucent discs under a sun.
fn discs() -> Scene {
    let mut scene = empty(vec![material(Transfer::Filter)]);
    (scene.camera.size, scene.samples) = (UVec2::new(64, 48), 4);
    scene.particles = random_discs(200, 4);
    let direction = Vec3::new(0.3, -1.0, 0.1);
    scene.lights = vec![light(LightKind::Directional { direction })];
    (scene.ambient, scene.background) = (Vec3::ZERO, Vec3::ZERO);
    scene
}

/// A scene of `data/`.
fn small(name: &str) -> Scene {
    let set = [("camera.size", "[96, 54]"), ("shadow.size", "256"), ("camera.samples", "4")];
    let set: Vec<_> =
        set.into_iter().map(|(key, value)| (key.to_owned(), value.to_owned())).collect();
    let path = format!("{}/data/{name}.toml", crate::common::root().display());
    gobo_scene::load_with(path.as_ref(), &set).unwrap()
}

/// The mean of samples that share light is that of samples alone, of particles and of voxels.
#[test]
fn samples_that_share_light_show_what_samples_alone_show() {
    let mut renderer = Renderer::on(gpu(TIERS[0])).unwrap();
    for (name, scene) in [("discs", discs()), ("cloud", small("cloud"))] {
        let found = renderer.render(&scene, &RenderOptions::default()).unwrap().picture;
        let mut mean = MeanPicture::new(&scene);
        for sample in 0..4 {
            let options =
                RenderOptions { sample: Some(sample), light: true, ..RenderOptions::default() };
            let alone = renderer.render(&scene, &options).unwrap().picture;
            mean.add(alone.light.iter().map(|light| (*light).into()));
        }
        let expected = mean.picture();
        let size = found.size;
        for (at, (a, b)) in (0..).zip(found.rgb.iter().zip(&expected.rgb)) {
            // At the border, a sample may show what the first does not.
            let [x, y] = [at % size.x, at / size.x];
            let is_inside = x > 1 && y > 1 && x + 2 < size.x && y + 2 < size.y;
            let most = if is_inside { 0 } else { 40 };
            let apart = (0..3).map(|i| a[i].abs_diff(b[i])).max().unwrap();
            assert!(apart <= most, "{name}, {x} {y}: {a:?}, not {b:?}");
        }
    }
}

/// Linear light of the picture through a sample, and what others may take over.
fn lit(
    gpu: &Gpu,
    scene: &Scene,
    sample: usize,
    first_light: Option<FirstLight>,
) -> (f32, FirstLight) {
    let config = Config::new(gpu.tier, &gpu.adapter);
    let mut shadows =
        Shadows::sharing(&gpu.device, &gpu.queue, config, gpu.kernels.clone()).unwrap();
    let views = shadow_views(scene);
    let prepared = shadows.prepare(&scene.casters(), &views, &scene.shadow).unwrap();
    let whole = View::from_camera(&scene.camera, &scene.held_bounds());
    let camera = &View::of_samples(scene, &whole).nth(sample).unwrap();
    let capacity = PictureCapacity::default();
    let request = PictureRequest { scene, camera, prepared: &prepared, capacity };
    let mut kept = Kept::default();
    kept.first_light = first_light;
    let picture = PreparedPicture::new(&shadows, &request, &mut kept).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    picture.record(&mut encoder, &mut Timeline::untimed());
    gpu.queue.submit([encoder.finish()]);
    let light = picture.read_radiance(gpu).unwrap();
    (light.iter().map(|light| light[0]).sum(), picture.first_light())
}

/// The light that is taken over is that of the other picture, even where it was three times as bright.
#[test]
fn light_of_particles_is_looked_up_once() {
    let scene = discs();
    let mut brighter = scene.clone();
    brighter.lights[0].intensity *= 3.0;
    for tier in tiers(Tier::Core) {
        let gpu = gpu(tier);
        let (_, first) = lit(&gpu, &brighter, 0, None);
        let (own, _) = lit(&gpu, &scene, 1, None);
        let (taken, _) = lit(&gpu, &scene, 1, Some(first));
        assert!(own > 0.0 && (taken / own - 3.0).abs() < 0.02, "{tier:?}: {taken}, {own}");
    }
}
