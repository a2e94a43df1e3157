//! One bounce off lit surfaces, against Lambert's form factor of a polygon.
use crate::common::{Tier, files::read, reference_picture, render, tiers};
use gobo::{
    glam::{DVec3, Vec3},
    records::Picture,
};
use gobo_scene::Scene;
use std::f64::consts::PI;

const ALBEDO: f64 = 0.8;
const LIGHT: f64 = 2.0;
/// A surface scatters what its gloss does not mirror head-on.
const SCATTERED: f64 = 0.96;

/// A lit floor from the wall at x = 0 to x = 2, and the dark wall, seen by the camera. `light`: its keys.
fn beside_a_wall(light: &str) -> Scene {
    let toml = format!(
        "[camera]\neye = [6, 1, 0]\ntarget = [0, 1, 0]\nfov_y = 20\nsize = [64, 64]\n\
         [environment]\nambient = [0, 0, 0]\nbackground = [0, 0, 0]\n\
         [shadow]\nsize = 256\n[[light]]\ncolor = [1, 0.5, 0.25]\n{light}\n\
         [[material]]\nname = 'floor'\ntransfer = 'opaque'\ntint = [{ALBEDO}, {ALBEDO}, 0, 1]\n\
         [[material]]\nname = 'wall'\ntransfer = 'opaque'\n\
         [[shape]]\nkind = 'plane'\nmaterial = 'floor'\ntranslation = [1, 0, 0]\nscale = [2, 1, 2]\n\
         [[shape]]\nkind = 'plane'\nmaterial = 'wall'\ntranslation = [0, 1, 0]\nrotation = [0, 0, -90]\n\
         scale = [2, 1, 2]\n"
    );
    read(&toml).unwrap_or_else(|error| panic!("{error}"))
}

const SUN: &str = "kind = 'directional'\ndirection = [0, -1, 0]\nintensity = 2\n";

/// Share of the light of a polygon, which sends evenly, that arrives at a point (Lambert 1760).
fn form_factor(point: DVec3, normal: DVec3, polygon: &[DVec3]) -> f64 {
    let edges = (0..polygon.len()).map(|i| {
        let one = (polygon[i] - point).normalize();
        let next = (polygon[(i + 1) % polygon.len()] - point).normalize();
        one.cross(next).normalize().dot(normal) * one.dot(next).acos()
    });
    (edges.sum::<f64>() / (2.0 * PI)).abs()
}

fn floor() -> [DVec3; 4] {
    [(0.0, -1.0), (2.0, -1.0), (2.0, 1.0), (0.0, 1.0)].map(|(x, z)| DVec3::new(x, 0.0, z))
}

/// Radiance of the wall at a height, at z = 0.
fn on_wall(picture: &Picture, scene: &Scene, height: f64) -> Vec3 {
    let size = picture.size.as_dvec2();
    let slope = (f64::from(scene.camera.fov_y) * 0.5).tan();
    let row = size.y * 0.5 * (1.0 - (height - 1.0) / (6.0 * slope));
    let at = row as usize * picture.size.x as usize + picture.size.x as usize / 2;
    Vec3::from_array(picture.light[at])
}

/// Height of the middle of the pixel that shows a height.
fn seen_height(picture: &Picture, scene: &Scene, height: f64) -> f64 {
    let size = picture.size.as_dvec2();
    let slope = (f64::from(scene.camera.fov_y) * 0.5).tan();
    let row = (size.y * 0.5 * (1.0 - (height - 1.0) / (6.0 * slope))).floor() + 0.5;
    1.0 + 6.0 * slope * (1.0 - row / (size.y * 0.5))
}

fn pictures(scene: &Scene) -> Vec<Picture> {
    let on_devices = tiers(Tier::Native).into_iter().map(|tier| render(tier, scene).picture);
    on_devices.chain([reference_picture(scene)]).collect()
}

#[test]
fn a_wall_is_lit_by_the_floor_beside_it() {
    let scene = beside_a_wall(&format!("{SUN}bounce = 32"));
    let pictures = pictures(&scene);
    for picture in &pictures {
        for height in [0.25, 0.5, 1.0, 1.7] {
            let at = DVec3::new(0.0, seen_height(picture, &scene, height), 0.0);
            let part = form_factor(at, DVec3::X, &floor());
            let wanted = LIGHT * ALBEDO * part / PI * SCATTERED;
            let found = on_wall(picture, &scene, height);
            // At a height of four discs of points 3 %, beyond it 2 %.
            let most = if height < 0.4 { 0.03 } else { 0.02 };
            let apart = (f64::from(found.x) / wanted - 1.0).abs();
            assert!(apart < most, "{height} m: {found}, not {wanted}");
            // Green light is half of it, and the floor scatters no blue.
            assert!((found.y / found.x - 0.5).abs() < 1e-3 && found.z < 1e-6, "{found}");
        }
    }
    for pair in pictures.windows(2) {
        let apart = pair[0]
            .light
            .iter()
            .zip(&pair[1].light)
            .map(|(a, b)| (Vec3::from_array(*a) - Vec3::from_array(*b)).abs().max_element());
        assert!(apart.fold(0.0, f32::max) < 2e-3);
    }
}

