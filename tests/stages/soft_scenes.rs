//! Lights with a size by default settings: texels and viewpoints that a scene file leaves open.
use super::soft::on_gpu;
use crate::common::area_truth;
use gobo::{glam::Vec3, model::ReceiverPoint};
use gobo_scene::{LoadOptions, Scene, load_text};
use std::{fmt::Write as _, path::Path};

/// Points of the floor along an edge of a usual grid.
const POINTS: usize = 60;
/// Points of the light.
const PLACES: usize = 512;

/// A floor with a light and shapes above; mean, 99th percentile and worst error that are allowed where some
/// channel is in partial shadow, over a rectangle of the floor (x, then z).
struct Case {
    name: &'static str,
    size: u32,
    light: &'static str,
    shapes: String,
    floor: [f32; 4],
    /// Points of the floor along an edge of the grid.
    points: usize,
    most: [f64; 3],
}

fn boxes(all: impl IntoIterator<Item = ([f32; 3], [f32; 3])>) -> String {
    let shape = |mut text: String, (at, scale)| {
        write!(
            text,
            "[[shape]]\nkind = 'box'\nmaterial = 'solid'\ntranslation = {at:?}\nscale = {scale:?}\n"
        )
        .unwrap();
        text
    };
    all.into_iter().fold(String::new(), shape)
}

fn pane(material: &str, at: [f32; 3], turn: [f32; 3], scale: [f32; 3]) -> String {
    format!(
        "[[shape]]\nkind = 'pane'\nmaterial = '{material}'\ntranslation = {at:?}\nrotation = {turn:?}\n\
         scale = {scale:?}\n"
    )
}

/// `count` values from `first` on.
fn steps(count: u32, first: f32, step: f32) -> impl Iterator<Item = f32> {
    (0..count).map(move |i| first + step * i as f32)
}

impl Case {
    fn scene(&self) -> Scene {
        let Self { size, light, shapes, .. } = self;
        let text = format!(
            "[shadow]\nsize = {size}\nreceiver = 'curve'\n\
             [[material]]\nname = 'solid'\ntransfer = 'opaque'\n\
             [[material]]\nname = 'orange'\ntint = [0.9, 0.3, 0.1, 0.95]\n\
             [[shape]]\nkind = 'plane'\nmaterial = 'solid'\nscale = [14, 1, 14]\n\
             [[light]]\n{light}\n{shapes}"
        );
        // As `gobo light` asks: for all that the light reaches, not for a picture.
        let mut options = LoadOptions::default();
        options.of_picture = false;
        load_text(&text, Path::new("scene.toml"), &options)
            .unwrap_or_else(|error| panic!("{}: {error}", self.name))
    }

    fn assert_accurate(&self) {
        let scene = self.scene();
        let ([x0, x1, z0, z1], edge) = (self.floor, self.points);
        let at = |i: usize, low: f32, high: f32| low + (high - low) * i as f32 / (edge - 1) as f32;
        let place = |i: usize| Vec3::new(at(i % edge, x0, x1), 0.0, at(i / edge, z0, z1));
        let point = |i| ReceiverPoint { position: place(i) - scene.origin, normal: Vec3::Y };
        let points: Vec<_> = (0..edge * edge).map(point).collect();
        let light = &scene.lights[0];
        let error = |(p, found): (&ReceiverPoint, Vec3)| {
            let truth = area_truth::share_of_places(&scene, light, p.position, p.normal, PLACES);
            let is_partial = truth.to_array().iter().any(|share| (0.03..0.97).contains(share));
            is_partial.then(|| (truth - found.as_dvec3()).abs().max_element())
        };
        let mut errors: Vec<f64> =
            points.iter().zip(on_gpu(&scene, &points)).filter_map(error).collect();
        assert!(errors.len() > 200, "{}: {} points", self.name, errors.len());
        errors.sort_by(f64::total_cmp);
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let found = [mean, errors[errors.len() * 99 / 100], errors[errors.len() - 1]];
        println!("{}: {found:.4?}, {:?}", self.name, scene.soft);
        let is_met = found.iter().zip(self.most).all(|(found, most)| *found <= most);
        assert!(is_met, "{}: {found:?}, at most {:?}", self.name, self.most);
    }
}

/// A post before orange glass under a bulb: where its penumbra falls through the glass, light stays orange.
#[test]
fn glass_behind_a_post_keeps_its_colour() {
    let post = boxes([([0.0, 0.7, -0.45], [0.12, 1.4, 0.12])]);
    Case {
        name: "post",
        size: 1024,
        light: "kind = 'point'\nposition = [0, 1.8, -1.2]\nsource = { kind = 'sphere', radius = 0.1 }",
        shapes: post + &pane("orange", [0.0, 0.6, -0.1], [0.0; 3], [1.2, 1.2, 1.0]),
        floor: [-1.2, 1.2, 0.1, 2.2],
        points: POINTS,
        most: [0.012, 0.06, 0.2],
    }
    .assert_accurate();
}

