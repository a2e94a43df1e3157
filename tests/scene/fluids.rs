//! Fluids of particles: against Müller, Charypar and Gross 2003 in 64 bits, and independent of the frames
//! before.
use super::emitters::{HEAD, at, emitting, forces};
use crate::common::files::read;
use gobo::{
    glam::{DVec3, Vec3},
    model::{
        emitter::{EmittedParticle, EmitterShape, Flock, Forces, STEP},
        fluid::Fluid,
    },
};
use std::f64::consts::PI;

const FLUID: Fluid = Fluid { spacing: 0.1, reach: 0.2, stiffness: 4.0, viscosity: 0.01 };

/// Positions of a lattice of `n`^3 points, `spacing` apart.
fn lattice(n: i32, spacing: f32) -> Vec<Vec3> {
    let middle = (n - 1) as f32 / 2.0;
    let places =
        (0..n * n * n).map(|i| Vec3::new((i % n) as f32, (i / n % n) as f32, (i / n / n) as f32));
    places.map(|place| (place - middle) * spacing).collect()
}

fn drop_of(count: u32, extent: f32) -> Vec<EmittedParticle> {
    let forces = Forces {
        shape: EmitterShape::Sphere,
        extent: Vec3::splat(extent),
        spread: 0.5,
        ..forces()
    };
    let start = |number| EmittedParticle { life: 60_000, ..forces.start(number) };
    (0..count).map(start).collect()
}

/// In a lattice whose reach is two spacings, a middle particle has itself, 6 neighbours at 1 spacing, 12 at
/// the root of 2 and 8 at the root of 3; those at 2 have no weight. Each adds `s^3 315 / (64 pi h^9) (h^2 -
/// r^2)^3`.
#[test]
fn a_lattice_has_the_density_of_its_kernel() {
    let exact = 315.0 / (64.0 * PI * 512.0) * (64.0 + 6.0 * 27.0 + 12.0 * 8.0 + 8.0);
    for spacing in [0.01f32, 0.1, 7.0] {
        let fluid = Fluid { spacing, reach: 2.0 * spacing, ..FLUID };
        let densities = fluid.densities(&lattice(5, spacing));
        let middle = f64::from(densities[62]);
        assert!((middle - exact).abs() < 1e-4, "{middle} {exact}");
        // A corner has an eighth of the volume around it.
        assert!(densities[0] < 0.6 * densities[62], "{}", densities[0]);
    }
    // A single particle: its own share, an eighth of the kernel's centre.
    let alone = f64::from(FLUID.densities(&[Vec3::ONE])[0]);
    assert!((alone - 315.0 / (64.0 * PI * 8.0)).abs() < 1e-5, "{alone}");
}

/// Equations 3, 10, 12 and 14 and the kernels 20 to 22, particle by particle.
fn brute_force(fluid: &Fluid, emitted: &[EmittedParticle]) -> Vec<DVec3> {
    let [s, h, k, nu] =
        [fluid.spacing, fluid.reach, fluid.stiffness, fluid.viscosity].map(f64::from);
    let mass = s.powi(3);
    let place: Vec<DVec3> = emitted.iter().map(|f| f.position.as_dvec3()).collect();
    let velocity: Vec<DVec3> = emitted.iter().map(|f| f.velocity.as_dvec3()).collect();
    let all = 0..emitted.len();
    let density: Vec<f64> = all
        .clone()
        .map(|i| {
            let weight = |j: usize| {
                let r = place[i].distance(place[j]);
                if r < h { 315.0 / (64.0 * PI * h.powi(9)) * (h * h - r * r).powi(3) } else { 0.0 }
            };
            all.clone().map(|j| mass * weight(j)).sum()
        })
        .collect();
    let pressure = |i: usize| (k * (density[i] - 1.0)).max(0.0);
    all.clone()
        .map(|i| {
            let mut force = DVec3::ZERO;
            for j in all.clone().filter(|&j| j != i) {
                let (way, r) = (place[i] - place[j], place[i].distance(place[j]));
                if r >= h {
                    continue;
                }
                let gradient = -45.0 / (PI * h.powi(6)) * (h - r).powi(2) * way / r;
                let laplacian = 45.0 / (PI * h.powi(6)) * (h - r);
                force -= mass * (pressure(i) + pressure(j)) / (2.0 * density[j]) * gradient;
                force += nu * mass * (velocity[j] - velocity[i]) / density[j] * laplacian;
            }
            force / density[i]
        })
        .collect()
}

#[test]
fn pushes_are_those_of_the_equations() {
    let emitted = drop_of(300, 0.7);
    let fluid = Fluid { reach: 0.23, ..FLUID };
    let exact = brute_force(&fluid, &emitted);
    let most = exact.iter().map(|push| push.length()).fold(0.0, f64::max);
    let worst = |fluid: &Fluid| {
        let pushes = fluid.accelerations(&emitted);
        let apart = pushes.iter().zip(&exact).map(|(a, b)| a.as_dvec3().distance(*b));
        apart.fold(0.0, f64::max) / most
    };
    assert!(most > 1.0, "{most}");
    assert!(worst(&fluid) < 1e-5, "{}", worst(&fluid));
    for wrong in [
        Fluid { viscosity: 0.0, ..fluid },
        Fluid { stiffness: 3.9, ..fluid },
        Fluid { reach: 0.24, ..fluid },
    ] {
        assert!(worst(&wrong) > 1e-3, "{wrong:?}: {}", worst(&wrong));
    }
}

