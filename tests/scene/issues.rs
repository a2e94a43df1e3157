//! Requests of other projects' users as scenes of data/issues: each against a closed form, and each check
//! against a wrong scene. docs/compare.md lists them all.
use gobo::{glam::Vec3, model::ReceiverPoint};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene as scene;
use gobo_scene::Scene;
use std::{collections::BTreeSet, fs, path::PathBuf};

/// Light at points of the ground and above it, by the CPU reference; other tests compare kernels with it.
struct Look(Scene);

impl Look {
    fn at_all(&self, points: &[Vec3]) -> Vec<[f32; 3]> {
        // Normal of the ground, or none in the air.
        let normal = |p: Vec3| if p.y == 0.0 { Vec3::Y } else { Vec3::ZERO };
        let points: Vec<_> = points
            .iter()
            .map(|&position| ReceiverPoint { position, normal: normal(position) })
            .collect();
        Renderer::on_cpu().light_points(&self.0, &points).unwrap()
    }

    fn at(&self, x: f32, y: f32, z: f32) -> Vec3 {
        self.at_all(&[Vec3::new(x, y, z)])[0].into()
    }

    /// Light that reaches the eye half-way up the picture, at a share of its width.
    fn pixel(&self, across: f32) -> Vec3 {
        let picture =
            Renderer::on_cpu().render(&self.0, &RenderOptions::default()).unwrap().picture;
        let (x, y) = ((across * picture.size.x as f32) as u32, picture.size.y / 2);
        picture.light[(y * picture.size.x + x) as usize].into()
    }

    /// Mean over a square of the ground around x = `x`, and the deviation of its points.
    fn over(&self, x: f32, half: f32) -> (f32, f32) {
        const SIDE: usize = 40;
        let place = |i: usize| half * (2.0 * (i as f32 + 0.5) / SIDE as f32 - 1.0);
        let points: Vec<Vec3> = (0..SIDE * SIDE)
            .map(|i| Vec3::new(x + place(i % SIDE), 0.0, place(i / SIDE)))
            .collect();
        let lights: Vec<f32> = self.at_all(&points).iter().map(|light| light[0]).collect();
        let mean = lights.iter().sum::<f32>() / lights.len() as f32;
        let variance = lights.iter().map(|light| (light - mean).powi(2)).sum::<f32>();
        (mean, (variance / lights.len() as f32).sqrt())
    }
}

/// Rounding of the maps' formats.
const ROUNDED: f32 = 2e-3;

fn near(light: Vec3, expected: Vec3, tolerance: f32) -> bool {
    (light - expected).abs().max_element() <= tolerance
}

/// An issue's scene, its condition, and a change that violates it.
struct Issue {
    name: &'static str,
    holds: fn(&Look) -> bool,
    wrong: (&'static str, &'static str),
}