/// A bulb behind bars over orange glass.
#[test]
fn bars_before_a_bulb_are_soft() {
    let bars = boxes(steps(5, -0.5, 0.25).map(|x| ([x, 1.2, 0.0], [0.04, 0.04, 1.2])));
    Case {
        name: "bars",
        size: 1024,
        light: "kind = 'point'\nposition = [0, 2.2, 0]\nsource = { kind = 'sphere', radius = 0.08 }",
        shapes: bars + &pane("orange", [0.3, 0.6, 0.2], [90.0, 0.0, 20.0], [0.8, 0.7, 1.0]),
        floor: [-1.5, 1.5, -1.5, 1.5],
        points: POINTS,
        most: [0.01, 0.06, 0.15],
    }
    .assert_accurate();
}

/// Posts far below a grille, under a disc.
#[test]
fn posts_under_a_grille_have_their_penumbrae() {
    let grille = boxes(steps(5, -0.6, 0.3).map(|x| ([x, 1.6, 0.1], [0.08, 0.03, 1.6])));
    let posts = boxes(
        steps(4, 0.0, 1.0).map(|i| ([0.33 * i - 0.5, 0.25, 0.2 * i - 0.3], [0.07, 0.5, 0.07])),
    );
    Case {
        name: "grille",
        size: 1024,
        light: "kind = 'spot'\nposition = [0.3, 3, -0.2]\ndirection = [-0.3, -3, 0.2]\nangle = 80\n\
                source = { kind = 'disc', radius = 0.2 }",
        shapes: grille + &posts,
        floor: [-1.2, 1.2, -1.2, 1.2],
        points: 110,
        most: [0.012, 0.06, 0.2],
    }
    .assert_accurate();
}

/// A pane 15 cm over the floor under a rectangle of light, in maps of 512 texels by default.
#[test]
fn a_low_pane_under_a_rectangle_is_soft() {
    Case {
        name: "low pane",
        size: 512,
        light: "kind = 'spot'\nposition = [1.2, 2.6, 1.2]\ndirection = [-1.2, -2.6, -1.2]\nangle = 90\n\
                source = { kind = 'rect', width = 0.6, height = 0.2 }",
        shapes: pane("solid", [-0.637, 0.15, 0.082], [90.0, 0.0, 25.8], [0.5, 0.5, 1.0]),
        floor: [-1.5, -0.2, -0.7, 0.6],
        points: 90,
        most: [0.03, 0.1, 0.2],
    }
    .assert_accurate();
}

/// A table under a lattice and a long rectangle.
#[test]
fn a_table_under_a_lattice_has_its_penumbrae() {
    let legs = [-0.4_f32, 0.4].into_iter().flat_map(|x| [-0.25_f32, 0.25].map(|z| (x, z)));
    let legs = legs.map(|(x, z)| ([x, 0.3, z], [0.05, 0.6, 0.05]));
    let along = steps(5, -0.7, 0.35).map(|x| ([x, 1.5, 0.0], [0.06, 0.03, 1.6]));
    let across = steps(4, -0.6, 0.4).map(|z| ([0.0, 1.53, z], [1.6, 0.03, 0.06]));
    let top = ([0.0, 0.62, 0.0], [0.9, 0.04, 0.6]);
    Case {
        name: "table",
        size: 1024,
        light: "kind = 'spot'\nposition = [0.5, 2.6, 0.5]\ndirection = [-0.5, -2.6, -0.5]\nangle = 100\n\
                source = { kind = 'rect', width = 0.6, height = 0.2 }",
        shapes: boxes([top].into_iter().chain(legs).chain(along).chain(across)),
        floor: [-1.3, 0.9, -1.1, 0.8],
        points: POINTS,
        most: [0.012, 0.075, 0.2],
    }
    .assert_accurate();
}

/// A tube over slats.
#[test]
fn a_tube_over_slats_is_soft() {
    Case {
        name: "tube",
        size: 1024,
        light: "kind = 'spot'\nposition = [0.2, 2.4, 0.1]\ndirection = [0, -1, 0.01]\nangle = 110\n\
                source = { kind = 'rect', width = 1.2, height = 0.03 }",
        shapes: boxes(steps(6, -0.6, 0.24).map(|x| ([x, 0.5, 0.0], [0.1, 0.02, 0.9]))),
        floor: [-1.2, 1.2, -0.8, 0.8],
        points: POINTS,
        most: [0.02, 0.06, 0.15],
    }
    .assert_accurate();
}

/// The sun's half degree over posts and a grating, in a map of 14 m.
#[test]
fn a_far_sun_is_soft() {
    let posts = steps(4, 0.0, 1.0).map(|i| ([2.0 * i - 4.0, 1.5, 2.0 - i], [0.25, 3.0, 0.25]));
    let bars = steps(5, 1.0, 0.4).map(|x| ([x, 2.5, -1.0], [0.12, 0.05, 3.0]));
    Case {
        name: "sun",
        size: 1024,
        light: "kind = 'directional'\ndirection = [-0.5, -1, -0.3]\nsource = { kind = 'sun', angle = 0.53 }",
        shapes: boxes(posts.chain(bars)),
        floor: [-0.4, 0.6, -1.6, -0.6],
        points: POINTS,
        most: [0.05, 0.15, 0.25],
    }
    .assert_accurate();
}