/// A lamp above the floor: the light that each part of it gets falls with the square of its distance and with
/// the cosine.
#[test]
fn a_point_light_bounces_off_all_sides() {
    let keys = "kind = 'point'\nposition = [1, 1.5, 0]\nintensity = 2\nsize = 128\nbounce = 13";
    let scene = beside_a_wall(keys);
    let plain = beside_a_wall(&keys.replace("bounce = 13", "bounce = 0"));
    let (with, without) = (pictures(&scene), pictures(&plain));
    for (with, without) in with.iter().zip(&without) {
        for height in [0.5, 1.0, 1.6] {
            let at = DVec3::new(0.0, seen_height(with, &scene, height), 0.0);
            // Sum over small squares of the floor.
            const STEPS: usize = 200;
            let step = 2.0 / STEPS as f64;
            let mut wanted = 0.0;
            for i in 0..STEPS * STEPS {
                let x = (i % STEPS) as f64 * step + 0.5 * step;
                let z = (i / STEPS) as f64 * step + 0.5 * step - 1.0;
                let place = DVec3::new(x, 0.0, z);
                let from_lamp = place - DVec3::new(1.0, 1.5, 0.0);
                let square = from_lamp.length_squared();
                let arrives = LIGHT / square * (1.5 / square.sqrt());
                let way = place - at;
                let cosines = way.x * -way.y / way.length_squared();
                wanted += arrives * ALBEDO / PI * cosines.abs() / way.length_squared();
            }
            wanted *= step * step / PI * SCATTERED;
            let found = on_wall(with, &scene, height) - on_wall(without, &scene, height);
            let apart = (f64::from(found.x) / wanted - 1.0).abs();
            // Points of which a part is on the wall and another on the floor send light from one of them.
            assert!(apart < 0.12, "{height} m: {found}, not {wanted}");
        }
    }
}

/// Light through red glass is red when the floor sends it on.
#[test]
fn filtered_light_bounces_in_its_colour() {
    let glass = "[[material]]\nname = 'red'\ntint = [1, 0.25, 0, 1]\n[[shape]]\nkind = 'plane'\n\
         material = 'red'\ntranslation = [1.05, 3, 0]\nscale = [2, 1, 4]\n";
    let scene = beside_a_wall(&format!("{SUN}bounce = 16\n{glass}"));
    let clear = beside_a_wall(&format!("{SUN}bounce = 16"));
    let (red, clear) = (pictures(&scene), pictures(&clear));
    for (red, clear) in red.iter().zip(&clear) {
        let (red, clear) = (on_wall(red, &scene, 1.0), on_wall(clear, &scene, 1.0));
        let ratio = red / clear;
        assert!((ratio.y / ratio.x - 0.25).abs() < 0.03 && ratio.x > 0.9, "{red} of {clear}");
    }
}

#[test]
fn bounces_without_maps_or_without_room_are_refused() {
    let error = |text: &str| read(text).unwrap_err().to_string();
    let sun = "[[light]]\nkind = 'directional'\ndirection = [0, -1, 0]\n";
    let lamp = "[[light]]\nkind = 'point'\nposition = [0, 1, 0]\n";
    assert!(error(&format!("{sun}bounce = 33\n")).contains("bounce is 33"));
    assert!(error(&format!("{lamp}bounce = 14\n")).contains("13"));
    assert!(error(&format!("{sun}casts = false\nbounce = 4\n")).contains("casts no shadow"));
    let two = format!("{sun}bounce = 32\n{lamp}name = 'lamp'\nbounce = 1\n");
    assert!(error(&two).contains("1030 points that send light on"), "{}", error(&two));
}

fn bits(pictures: &[Picture]) -> Vec<Vec<[u32; 3]>> {
    let of =
        |picture: &Picture| picture.light.iter().map(|light| light.map(f32::to_bits)).collect();
    pictures.iter().map(of).collect()
}

#[test]
fn a_bounce_is_the_same_each_time_and_none_changes_no_bit() {
    let lamp = "kind = 'point'\nposition = [1, 1.5, 0]\nintensity = 2\nsize = 64\n";
    for light in [SUN, lamp] {
        let of = |keys: &str| bits(&pictures(&beside_a_wall(&format!("{light}{keys}"))));
        let with = of("bounce = 8");
        assert!(with == of("bounce = 8"), "not the same bits twice: {light}");
        let without = of("");
        assert!(without == of("bounce = 0"), "bounce = 0 changes bits: {light}");
        assert!(
            with.iter().zip(&without).all(|(with, without)| with != without),
            "no bounce: {light}"
        );
    }
}
