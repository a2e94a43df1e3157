//! Particles of emitters: against closed forms, and independent of the frames before.
use crate::common::files::read;
use gobo::{
    glam::{DVec3, Vec3},
    model::{
        Particle,
        emitter::{EmittedParticle, EmitterShape, Forces, STEP, curl_noise},
    },
};
use gobo_scene::Scene;

pub(super) const HEAD: &str = "[[material]]\nname = 'smoke'\nradius = 0.1\n[[material]]\n\
    name = 'bright'\ntransfer = 'gain'\n";

pub(super) fn emitting(keys: &str) -> Scene {
    let toml = format!("{HEAD}[[emitter]]\nmaterial = 'smoke'\n{keys}\n");
    read(&toml).unwrap_or_else(|error| panic!("{error}"))
}

pub(super) fn at(scene: &mut Scene, seconds: f64) -> Vec<Particle> {
    scene.set_time(seconds);
    scene.particles.clone()
}

pub(super) fn forces() -> Forces {
    Forces {
        seed: 3,
        rate: 100.0,
        lifetime: [1.0; 2],
        shape: EmitterShape::Point,
        position: Vec3::ZERO,
        extent: Vec3::ONE,
        velocity: Vec3::new(1.0, 2.0, 0.0),
        spread: 0.0,
        gravity: 0.0,
        buoyancy: 0.0,
        drag: 0.0,
        wind: Vec3::ZERO,
        turbulence: 0.0,
        frequency: 1.0,
        evolve: 0.0,
        ground: None,
        boxes: Vec::new(),
        bounce: 0.5,
        slide: 1.0,
        path: Vec::new(),
        origin: Vec3::ZERO,
    }
}

fn flown(forces: &Forces, steps: u32) -> EmittedParticle {
    let mut emitted = forces.start(7);
    (0..steps).for_each(|step| forces.advance(&mut emitted, step));
    emitted
}

const WILD: &str = "rate = 300\nlifetime = [0.5, 2]\nshape = 'sphere'\nextent = [1, 0.5, 1]\n\
    spread = 1\nbuoyancy = 3\n\
    gravity = 1\ndrag = 2\nwind = [1, 0, 0.5]\nturbulence = 2\nfrequency = 1.5\nevolve = 0.4\nground = -0.2\n\
    boxes = [{ min = [0.5, -1, -1], max = [1, 1.5, 1] }]\nradius = [0.02, 0.2]\nalpha = [0, 1, 0]\nseed = 5\n\
    color = [[1, 0.5, 0.2], 0.5]\n";

#[test]
fn a_moment_is_the_same_whatever_came_before() {
    let moments = [0.0, 1.0 / 24.0, 0.5, 1.3, 2.0, 3.7];
    let mut in_turn = emitting(WILD);
    let all = moments.map(|seconds| at(&mut in_turn, seconds));
    for (seconds, expected) in moments.into_iter().zip(&all) {
        assert!(&at(&mut emitting(WILD), seconds) == expected, "{seconds} s alone");
        assert!(&at(&mut in_turn, seconds) == expected, "{seconds} s, back from later");
    }
    assert!(all[0].is_empty() && all[5].len() > 250, "{}", all[5].len());
    assert!(at(&mut emitting(&WILD.replace("seed = 5", "seed = 6")), 2.0) != all[4]);
    // An earlier start is the same as a later time.
    let early = at(&mut emitting(&format!("{WILD}start = -2")), 0.0);
    let places = |particles: &[Particle]| particles.iter().map(|p| p.center).collect::<Vec<_>>();
    assert_eq!(places(&early).len(), places(&all[4]).len());
}

#[test]
fn as_many_fly_as_rate_and_lifetime_say() {
    let mut scene = emitting("rate = 250\nlifetime = 2\nstop = 3");
    for (seconds, expected) in [(1.0, 250.0), (2.0, 500.0), (3.0, 500.0), (4.0, 250.0), (6.0, 0.0)]
    {
        let count = at(&mut scene, seconds).len() as f64;
        assert!((count - expected).abs() <= 250.0 / 60.0 + 1.0, "{seconds} s: {count}");
    }
    // Less than one particle per step.
    let mut slow = emitting("rate = 2\nlifetime = 100");
    assert_eq!(at(&mut slow, 10.1).len(), 21);
    let forces = Forces { rate: 2.0, ..forces() };
    for step in 0..1000 {
        let started = forces.started(step);
        assert!(forces.starts_in(started - 1) <= step && forces.starts_in(started) > step);
    }
}

