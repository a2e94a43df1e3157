//! Filters that meet opaque receivers.
use crate::common::{TIERS, gpu};
use gobo::glam::{UVec2, Vec3};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::load;

/// A bar partly inside an amber pane: its front is seen through the pane, its back is lit through it.
#[test]
fn no_line_is_lighter_where_a_pane_meets_a_bar() {
    let path = crate::common::root().join("data/soft_box.toml");
    let mut scene = load(&path).unwrap();
    scene.camera.target = Vec3::new(-0.475, 0.9, 0.5) - scene.origin;
    scene.camera.fov_y = 0.0035;
    scene.camera.size = UVec2::new(160, 100);
    let options = RenderOptions { light: true, ..RenderOptions::default() };
    let mut renderer = Renderer::on(gpu(TIERS[1])).unwrap();
    // In each, the bar's edge is elsewhere within a texel.
    for size in [512, 720, 784, 1024] {
        scene.lights[0].size = Some(size);
        let light = renderer.render(&scene, &options).unwrap().picture.light;
        // Blue is a twelfth of the light of amber, and nine tenths of the light of white.
        let is_bar = |p: &&[f32; 3]| p[0] > 0.3 && p[1] > 0.3 * p[0];
        let bar: Vec<f32> = light.iter().filter(is_bar).map(|p| p[2] / p[0]).collect();
        let most = bar.iter().copied().fold(0.0, f32::max);
        println!("{size}: {} pixels, {most}", bar.len());
        assert!(bar.len() > 4000 && most < 0.1, "{size}: {} pixels, {most}", bar.len());
    }
}
