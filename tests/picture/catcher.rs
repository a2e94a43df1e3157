//! Shadow catchers: floors of which a picture shows only the shadows.
use crate::common::{
    TIERS,
    files::{Folder, read},
    reference_picture, render,
};
use gobo::{glam::Vec3, records::Picture};
use gobo_scene as scene;
use gobo_scene::Scene;

const FLOOR: &str = "
[camera]
eye = [0, 8, 0]
target = [0, 0, 0]
up = [0, 0, -1]
size = [64, 48]
samples = 1
occlusion = false
[shadow]
size = 256
[environment]
zenith = ZENITH
horizon = [0.3, 0.5, 0.9]
ground = [0.3, 0.5, 0.9]
[[light]]
kind = 'directional'
direction = [1, -1, 0]
intensity = 2
[[material]]
name = 'floor'
transfer = 'opaque'
catcher = true
tint = [0, 0, 0, 1]
roughness = 0.1
[[material]]
name = 'pane'
tint = [0.25, 1, 0.5, 1]
visible = false
[[shape]]
kind = 'plane'
material = 'floor'
scale = [6, 1, 4]
[[shape]]
kind = 'plane'
material = 'pane'
translation = [-2, 2, 0]
scale = [2, 1, 2]
";

fn floor(zenith: &str) -> Scene {
    read(&FLOOR.replace("ZENITH", zenith)).unwrap()
}

fn pictures(scene: &Scene) -> Vec<Picture> {
    let of_tiers = TIERS.map(|tier| render(tier, scene).picture);
    [reference_picture(scene)].into_iter().chain(of_tiers).collect()
}

fn light_at(picture: &Picture, x: f32, z: f32) -> Vec3 {
    let metre = 24.0 / 22.5f32.to_radians().tan() / 8.0;
    let [column, row] = [32.0 + x * metre, 24.0 + z * metre];
    picture.light[row as usize * 64 + column as usize].into()
}

/// Surroundings of one radiance, so that the whole light of the floor is known.
#[test]
fn a_catcher_shows_what_is_behind_it_times_its_share_of_the_light() {
    let around = Vec3::new(0.3, 0.5, 0.9);
    let sun = 2.0 * std::f32::consts::FRAC_1_SQRT_2 * std::f32::consts::FRAC_1_PI;
    let glass = Vec3::new(0.25, 1.0, 0.5);
    let shaded = around * (around + sun * glass) / (around + sun);
    for picture in pictures(&floor("[0.3, 0.5, 0.9]")) {
        // In the pane's shadow, beside it, and beside the floor.
        for (x, expected) in [(0.0, shaded), (2.0, around), (-2.0, around), (-4.0, around)] {
            let found = light_at(&picture, x, 0.0);
            assert!((found - expected).abs().max_element() < 2e-3, "{x}: {found}, {expected}");
        }
    }
}

/// Without a caster, a floor under any lights and surroundings is invisible.
#[test]
fn a_catcher_without_shadows_is_not_seen() {
    let mut with = floor("[0.1, 0.1, 0.4]");
    with.triangles.truncate(2);
    let lamps = "
[[light]]
kind = 'point'
position = [1, 1, 0.5]
color = [1, 0.2, 0.1]
intensity = 3
[[light]]
kind = 'spot'
position = [-1, 2, 0]
direction = [0, -1, 0]
angle = 50
intensity = 9
";
    let more = read(&(FLOOR.replace("ZENITH", "[0, 0, 0]") + lamps)).unwrap();
    with.lights.extend_from_slice(&more.lights[1..]);
    let mut without = with.clone();
    without.triangles.clear();
    for mask in [false, true] {
        with.mask = mask.then(Default::default);
        for (with, without) in pictures(&with).iter().zip(pictures(&without)) {
            for (a, b) in with.light.iter().zip(&without.light) {
                let apart = (Vec3::from(*a) - Vec3::from(*b)).abs().max_element();
                assert!(apart < 2e-3, "{a:?}, not {b:?}");
            }
        }
    }
    // In the dark it shows its background unchanged.
    with.lights.clear();
    with.environment = None;
    with.ambient = Vec3::ZERO;
    with.background = Vec3::splat(0.5);
    for picture in pictures(&with) {
        let [inside, outside] = [0.0, -3.8].map(|x| light_at(&picture, x, 0.0).x);
        assert!((inside - outside).abs() < 0.02 && inside > 0.2, "{inside}, {outside}");
    }
}

#[test]
fn a_file_alone_has_a_catcher_in_an_image() {
    let folder = Folder::new();
    let pixels = vec![image::Rgb([0.5f32; 3]); 8];
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&pixels, 4, 2).unwrap();
    folder.write("day.hdr", bytes);
    let path = folder.write("dots.csv", "x,y,z,radius\n0,1,0,0.3\n");
    let catches = |set: &[(&str, &str)]| {
        let set: Vec<_> = set.iter().map(|&(k, v)| (k.to_owned(), v.to_owned())).collect();
        let scene = scene::load_with(&path, &set).unwrap();
        scene.materials.iter().find(|m| m.name == "ground").expect("a ground").catcher
    };
    assert!(catches(&[("environment.file", "\"day.hdr\"")]));
    assert!(!catches(&[]) && !catches(&[("environment.intensity", "2")]));
}

#[test]
fn a_catcher_is_opaque() {
    let text = FLOOR.replace("ZENITH", "[0, 0, 0]").replacen("transfer = 'opaque'\n", "", 1);
    let error = read(&text).unwrap_err().to_string();
    assert!(error.contains("catcher") && error.contains("opaque"), "{error}");
}