const ISSUES: [Issue; 13] = [
    Issue {
        name: "bevy-15403",
        holds: |look| {
            near(look.at(0.0, 0.0, 0.0), Vec3::new(0.9, 0.1, 0.05), ROUNDED)
                && near(look.at(2.0, 0.0, 0.0), Vec3::ONE, 1e-6)
        },
        wrong: ("material.red glass.transfer", "opaque"),
    },
    Issue {
        name: "bevy-10634",
        holds: |look| {
            let places =
                [(-2.5, 0.99), (-1.5, 0.96), (-0.5, 0.94), (0.5, 0.5), (1.5, 0.0), (2.5, 1.0)];
            places
                .iter()
                .all(|&(x, passed)| near(look.at(x, 0.0, 0.0), Vec3::splat(passed), ROUNDED))
        },
        wrong: ("material.p4.casts", "false"),
    },
    Issue {
        name: "strolle-28",
        holds: |look| {
            // The ball is made of triangles, slightly inside of it.
            [0.0_f32, 0.2, 0.4].iter().all(|&x| {
                let way = 2.0 * (0.25 - x * x).sqrt();
                near(look.at(x, 0.0, 0.0), Vec3::new(0.8, 0.2, 0.2).powf(way), 0.01)
            })
        },
        wrong: ("material.ball.attenuation_distance", "2"),
    },
    Issue {
        name: "three-10600",
        holds: |look| {
            let shade = |x, y, passed| near(look.at(x, y, 0.0), Vec3::splat(passed), ROUNDED);
            shade(-1.2, 0.0, 0.75)
                && shade(-0.3, 0.0, 0.5)
                && shade(1.2, 0.0, 0.25)
                && shade(0.0, 0.8, 0.5)
                && shade(0.0, 0.0, 0.0)
        },
        wrong: ("material.p50.transfer", "opaque"),
    },
    Issue {
        name: "three-7000",
        holds: |look| {
            let (red, blue) = (Vec3::new(0.9, 0.3, 0.3), Vec3::new(0.4, 0.5, 0.9));
            near(look.at(0.0, 2.0, 0.0), Vec3::ONE, 1e-6)
                && near(look.at(0.0, 1.0, 0.0), red, ROUNDED)
                && near(look.at(0.0, 0.0, 0.0), red * blue, ROUNDED)
                && near(look.at(-0.9, 0.0, 0.0), red, ROUNDED)
                && near(look.at(0.9, 0.0, 0.0), blue, ROUNDED)
        },
        wrong: ("shadow.receiver", "nearest"),
    },
    Issue {
        name: "godot-proposals-3276",
        holds: |look| {
            let (mean, deviation) = look.over(0.0, 0.7);
            (mean - 0.6).abs() < 0.01 && deviation < 0.03
        },
        wrong: ("shadow.soften", "false"),
    },
    Issue {
        name: "godot-proposals-11073",
        holds: |look| {
            let (wall, shaft) = (Vec3::new(0.1, 0.2, 0.3), look.pixel(0.5));
            near(look.pixel(0.2), wall, 1e-3) && (shaft - wall).min_element() > 0.02
        },
        wrong: ("air.extinction", "0.15"),
    },
    Issue {
        name: "playcanvas-5903",
        holds: |look| {
            let within = |x, half, passed: f32| (look.over(x, half).0 - passed).abs() < 0.02;
            within(0.0, 0.4, 0.25) && within(-1.0, 0.4, 0.5) && within(1.0, 0.4, 0.5)
        },
        wrong: ("material.pane.tint", "[0.5, 0.5, 0.5, 0.7]"),
    },
    Issue {
        name: "playcanvas-738",
        holds: |look| {
            let dims = [0.0, 0.3, 0.6].iter().all(|&x| {
                let light = look.at(x, 0.0, 0.0);
                near(light, through_smoke(&look.0, x), 0.03) && light.x < 0.97
            });
            dims && near(look.at(2.0, 0.0, 1.5), Vec3::ONE, 1e-6)
        },
        wrong: ("material.smoke.transfer", "none"),
    },
    Issue {
        name: "hanabi-215",
        holds: |look| {
            let lights = look.at_all(&[Vec3::X * 1.2, Vec3::X * -1.2]);
            let [left_there, right_there, left_here, right_here] =
                [0, 1, 2, 3].map(|i| lights[i][0]);
            let own = left_there.max(right_here);
            own < 0.6 && right_there.min(left_here) > 0.98
        },
        wrong: ("light.right.direction", "[1, -1, 0]"),
    },
    Issue {
        name: "oloengine-723",
        holds: |look| {
            let down = [2.6, 1.8, 1.5, 1.3, 0.4].map(|y| look.at(0.0, y, 0.0).x);
            down[0] > 0.99 && down.windows(2).all(|pair| pair[1] < 0.97 * pair[0]) && down[4] < 0.5
        },
        wrong: ("shadow.receiver", "nearest"),
    },
    Issue {
        name: "gzdoom-1393",
        holds: |look| {
            near(look.at(-1.0, 0.0, 0.0), Vec3::ONE, 1e-6)
                && near(look.at(1.0, 0.0, 0.0), Vec3::splat(0.1 * 0.1), ROUNDED)
        },
        wrong: ("material.plasma.transfer", "filter"),
    },
    Issue {
        name: "potree-74",
        holds: |look| {
            // Half-way up a pillar, and under the arch.
            let shade = |x: f32, y: f32| look.at(x + 0.7 * y, 0.0, 0.4 * y).x;
            shade(-0.5, 0.6) < 0.1 && shade(0.5, 0.6) < 0.1 && shade(0.0, 0.6) > 0.999
        },
        wrong: ("material.scan.casts", "false"),
    },
];

/// Light straight down through soft discs of the `smoke` transfer at (x, 0), from their formula.
fn through_smoke(scene: &Scene, x: f32) -> Vec3 {
    let tint = scene.materials[scene.particles[0].material as usize].tint;
    scene.particles.iter().fold(Vec3::ONE, |light, particle| {
        let away = (particle.center.with_y(0.0) - Vec3::X * x).length() / particle.radius;
        let color = tint * particle.color;
        let a = color.w * (1.0 - away * away).max(0.0).powi(2);
        let color = color.truncate();
        light * (1.0 - a) * (1.0 - a * (1.0 - color))
    })
}

fn folder() -> PathBuf {
    PathBuf::from(crate::common::ROOT).join("data/issues")
}

fn look(name: &str, set: &[(String, String)]) -> Look {
    let path = folder().join(format!("{name}.toml"));
    Look(scene::load_with(&path, set).unwrap_or_else(|error| panic!("{error}")))
}

#[test]
fn what_they_wished_holds() {
    for Issue { name, holds, .. } in ISSUES {
        assert!(holds(&look(name, &[])), "{name}");
    }
}

#[test]
fn what_is_wrong_is_noticed() {
    for Issue { name, holds, wrong: (key, value) } in ISSUES {
        let set = [(key.to_owned(), value.to_owned())];
        assert!(!holds(&look(name, &set)), "{name} with {key} = {value}");
    }
}

#[test]
fn each_scene_is_checked_and_named() {
    let files: BTreeSet<String> = fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    let checked: BTreeSet<String> = ISSUES.iter().map(|issue| issue.name.to_owned()).collect();
    assert_eq!(files, checked);
    let page = fs::read_to_string(folder().join("../../docs/compare.md")).unwrap();
    for name in files {
        assert!(page.contains(&format!("data/issues/{name}.toml")), "docs/compare.md: {name}");
    }
}
