//! Windows of finer texels for lights with a size: the extent of the ground changes no shadow on it.
use crate::common::{TIERS, files::read, gpu};
use gobo::{
    View,
    view::{atlas::AtlasLimits, picture_views},
};
use gobo_picture::{Picture, RenderOptions, Renderer};
use gobo_scene::Scene;

/// Posts, a pane and a high slab beside the picture. `ground`: its edge \[m\]; `angle`: of the sun.
fn scene(ground: u32, angle: f32, shadow: &str) -> Scene {
    let solid = |at: [f32; 3], scale: [f32; 3]| {
        format!(
            "[[shape]]\nkind = 'box'\nmaterial = 'solid'\ntranslation = {at:?}\nscale = {scale:?}\n"
        )
    };
    let posts = (0..5).map(|i| -2.0 + 0.6 * i as f32);
    let posts: String = posts.map(|x| solid([x, 0.35, x], [0.06, 0.7, 0.06])).collect();
    let slab = solid([2.5, 2.5, 1.5], [0.4, 0.3, 3.0]);
    let text = format!(
        "[camera]
eye = [0.9, 4.2, 1.8]
target = [-0.5, 0, 0.1]
fov_y = 36
size = [320, 180]
samples = 1
[shadow]
{shadow}
[[material]]
name = 'solid'
transfer = 'opaque'
[[material]]
name = 'orange'
tint = [0.9, 0.3, 0.1, 0.95]
[[light]]
kind = 'directional'
direction = [-0.5, -1, -0.3]
source = {{ kind = 'sun', angle = {angle} }}
[[shape]]
kind = 'plane'
material = 'solid'
scale = [{ground}, 1, {ground}]
[[shape]]
kind = 'box'
material = 'orange'
translation = [-0.8, 0.4, 0.6]
scale = [1.2, 0.3, 0.02]
{posts}{slab}"
    );
    read(&text).unwrap()
}

fn picture(scene: &Scene) -> Picture {
    let options = RenderOptions::default();
    Renderer::on(gpu(TIERS[0])).unwrap().render(scene, &options).unwrap().picture
}

/// Mean difference of the pixels [1/255], the largest of a pixel's channels.
fn apart(a: &Picture, b: &Picture) -> f64 {
    let of_pixel = |(a, b): (&[u8; 3], &[u8; 3])| {
        let channels = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
        f64::from(channels.max().unwrap_or(0))
    };
    a.rgb.iter().zip(&b.rgb).map(of_pixel).sum::<f64>() / a.rgb.len() as f64
}

/// Mean difference that texels of a pixel leave at edges and contacts [1/255].
const SAME: f64 = 0.3;

#[test]
fn wide_grounds_keep_their_soft_shadows() {
    for angle in [0.53, 3.0] {
        // Texels of 3.4 mm everywhere.
        let fine = picture(&scene(14, angle, "size = 4096\nsoft_detail = false"));
        for ground in [100, 1000] {
            let found = apart(&fine, &picture(&scene(ground, angle, "")));
            let without = apart(&fine, &picture(&scene(ground, angle, "detail = false")));
            println!("{angle} degrees, {ground} m: {found:.3}, without windows {without:.3}");
            assert!(found < SAME, "{angle} degrees, {ground} m: {found}");
            assert!(without > 1.5 * found, "{angle} degrees, {ground} m: {without}");
        }
    }
}

/// Each viewpoint has windows of its own, with names of their own.
#[test]
fn viewpoints_have_windows() {
    let mut scene = scene(1000, 0.53, "");
    for viewpoints in [1, 5] {
        scene.lights[0].viewpoints = viewpoints;
        let (views, _) = picture_views(&scene, &AtlasLimits::CORE);
        let bases = views.iter().filter(|view| !view.is_detail());
        assert_eq!(bases.count(), viewpoints as usize);
        let mut names: Vec<_> = views.iter().map(|view| view.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), views.len(), "{names:?}");
        let light = &scene.lights[0];
        let of = |number: usize| {
            let is_own = |view: &&View| view.is_detail() && view.shadow_index(light) == number;
            views.iter().filter(is_own).count()
        };
        for number in 0..viewpoints as usize {
            assert!((1..=6).contains(&of(number)), "{number}: {}", of(number));
        }
    }
}
