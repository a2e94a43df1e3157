//! Trails of emitters: former positions of the particles, at any time and after any history.
use super::emitters::{HEAD, at, emitting};
use crate::common::files::read;
use gobo::{
    glam::Vec3,
    model::{Shape, Strand},
};
use gobo_scene::Scene;
use std::collections::HashMap;

const WILD: &str = "rate = 40\nlifetime = [0.5, 2]\nextent = [1, 0.5, 1]\nspread = 1\nbuoyancy = 3\n\
    drag = 2\n\
    turbulence = 2\nground = -0.2\nradius = [0.02, 0.2]\ncolor = [[1, 0.5, 0.2], 0.5]\n\
    alpha = [1, 0.3]\nseed = 5\n";

fn trailing(trail: &str) -> Scene {
    emitting(&format!("{WILD}trail = {trail}"))
}

fn trails(scene: &mut Scene, seconds: f64) -> Vec<Strand> {
    scene.set_time(seconds);
    scene.strands.clone()
}

/// Particles in even flight have straight conical trails, which begin at their start if that was recent.
#[test]
fn trails_of_even_flight_are_straight() {
    let keys =
        "rate = 10\nlifetime = 3\nextent = [0, 0, 0]\nvelocity = [2, 1, 0]\nradius = [0.1]\n";
    let mut scene = emitting(&format!("{keys}trail = {{ seconds = 0.5, segments = 4 }}"));
    let particles = at(&mut scene, 1.23);
    assert_eq!(particles.len(), scene.strands.len());
    let (mut young, mut old) = (0, 0);
    for (particle, strand) in particles.iter().zip(&scene.strands) {
        assert_eq!(particle.id, strand.id);
        let age = f64::from(particle.center.y);
        // A particle exists from the end of its first step on.
        let count = |age: f64| if age < 0.5 { (age / 0.125) as usize + 2 } else { 5 };
        let count = count(age - 1.0 / 60.0)..=count(age);
        assert!(count.contains(&strand.vertices.len()), "{age} s: {strand:?}");
        for (i, vertex) in strand.vertices.iter().enumerate() {
            let is_start = age < 0.5 && i + 1 == strand.vertices.len();
            let ago = if is_start { age } else { 0.125 * i as f64 } as f32;
            let place = particle.center - Vec3::new(2.0, 1.0, 0.0) * ago;
            assert!(vertex.position.distance(place) < 1e-5, "{vertex:?}, not {place}");
            assert!((vertex.radius - 0.1 * (1.0 - ago / 0.5)).abs() < 1e-6, "{vertex:?}");
            assert_eq!(vertex.color, particle.color);
        }
        *(if age < 0.5 { &mut young } else { &mut old }) += 1;
    }
    assert_eq!((young, old), (5, 8));
    let material = |i: u32| &scene.materials[i as usize];
    assert_eq!(material(scene.strands[0].material).shape, Shape::Capsule);
    assert_eq!(material(particles[0].material).shape, Shape::Disc);
}

/// Whirls, a ground and looks over a life: a vertex equals the particle at that time.
#[test]
fn trails_go_through_where_particles_were() {
    let now = 2.7;
    let dragged = trails(&mut trailing("{ seconds = 0.25, segments = 4 }"), now);
    let mut met = 0;
    for i in 0..=4_u8 {
        let then = at(&mut emitting(WILD), now - 0.25 * f64::from(i) / 4.0);
        let then: HashMap<u32, _> = then.iter().map(|p| (p.id, p)).collect();
        for strand in &dragged {
            // Younger particles' trails end at their start.
            let Some(particle) = then.get(&strand.id) else { continue };
            let vertex = strand.vertices[usize::from(i)];
            assert!(vertex.position.distance(particle.center) < 1e-6, "{vertex:?} {particle:?}");
            let radius = particle.radius * (1.0 - f32::from(i) / 4.0);
            assert!((vertex.radius - radius).abs() < 1e-6);
            assert!(vertex.color.distance(particle.color) < 1e-6);
            met += 1;
        }
    }
    assert!(met > 5 * 30, "{met}");
}