/// No walls and no gravity: forces between two particles are equal and opposite.
#[test]
fn momentum_stays() {
    for fluid in [FLUID, Fluid { stiffness: (24.0 * 0.2f32).powi(2), viscosity: 0.08, ..FLUID }] {
        let mut emitted = drop_of(400, 0.6);
        let sum = |emitted: &[EmittedParticle]| {
            emitted.iter().map(|f| f.velocity.as_dvec3()).sum::<DVec3>()
        };
        let energy = |emitted: &[EmittedParticle]| {
            emitted.iter().map(|f| f.velocity.length_squared()).sum::<f32>()
        };
        let wide = |emitted: &[EmittedParticle]| {
            let middle = emitted.iter().map(|f| f.position).sum::<Vec3>() / emitted.len() as f32;
            emitted.iter().map(|f| f.position.distance(middle)).sum::<f32>() / emitted.len() as f32
        };
        let (momentum, width, free) =
            (sum(&emitted), wide(&emitted), Forces { gravity: 0.0, ..forces() });
        for step in 0..180 {
            let pushes = fluid.accelerations(&emitted);
            for (emitted, push) in emitted.iter_mut().zip(pushes) {
                emitted.velocity += push * STEP;
                free.advance(emitted, step);
            }
        }
        let lost = (sum(&emitted) - momentum).length() / 400.0;
        assert!(lost < 1e-5, "{lost} m/s of each");
        // The drop was too dense: it spreads without bursting.
        assert!(wide(&emitted) > 1.1 * width, "{} of {width}", wide(&emitted));
        let speed = (energy(&emitted) / 400.0).sqrt();
        assert!(speed < 3.0 + fluid.stiffness.sqrt(), "{speed} m/s");
    }
}

const SMOKE: &str = "rate = 60\nlifetime = 2.5\nshape = 'disc'\nextent = [0.4, 0, 0.4]\nbuoyancy = 2\n\
    drag = 1\n\
    turbulence = 0.5\nboxes = [{ min = [-1, 0.8, -1], max = [1, 1, 1] }]\nfluid = { spacing = 0.15 }\n\
    seed = 4\n";

#[test]
fn a_moment_of_a_fluid_is_the_same_whatever_came_before() {
    let moments = [0.0, 1.0 / 24.0, 1.3, 2.0, 3.1];
    let mut in_turn = emitting(SMOKE);
    let all = moments.map(|seconds| at(&mut in_turn, seconds));
    for (seconds, expected) in moments.into_iter().zip(&all) {
        assert!(&at(&mut emitting(SMOKE), seconds) == expected, "{seconds} s alone");
        assert!(&at(&mut in_turn, seconds) == expected, "{seconds} s, back from later");
    }
    // 150 at a time, nearly all elsewhere than without the fluid.
    assert!((149..=151).contains(&all[4].len()), "{}", all[4].len());
    let single = at(&mut emitting(&SMOKE.replace("fluid = { spacing = 0.15 }\n", "")), 3.1);
    assert_eq!(single.len(), all[4].len());
    assert!(single.iter().zip(&all[4]).filter(|(a, b)| a.center != b.center).count() > 140);
}

/// Without forces, the steps and the started particles equal those without a fluid.
#[test]
fn a_fluid_that_does_nothing_is_none() {
    let still = Fluid { stiffness: 0.0, viscosity: 0.0, ..FLUID };
    let forces = Forces { gravity: 3.0, spread: 1.0, lifetime: [0.5, 1.5], ..forces() };
    let (mut fluid, mut plain) = (Flock::default(), Flock::default());
    for (step, last) in [(0, 50), (1, 50), (40, 50), (100, 50)] {
        fluid.advance_fluid_to(&forces, &still, step, last);
        plain.advance_to(&forces, step, last);
        assert_eq!(fluid.emitted(), plain.emitted(), "{step}");
    }
    assert!(plain.emitted().len() > 10);
}

#[test]
fn wrong_fluids_are_named() {
    let first = HEAD.lines().count() + 2;
    for (keys, line, word) in [
        ("rate = 1\nlifetime = 1\nfluid = {}", 3, "spacing"),
        ("rate = 1\nlifetime = 1\nfluid = { spacing = 0 }", 3, "spacing"),
        ("rate = 1\nlifetime = 1\nfluid = { spacing = 1, reach = 5 }", 3, "reach"),
        ("rate = 1\nlifetime = 1\nfluid = { spacing = 1, stiffness = 1e5 }", 3, "stiffness"),
        ("rate = 1\nlifetime = 1\nfluid = { spacing = 1, viscosity = 9 }", 3, "viscosity"),
        ("rate = 1\nlifetime = 1\nfluid = { spacing = 1, viscous = 9 }", 3, "viscous"),
        ("rate = 6000\nlifetime = 2\nfluid = { spacing = 1 }", 1, "press"),
    ] {
        let error = read(&format!("{HEAD}[[emitter]]\nmaterial = 'smoke'\n{keys}\n")).unwrap_err();
        let text = error.to_string();
        assert!(text.contains(&format!(":{}:", first + line)), "{keys}: {text}");
        assert!(text.contains(word), "{keys}: {text}");
        assert!(!error.help().unwrap_or_default().is_empty(), "{keys}: {text}");
    }
}
