//! Light that the pictures through the samples of a pixel share: of particles, of voxels, and of surfaces
//! where the first two say that it is even.
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

/// The mean of samples that share light is that of samples alone, of particles, of voxels and of surfaces.
#[test]
fn samples_that_share_light_show_what_samples_alone_show() {
    let mut renderer = Renderer::on(gpu(TIERS[0])).unwrap();
    for (name, scene, of_surfaces) in [("discs", discs(), 0), ("cloud", small("cloud"), 3)] {
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
            // Even light of surfaces is off by up to `UNEVEN`, and by as much again between pixels.
            let most = if is_inside { of_surfaces } else { 40 };
            let apart = (0..3).map(|i| a[i].abs_diff(b[i])).max().unwrap();
            assert!(apart <= most, "{name}, {x} {y}: {a:?}, not {b:?}");
        }
    }
}

/// Linear light of the picture through a sample, row by row, and what others may take over.
fn lit(
    gpu: &Gpu,
    scene: &Scene,
    sample: usize,
    first_light: Option<FirstLight>,
) -> (Vec<f32>, FirstLight) {
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
    kept.is_first = true;
    kept.first_light = first_light;
    let picture = PreparedPicture::new(&shadows, &request, &mut kept).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    picture.record(&mut encoder, &mut Timeline::untimed());
    gpu.queue.submit([encoder.finish()]);
    let light = picture.read_radiance(gpu).unwrap();
    (light.iter().map(|light| light[0]).collect(), picture.first_light())
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
        let [own, taken] = [own, taken].map(|light| light.iter().sum::<f32>());
        assert!(own > 0.0 && (taken / own - 3.0).abs() < 0.02, "{tier:?}: {taken}, {own}");
    }
}

/// A white floor below a lamp, seen from above, with the shadow of a bar across it.
fn floor() -> Scene {
    crate::common::files::read(
        "[camera]\neye = [0, 6, 0.01]\ntarget = [0, 0, 0]\nfov_y = 30\nsize = [96, 64]\nsamples = 4\n\
         occlusion = false\n[environment]\nambient = [0.05, 0.05, 0.05]\nbackground = [0, 0, 0]\n\
         [shadow]\nsize = 512\n\
         [[light]]\nkind = 'point'\nposition = [1.5, 1, 0.3]\nintensity = 3\n\
         [[material]]\nname = 'white'\ntransfer = 'opaque'\ntint = [1, 1, 1, 1]\n\
         [[shape]]\nkind = 'box'\nmaterial = 'white'\nscale = [20, 1, 20]\ntranslation = [0, -0.5, 0]\n\
         [[shape]]\nkind = 'box'\nmaterial = 'white'\nscale = [0.1, 0.1, 8]\ntranslation = [0.3, 0.4, 0]\n",
    )
    .unwrap_or_else(|error| panic!("{error}"))
}

/// Light that pictures through the first two samples keep for further ones.
fn kept(gpu: &Gpu, [first, second]: [&Scene; 2]) -> FirstLight {
    let (_, first) = lit(gpu, first, 0, None);
    let (_, both) = lit(gpu, second, 1, Some(first));
    both
}

/// Even light of the floor is that of other pictures; edges of the bar and of its shadow have their own.
#[test]
fn even_light_of_surfaces_is_looked_up_once() {
    let scene = floor();
    let mut brighter = scene.clone();
    brighter.lights[0].intensity *= 3.0;
    brighter.ambient *= 3.0;
    for tier in tiers(Tier::Core) {
        let gpu = gpu(tier);
        let (own, _) = lit(&gpu, &scene, 2, None);
        let (taken, _) = lit(&gpu, &scene, 2, Some(kept(&gpu, [&brighter; 2])));
        let ratio = |(taken, own): (&f32, &f32)| taken / own;
        let ratios: Vec<f32> = taken.iter().zip(&own).map(ratio).collect();
        let near = |to: f32| ratios.iter().filter(|ratio| (*ratio / to - 1.0).abs() < 0.03).count();
        let (even, edges) = (near(3.0), near(1.0));
        let all = ratios.len();
        println!("{tier:?}: {even} and {edges} of {all}");
        assert!(even > all * 6 / 10 && edges > all / 50, "{tier:?}: {even}, {edges} of {all}");
        assert!(even + edges > all * 98 / 100, "{tier:?}: {even}, {edges} of {all}");
        // Light is taken over only where both pictures agree.
        let (alone, _) = lit(&gpu, &scene, 2, Some(kept(&gpu, [&scene, &brighter])));
        assert!(alone == own, "{tier:?}");
    }
}

/// Shadows of wires that are a fifth of a pixel wide are as dark as those of samples alone: the first samples
/// miss them on 3 x 3 pixels almost nowhere.
#[test]
fn shadows_of_wires_have_all_samples() {
    let mut text = "[camera]\neye = [0, 6, 6]\ntarget = [0, 0, 0]\nfov_y = 60\nsize = [480, 270]\n\
                    [[light]]\nkind = 'directional'\ndirection = [0.3, -1, 0.1]\nintensity = 3\n\
                    [[material]]\nname = 'white'\ntransfer = 'opaque'\ntint = [0.8, 0.8, 0.8, 1]\n\
                    [[shape]]\nkind = 'box'\nmaterial = 'white'\nscale = [12, 1, 8]\n\
                    translation = [0, -0.5, 0]\n"
        .to_owned();
    for x in -3..=3 {
        text += &format!(
            "[[shape]]\nkind = 'box'\nmaterial = 'white'\nscale = [0.008, 0.008, 6]\n\
             translation = [{x}, 0.5, 0]\n"
        );
    }
    let mut scene = crate::common::files::read(&text).unwrap_or_else(|error| panic!("{error}"));
    let mut renderer = Renderer::on(gpu(TIERS[0])).unwrap();
    let mut picture =
        |scene: &Scene| renderer.render(scene, &RenderOptions::default()).unwrap().picture.rgb;
    let shared = picture(&scene);
    // Through a lens, samples share nothing.
    scene.lens.radius = 1e-7;
    let alone = picture(&scene);
    let apart = |(a, b): (&[u8; 3], &[u8; 3])| (0..3).any(|i| a[i].abs_diff(b[i]) > 4);
    let apart = shared.iter().zip(&alone).filter(|&both| apart(both)).count();
    println!("{apart} of {}", shared.len());
    assert!(apart < 25, "{apart} pixels");
}