#[test]
fn a_moment_of_trails_is_the_same_whatever_came_before() {
    let trail = "{ seconds = 0.4 }";
    let moments = [0.0, 0.5, 0.52, 1.3, 2.0, 3.7];
    let mut in_turn = trailing(trail);
    let all = moments.map(|seconds| trails(&mut in_turn, seconds));
    assert!(all[0].is_empty() && all[5].len() > 30, "{}", all[5].len());
    for (seconds, expected) in moments.into_iter().zip(&all) {
        assert!(&trails(&mut trailing(trail), seconds) == expected, "{seconds} s alone");
        assert!(&trails(&mut in_turn, seconds) == expected, "{seconds} s, back from later");
    }
    // The file's own strands stay, and particles equal those of an emitter without trails.
    let own = "[[shape]]\nname = 'ball'\nkind = 'sphere'\nmaterial = 'smoke'\n[[strands]]\n\
        material = 'smoke'\n\
        generate = { kind = 'fur', on = 'ball', count = 5 }\n";
    let mut beside = emitting(&format!("{WILD}trail = {trail}\n{own}"));
    let both = trails(&mut beside, 2.0);
    assert_eq!(both.len(), 5 + all[4].len());
    assert!(trails(&mut beside, 0.0) == both[..5]);
    let places = |scene: &mut Scene| at(scene, 2.0).iter().map(|p| p.center).collect::<Vec<_>>();
    assert_eq!(places(&mut emitting(WILD)), places(&mut in_turn));
}

/// Far from the origin the same trails fly.
#[test]
fn far_trails_are_the_same() {
    let of = |x: f32| {
        let mut scene = emitting(&format!(
            "start = -1\nrate = 20\nlifetime = 2\nspread = 1\nposition = [{x}, 1, 0]\n\
             trail = {{ seconds = 0.5 }}"
        ));
        scene.set_time(0.5);
        let from_emitter = scene.origin - Vec3::X * x;
        let vertices = scene.strands.iter().flat_map(|strand| &strand.vertices);
        vertices.map(|vertex| vertex.position + from_emitter).collect::<Vec<_>>()
    };
    let [near, far] = [0.0, 65536.0].map(of);
    assert!(near.len() > 150 && near.len() == far.len());
    let apart = near.iter().zip(&far).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(apart < 1e-3, "{apart}");
}

#[test]
fn trails_stay_on_the_cpu_and_may_have_a_material_of_their_own() {
    let own = "[[material]]\nname = 'streak'\ntint = [1, 0, 0, 0.5]\n";
    let keys = "rate = 9\nlifetime = 1\ntrail = { seconds = 0.2, material = 'streak' }\n";
    let toml = format!("{HEAD}{own}[[emitter]]\nmaterial = 'smoke'\n{keys}");
    let mut scene = read(&toml).unwrap_or_else(|error| panic!("{error}"));
    let reasons = scene.simulate_on_device(1 << 20);
    assert!(reasons.len() == 1 && reasons[0].contains("trails"), "{reasons:?}");
    let strands = trails(&mut scene, 0.9);
    let material = &scene.materials[strands[0].material as usize];
    assert_eq!((material.shape, material.tint.y), (Shape::Capsule, 0.0));
    assert!(scene.particles.len() >= 8 && scene.emissions.is_empty());
}

#[test]
fn wrong_trails_are_named() {
    let shiny = "[[material]]\nname = 'shiny'\nreflectivity = 0.5\n";
    let head = format!("{HEAD}{shiny}[[emitter]]\n");
    let first = head.lines().count();
    for (material, rest, word) in [
        ("smoke", "trail = {}", "seconds"),
        ("smoke", "trail = 1", "table"),
        ("smoke", "trail = { seconds = 0 }", "0.02 to 60"),
        ("smoke", "trail = { seconds = nan }", "0.02 to 60"),
        ("smoke", "trail = { seconds = -1 }", "0.02 to 60"),
        ("smoke", "trail = { seconds = 1e9 }", "0.02 to 60"),
        ("smoke", "trail = { seconds = 1, segments = 0 }", "1 to 64"),
        ("smoke", "trail = { seconds = 1, segments = 65 }", "1 to 64"),
        ("smoke", "trail = { seconds = 1, segments = 1.5 }", "whole number"),
        ("smoke", "trail = { seconds = 1, material = 'smok' }", "smok"),
        ("smoke", "trail = { seconds = 1, width = 2 }", "width"),
        ("shiny", "trail = { seconds = 1 }", "reflectivity"),
        ("smoke", "trail = { seconds = 1, segments = 64 }\nrate = 1e5", "vertices of strands"),
        ("bright", "color = [2]\ntrail = { seconds = 1, material = 'smoke' }", "color"),
    ] {
        let rate = if rest.contains("rate") { "" } else { "rate = 9\n" };
        let text = format!("{head}material = '{material}'\n{rest}\n{rate}lifetime = 3\n");
        let error = read(&text).expect_err(rest);
        let (text, help) = (error.to_string(), error.help().unwrap_or_default());
        assert!(format!("{text}; {help}").contains(word), "{rest}: {text}; {help}");
        let is_there = (first..first + 4).any(|line| text.contains(&format!(":{line}:")));
        assert!(!help.is_empty() && is_there, "{rest}: {text}; {help}");
    }
    let bright =
        "material = 'bright'\nrate = 9\nlifetime = 3\ncolor = [2]\ntrail = { seconds = 1 }\n";
    assert!(read(&format!("{head}{bright}")).is_ok());
}