/// The sum of the steps, and close to it the parabola.
#[test]
fn thrown_particles_fall_as_they_should() {
    let forces = Forces { gravity: 9.81, ..forces() };
    for steps in [1, 10, 60] {
        let emitted = flown(&forces, steps);
        let (n, dt) = (f64::from(steps), f64::from(STEP));
        let exact = DVec3::new(n * dt, 2.0 * n * dt - 9.81 * dt * dt * n * (n + 1.0) / 2.0, 0.0);
        assert!((emitted.position.as_dvec3() - exact).length() < 1e-4, "{emitted:?} {exact}");
        let parabola = 2.0 * n * dt - 9.81 * (n * dt).powi(2) / 2.0;
        assert!((exact.y - parabola).abs() <= 9.81 * dt * n * dt / 2.0 + 1e-9);
    }
}

#[test]
fn air_takes_particles_with_it() {
    let wind = Vec3::new(3.0, 0.0, -1.0);
    let long = Forces { wind, drag: 4.0, gravity: 2.0, lifetime: [60.0; 2], ..forces() };
    let emitted = flown(&long, 1000);
    // Terminal velocity.
    assert!(emitted.velocity.distance(wind - Vec3::Y * 0.5) < 1e-4, "{emitted:?}");
    // Buoyancy falls to half in the middle of a life and to zero at its end.
    let rising = Forces { buoyancy: 8.0, drag: 100.0, lifetime: [4.0; 2], ..forces() };
    let lift = flown(&rising, 120).velocity.y * 100.0;
    assert!((lift - 4.0).abs() < 0.1, "{lift}");
    assert_eq!(rising.start(1).life, 240);
}

#[test]
fn nothing_goes_through_ground_or_boxes() {
    let wild = Forces {
        lifetime: [4.0; 2],
        velocity: Vec3::ZERO,
        spread: 6.0,
        gravity: 9.0,
        position: Vec3::Y,
        ground: Some(0.0),
        boxes: vec![[Vec3::new(0.5, -1.0, -2.0), Vec3::new(1.5, 2.0, 2.0)]],
        ..forces()
    };
    let mut struck = 0;
    for number in 0..200 {
        let mut emitted = wild.start(number);
        for step in 0..240 {
            wild.advance(&mut emitted, step);
            let Vec3 { x, y, z } = emitted.position;
            assert!(y >= 0.0, "{emitted:?}");
            assert!(
                !((0.5 + 1e-6..1.5 - 1e-6).contains(&x) && y < 2.0 - 1e-6 && z.abs() < 2.0 - 1e-6)
            );
            struck += u32::from(x == 0.5);
        }
    }
    assert!(struck > 20, "{struck} struck the box");
    // Half the speed upwards, the full speed along the ground.
    let fall = Forces { ground: Some(0.0), ..forces() };
    let mut emitted = EmittedParticle { velocity: Vec3::new(1.0, -3.0, 2.0), ..fall.start(0) };
    fall.advance(&mut emitted, 0);
    assert_eq!((emitted.position.y, emitted.velocity), (0.0, Vec3::new(1.0, 1.5, 2.0)));
}

