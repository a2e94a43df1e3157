//! Estimated time of the CPU reference against its actual time.
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene as scene;
use gobo_scene::Scene;
use std::time::Instant;

/// Largest error of an estimate, as a factor: it counts casters and texels, and not the cost of their hits.
const FACTOR: f64 = 3.0;

/// Other tests use the cores now and then, while the speed is measured or while the picture is made.
const TRIES: usize = 8;

fn load(name: &str, set: &[(&str, &str)]) -> Scene {
    let path = crate::common::root().join("data").join(name);
    let set: Vec<_> = set.iter().map(|&(k, v)| (k.to_owned(), v.to_owned())).collect();
    scene::load_with(&path, &set).unwrap()
}

fn assert_estimated(name: &str, set: &[(&str, &str)]) {
    let scene = load(name, set);
    let mut renderer = Renderer::on_cpu();
    let mut ratio = || {
        let estimate = renderer.estimate(&scene).unwrap();
        let started = Instant::now();
        renderer.render(&scene, &RenderOptions::default()).unwrap();
        estimate / started.elapsed().as_secs_f64()
    };
    let mut ratios = vec![ratio()];
    while !(1.0 / FACTOR..FACTOR).contains(&ratios[ratios.len() - 1]) {
        assert!(ratios.len() < TRIES, "{name}: {ratios:?}");
        ratios.push(ratio());
    }
}

const TINY: (&str, &str) = ("camera.size", "[48, 27]");

#[test]
fn particles_in_curves_take_what_is_said() {
    assert_estimated("smoke.toml", &[TINY, ("shadow.size", "256"), ("camera.samples", "1")]);
}

#[test]
fn panes_under_a_lamp_with_a_size_take_what_is_said() {
    assert_estimated("soft_glass.toml", &[TINY, ("shadow.size", "64"), ("camera.samples", "1")]);
}

#[test]
fn lit_voxels_take_what_is_said() {
    assert_estimated("plume.toml", &[TINY, ("shadow.size", "64"), ("camera.samples", "1")]);
}
