//! Filters that meet opaque receivers.
use crate::common::{TIERS, gpu};
use gobo::glam::{UVec2, Vec3};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::load;

/// A bar that a pane of amber enters: its front is seen through the pane, its back is lit through it.
#[test]
fn no_line_is_lighter_where_a_pane_meets_a_bar() {
    let path = crate::common::root().join("data/soft_box.toml");
    let mut scene = load(&path).unwrap();
    scene.camera.target = Vec3::new(-0.475, 0.9, 0.5) - scene.origin;
    scene.camera.fov_y = 0.0035;
    scene.camera.size = UVec2::new(160, 100);
    let options = RenderOptions { light: true, ..RenderOptions::default() };
    let frame = Renderer::on(gpu(TIERS[1])).unwrap().render(&scene, &options).unwrap();
    let light = &frame.picture.light;
    // Of amber, a twelfth of the light is blue; of white, nine tenths.
    let bar: Vec<f32> =
        light.iter().filter(|p| p[0] > 0.3 && p[1] > 0.3 * p[0]).map(|p| p[2] / p[0]).collect();
    let most = bar.iter().copied().fold(0.0, f32::max);
    println!("{} pixels, {most}", bar.len());
    assert!(bar.len() > 4000 && most < 0.1, "{} pixels, {most}", bar.len());
}
