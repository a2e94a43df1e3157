//! Texels and viewpoints chosen for lights with a size.
use super::soft_spots::error_in_penumbrae;
use crate::common::files::read;
use gobo::{Scene, glam::Vec3, model::ReceiverPoint};

/// A pane 15 cm over a floor under a rectangular light, in maps of 512 texels by default.
fn pane(shadow: &str, source: &str, more: &str) -> Scene {
    let text = format!(
        "[camera]\neye = [-0.6, 1.1, 0.9]\ntarget = [-0.75, 0, 0]\nfov_y = 40\nsize = [960, 540]\n\
         [shadow]\nsize = 512\nreceiver = 'curve'\n{shadow}\n\
         [[material]]\nname = 'solid'\ntransfer = 'opaque'\n\
         [[light]]\nkind = 'spot'\nposition = [1.2, 2.6, 1.2]\ndirection = [-1.2, -2.6, -1.2]\nangle = 90\n\
         source = {{ kind = 'rect', width = 0.6, height = 0.2{source} }}\n\
         [[shape]]\nkind = 'plane'\nmaterial = 'solid'\nscale = [12, 1, 12]\n\
         [[shape]]\nkind = 'pane'\nmaterial = 'solid'\ntranslation = [-0.637, 0.15, 0.082]\n\
         rotation = [90, 0, 25.8]\nscale = [0.5, 0.5, 1]\n{more}"
    );
    read(&text).unwrap()
}

/// Bars between the light and the pane: its middle sees less of the pane's edges than the rest does.
const BARS: &str = "[[shape]]\nkind = 'box'\nmaterial = 'solid'\ntranslation = [-0.3, 0.8, 0.4]\n\
     scale = [0.06, 0.02, 1]\n\
     [[shape]]\nkind = 'box'\nmaterial = 'solid'\ntranslation = [-0.15, 0.8, 0.4]\nscale = [0.06, 0.02, 1]\n\
     [[shape]]\nkind = 'box'\nmaterial = 'solid'\ntranslation = [0, 0.8, 0.4]\nscale = [0.06, 0.02, 1]\n";

#[test]
fn narrow_penumbrae_get_texels() {
    let at = |i: usize| (i as f32 + 0.5) / 90.0 * 1.3;
    let place = |i: usize| Vec3::new(at(i % 90) - 1.5, 0.0, at(i / 90) - 0.7);
    let points: Vec<_> =
        (0..90 * 90).map(|i| ReceiverPoint { position: place(i), normal: Vec3::Y }).collect();
    for (shadow, limits) in [("", [0.0, 0.03]), ("soft_detail = false", [0.05, 0.1])] {
        let error = error_in_penumbrae(&pane(shadow, "", ""), &points);
        println!("{shadow}: {error:.4}");
        assert!(error > limits[0] && error < limits[1], "{shadow}: {error}");
    }
}

#[test]
fn what_is_stated_is_the_least() {
    let given = |scene: &Scene| (scene.soft[0].size, scene.soft[0].viewpoints);
    let usual = pane("", "", "");
    assert!(given(&usual).0 >= 1024 && given(&usual).1 == 1, "{:?}", usual.soft);
    assert_eq!(usual.lights[0].size, Some(given(&usual).0));
    // Three texels for a penumbra of 0.2 m at 3.1 m, 0.15 m over the floor, in a map of 2 m at 1 m: about
    // 1,400.
    assert!((1000..2200).contains(&usual.soft[0].asked), "{:?}", usual.soft);
    assert!(pane("soft_detail = false", "", "").soft.is_empty());
    assert_eq!(given(&pane("soft_budget = 1", "", "")), (512, 1));
    let behind = pane("", "", BARS);
    assert_eq!(given(&behind).1, 4, "{:?}", behind.soft);
    assert_eq!(given(&pane("", ", viewpoints = 1", BARS)).1, 1);
    let within = pane("soft_budget = 1500000", "", BARS);
    let texels = |scene: &Scene| u64::from(given(scene).0).pow(2) * u64::from(given(scene).1);
    assert!(texels(&within) <= 1_500_000 && given(&within).1 == 4, "{:?}", within.soft);
}