/// Turbulence is divergence-free, has mean 0, and about the set speed.
#[test]
fn whirls_have_no_sources() {
    let (mut sum, mut square, mut worst, mut count) = (DVec3::ZERO, 0.0, 0.0f32, 0);
    for i in 0..20_000u32 {
        let at = Vec3::new((i * 7 % 1013) as f32, (i * 13 % 1009) as f32, (i * 17 % 997) as f32)
            * 0.0371;
        let velocity = curl_noise(at, 9);
        sum += velocity.as_dvec3();
        square += f64::from(velocity.length_squared());
        let slope = |axis: Vec3| {
            (curl_noise(at + axis * 5e-3, 9) - curl_noise(at - axis * 5e-3, 9)).dot(axis) * 100.0
        };
        let inside = (at - at.floor() - 0.5).abs().max_element() < 0.49;
        if inside {
            worst = worst.max((slope(Vec3::X) + slope(Vec3::Y) + slope(Vec3::Z)).abs());
            count += 1;
        }
    }
    let (mean, speed) = (sum / 20_000.0, (square / 20_000.0f64).sqrt());
    assert!(worst < 0.1 && count > 10_000, "divergence {worst}");
    assert!(mean.length() < 0.05 && (0.5..1.6).contains(&speed), "{mean} {speed}");
    // No jump from cell to cell.
    let step = curl_noise(Vec3::new(3.0 - 1e-4, 0.3, 0.6), 9)
        - curl_noise(Vec3::new(3.0 + 1e-4, 0.3, 0.6), 9);
    assert!(step.length() < 0.01, "{step}");
}

#[test]
fn particles_age_as_their_stops_say() {
    let keys = "rate = 1\nlifetime = 4\nvelocity = [0, 0, 0]\nradius = [1, 3, 2]\nalpha = [0.5, 0.1]\n\
        color = [[1, 0, 0], [0, 0, 1], [0, 1, 1]]\nposition = [1, 2, 3]\n";
    let mut scene = emitting(keys);
    // The first particle starts at once.
    for (seconds, radius, alpha, color) in [
        (0.5, 1.5, 0.45, Vec3::new(0.75, 0.0, 0.25)),
        (1.0, 2.0, 0.4, Vec3::new(0.5, 0.0, 0.5)),
        (3.0, 2.5, 0.2, Vec3::new(0.0, 0.5, 1.0)),
    ] {
        let first = at(&mut scene, seconds)[0];
        assert!((first.radius - radius).abs() < 1e-4, "{seconds}: {first:?}");
        assert!(
            (first.color - color.extend(alpha)).abs().max_element() < 1e-4,
            "{seconds}: {first:?}"
        );
        assert_eq!(first.center, Vec3::new(1.0, 2.0, 3.0));
    }
    // Between two steps particles are interpolated.
    let mut moving = emitting("rate = 1\nlifetime = 4\nvelocity = [6, 0, 0]");
    let x = at(&mut moving, 1.5 / 60.0)[0].center.x;
    assert!((x - 0.15).abs() < 1e-5, "{x}");
}

#[test]
fn particles_start_within_their_shape() {
    let extent = Vec3::new(4.0, 2.0, 1.0);
    for shape in [EmitterShape::Box, EmitterShape::Sphere, EmitterShape::Disc] {
        let forces = Forces { shape, extent, ..forces() };
        let places: Vec<Vec3> =
            (0..4000).map(|n| forces.start(n).position / extent * 2.0).collect();
        let inside = |p: &Vec3| match shape {
            EmitterShape::Box => p.abs().max_element() <= 1.0,
            EmitterShape::Sphere => p.length() <= 1.0 + 1e-6,
            _ => p.length() <= 1.0 + 1e-6 && p.y == 0.0,
        };
        assert!(places.iter().all(inside), "{shape:?}");
        // Uniform: the mean square of a coordinate is a third, a fifth, a quarter.
        let square = places.iter().map(|p| p.x * p.x).sum::<f32>() / 4000.0;
        let even = match shape {
            EmitterShape::Box => 1.0 / 3.0,
            EmitterShape::Sphere => 0.2,
            _ => 0.25,
        };
        assert!((square - even).abs() < 0.02, "{shape:?}: {square}");
        let mean = places.iter().sum::<Vec3>() / 4000.0;
        assert!(mean.length() < 0.05, "{shape:?}: {mean}");
    }
}