/// A white slab a little off the rows of pixels, and a ball, from above in the sun.
const SLAB: &str = "
[camera]
eye = [0, 5, 0]
target = [0, 0, 0]
up = [0, 0, -1]
fov_y = 30
size = [160, 120]
occlusion = false
[[light]]
kind = 'directional'
direction = [0.5, -1, 0.2]
intensity = 2.5
[[material]]
name = 'white'
transfer = 'opaque'
tint = [0.8, 0.8, 0.8, 1]
roughness = 1
[[material]]
name = 'dark'
transfer = 'opaque'
tint = [0.1, 0.1, 0.1, 1]
roughness = 1
[[shape]]
kind = 'plane'
material = 'dark'
scale = [20, 1, 20]
[[shape]]
kind = 'box'
material = 'white'
translation = [0, 0.05, 0]
rotation = [0, 7, 0]
scale = [1.2, 0.1, 1.8]
[[shape]]
kind = 'sphere'
material = 'white'
translation = [-1.3, 0.2, 0]
scale = [0.3, 0.3, 0.3]
";

/// Distance of the slab's left edge from a straight line, root mean square over rows [pixels], and the number
/// of pixels that it crosses.
fn roughness(picture: &[[u8; 3]]) -> (f64, usize) {
    // Tones are averaged before they are encoded.
    let tone = |at: usize| {
        let encoded = f64::from(picture[at][1]) / 255.0;
        if encoded > 0.04045 { ((encoded + 0.055) / 1.055).powf(2.4) } else { encoded / 12.92 }
    };
    let (mut edges, mut crossed) = (Vec::new(), 0);
    for row in 30..90 {
        let [dark, white] = [38, 66].map(|column| tone(row * 160 + column));
        let shares = (38..66).map(|column| (tone(row * 160 + column) - dark) / (white - dark));
        crossed += shares.clone().filter(|share| (0.05..0.95).contains(share)).count();
        edges.push((row as f64 - 59.5, shares.sum::<f64>()));
    }
    let mean = edges.iter().map(|edge| edge.1).sum::<f64>() / edges.len() as f64;
    let square: f64 = edges.iter().map(|(row, _)| row * row).sum();
    let slope = edges.iter().map(|(row, edge)| row * edge).sum::<f64>() / square;
    let off = edges.iter().map(|(row, edge)| (edge - mean - slope * row).powi(2)).sum::<f64>();
    ((off / edges.len() as f64).sqrt(), crossed)
}

/// Edges of objects are as smooth as those of samples that share nothing.
#[test]
fn edges_of_objects_are_as_smooth() {
    let mut scene = crate::common::files::read(SLAB).unwrap_or_else(|error| panic!("{error}"));
    let mut renderer = Renderer::on(gpu(TIERS[0])).unwrap();
    let mut picture =
        |scene: &Scene| renderer.render(scene, &RenderOptions::default()).unwrap().picture.rgb;
    let shared = picture(&scene);
    scene.samples = 1;
    let single = roughness(&picture(&scene));
    // Through a lens, samples share nothing.
    (scene.samples, scene.lens.radius) = (4, 1e-7);
    let alone = picture(&scene);
    let (of_shared, of_alone) = (roughness(&shared), roughness(&alone));
    let apart = |(a, b): (&[u8; 3], &[u8; 3])| (0..3).map(|i| a[i].abs_diff(b[i])).max();
    let most = shared.iter().zip(&alone).filter_map(apart).max();
    println!("{of_shared:?}, {of_alone:?}, {single:?}, {most:?}");
    // The check must notice the stairs of single samples.
    assert!(single.0 > 2.0 * of_alone.0 && of_alone.1 > 40, "{single:?}, {of_alone:?}");
    assert!((of_shared.0 - of_alone.0).abs() < 0.005 && of_shared.1 == of_alone.1, "{of_shared:?}");
    assert!(most <= Some(4), "{most:?}");
}

/// Light that is taken over is that at the sample's own place: the lamp's light falls towards the border.
#[test]
fn light_that_is_taken_over_follows_its_slope() {
    let scene = floor();
    let gpu = gpu(TIERS[0]);
    let (former, _) = lit(&gpu, &scene, 0, None);
    let kept = kept(&gpu, [&scene; 2]);
    for sample in 2..4 {
        let (own, _) = lit(&gpu, &scene, sample, None);
        let (taken, _) = lit(&gpu, &scene, sample, Some(kept.clone()));
        let apart = |a: &[f32]| {
            let mut apart: Vec<f32> =
                a.iter().zip(&own).map(|(a, own)| (a / own - 1.0).abs()).collect();
            apart.sort_by(f32::total_cmp);
            apart[apart.len() / 2]
        };
        let (moved, still) = (apart(&taken), apart(&former));
        println!("{sample}: {moved} and {still}");
        assert!(still > 1e-3 && moved < 0.25 * still, "{sample}: {moved} and {still}");
    }
}
