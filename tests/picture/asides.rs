//! Saved values of area lights' look-ups, in workgroup memory as on GPUs and in registers as on software
//! adapters, give the same bits.
use super::{air::AIR, masks};
use crate::common::{TIERS, gpu};
use gobo::{
    glam::UVec2,
    model::{MaskSettings, Source},
    records::Picture,
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::Scene;

fn picture(scene: &Scene, in_registers: bool) -> Picture {
    let mut renderer = Renderer::on(gpu(TIERS[0])).unwrap();
    renderer.configure(|config| config.tuning.columns = in_registers);
    let options = RenderOptions { light: true, ..RenderOptions::default() };
    let frame = renderer.render(scene, &options);
    frame.unwrap_or_else(|error| panic!("{error}")).picture
}

/// A sun with cascades and a lamp with six faces, both with a size, over solids and a pane, in air, with
/// masks and without.
#[test]
fn asides_change_no_bit() {
    let mut scene = masks::room(true);
    scene.camera.size = UVec2::new(48, 32);
    scene.lights[0].source = Some(Source::Sun { angle: 0.06 });
    scene.lights[1].source = Some(Source::Sphere { radius: 0.3 });
    scene.lights.iter_mut().for_each(|light| light.size = Some(128));
    scene.air = Some(AIR);
    for mask in [None, Some(MaskSettings { half: false, ..MaskSettings::default() })] {
        scene.mask = mask;
        let [laid, kept] = [false, true].map(|in_registers| picture(&scene, in_registers));
        assert!(!laid.light.is_empty() && laid.rgb.len() == kept.rgb.len());
        let pixels = laid.light.iter().zip(&kept.light);
        assert_eq!(pixels.filter(|(a, b)| a != b).count(), 0, "{mask:?}");
        // Part of it is in penumbrae.
        let shades: std::collections::HashSet<_> = laid.rgb.iter().collect();
        assert!(shades.len() > 100, "{} colours", shades.len());
    }
}