/// Each particle starts at the emitter's position at its own time, not at that of its frame or step.
#[test]
fn emitters_leave_particles_along_their_path() {
    let keys = "rate = 1000\nlifetime = 10\nvelocity = [0, 0, 0]\nposition = [0, 1, 0]\nstart = -1\n\
        path = [[-1, 0, 0, 0], [1, 4, 0, 0], [2, 4, 3, 0]]";
    let mut scene = emitting(keys);
    let particles = at(&mut scene, 3.0);
    assert!(particles.len() >= 3999);
    for particle in particles {
        let seconds = particle.id as f32 / 1000.0 - 1.0;
        let x = (2.0 * (seconds + 1.0)).min(4.0);
        let y = 1.0 + (3.0 * (seconds - 1.0)).clamp(0.0, 3.0);
        assert!(particle.center.distance(Vec3::new(x, y, 0.0)) < 1e-3, "{seconds}: {particle:?}");
    }
}

#[test]
fn wrong_emitters_are_named() {
    let first = HEAD.lines().count() + 2;
    for (keys, line, word) in [
        ("lifetime = 1", 0, "rate"),
        ("rate = 0\nlifetime = 1", 1, "rate"),
        ("rate = 1\nlifetime = 0", 2, "lifetime"),
        ("rate = 1\nlifetime = [2, 1]", 2, "lifetime"),
        ("rate = 1\nlifetime = [1, 2, 3]", 2, "lifetime"),
        ("rate = 1e6\nlifetime = 600", 1, "particles"),
        ("rate = 2e4\nlifetime = 600", 2, "steps"),
        ("rate = 1\nlifetime = 1\nradius = []", 3, "radius"),
        ("rate = 1\nlifetime = 1\nradius = [0]", 3, "radius"),
        ("rate = 1\nlifetime = 1\nalpha = [2]", 3, "alpha"),
        ("rate = 1\nlifetime = 1\ncolor = [2]", 3, "color"),
        ("rate = 1\nlifetime = 1\nshape = 'cube'", 3, "cube"),
        ("rate = 1\nlifetime = 1\nwind = [1, 0, 0]", 3, "air"),
        ("rate = 1\nlifetime = 1\nturbulence = 1", 3, "air"),
        ("rate = 1\nlifetime = 1\nstart = 5\nstop = 4", 4, "stop"),
        ("rate = 1\nlifetime = 1\nextent = [1, -1, 1]", 3, "extent"),
        ("rate = 1\nlifetime = 1\nboxes = [{ min = [0, 0, 0], max = [1, 0, 1] }]", 3, "min"),
        ("rate = 1\nlifetime = 1\npath = [[0, 1, 2]]", 3, "row"),
        ("rate = 1\nlifetime = 1\npath = [[1, 0, 0, 0], [0, 0, 0, 0]]", 3, "ascend"),
        ("rate = 1\nlifetime = 1\nspeed = 3", 3, "speed"),
    ] {
        let error = read(&format!("{HEAD}[[emitter]]\nmaterial = 'smoke'\n{keys}\n")).unwrap_err();
        let text = error.to_string();
        assert!(line == 0 || text.contains(&format!(":{}:", first + line)), "{keys}: {text}");
        assert!(text.contains(word), "{keys}: {text}");
        assert!(!error.help().unwrap_or_default().is_empty(), "{keys}: {text}");
    }
    assert!(read("[[emitter]]\nmaterial = 'x'\nrate = 1\nlifetime = 1\n").is_err());
}

/// Far from the origin the same smoke rises.
#[test]
fn far_emitters_send_the_same() {
    let of = |x: f32| {
        let mut scene = emitting(
            &format!("{WILD}position = [{x}, 0, 0]\n")
                .replace("boxes = [{ min = [0.5, -1, -1], max = [1, 1.5, 1] }]\n", "")
                .replace("turbulence = 2\n", ""),
        );
        at(&mut scene, 1.5)
            .into_iter()
            .map(|p| (p.center + scene.origin - Vec3::X * x).y)
            .collect::<Vec<_>>()
    };
    let (near, far) = (of(0.0), of(65536.0));
    assert_eq!(near.len(), far.len());
    assert!(near.iter().zip(&far).all(|(a, b)| (a - b).abs() < 1e-3));
}
