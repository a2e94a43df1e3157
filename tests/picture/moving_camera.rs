//! Still objects in constant light look the same, wherever the camera is.
//!
//! The camera looks straight down at a ground from places whose pixels' centres are in one lattice there: the
//! same places of the ground are in several pictures, exactly.
use super::steady::VISIBLE;
use crate::common::{files::read, gpu};
use gobo::gpu::Tier;
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::Scene;
use std::collections::HashMap;

/// A post, a pane and three rods over a ground.
const STILL: &str = "
[shadow]
size = 128
[[material]]
name = 'ground'
transfer = 'opaque'
casts = false
roughness = 1
tint = [0.6, 0.58, 0.55, 1]
[[material]]
name = 'brick'
transfer = 'opaque'
[[material]]
name = 'glass'
tint = [0.2, 0.5, 0.9, 1]
[[shape]]
kind = 'plane'
material = 'ground'
scale = [30, 1, 30]
[[shape]]
kind = 'box'
material = 'brick'
translation = [-1.9, 0.3, 0]
scale = [0.3, 0.6, 0.3]
rotation = [0, 25, 0]
[[shape]]
kind = 'pane'
material = 'glass'
translation = [-1.4, 0.3, 0.4]
rotation = [0, -35, 0]
scale = [0.5, 0.6, 1]
[[shape]]
kind = 'box'
material = 'brick'
translation = [-1.5, 0.5, -0.1]
scale = [0.6, 0.03, 0.03]
[[shape]]
kind = 'box'
material = 'brick'
translation = [-1.5, 0.5, -0.25]
scale = [0.6, 0.03, 0.03]
[[shape]]
kind = 'box'
material = 'brick'
translation = [-1.5, 0.5, -0.4]
scale = [0.6, 0.03, 0.03]
";

const SUN: &str = "
[[light]]
kind = 'directional'
direction = [0.7, -1, -0.3]
intensity = 2
";
const SPOT: &str = "
[[light]]
kind = 'spot'
position = [-3.5, 4, 1]
direction = [0.6, -1, -0.15]
angle = 80
intensity = 30
";

/// Picture's size [pixels].
const SIZE: [i32; 2] = [120, 90];
/// Edge of a nearby camera's pixel on the ground [m].
const PIXEL: f64 = 0.02;
/// Channels below which a pixel of a scene with a black ground shows that ground.
const BLACK: u8 = 12;

/// A camera that looks down.
struct Pose {
    /// Place over the ground, x and z [`PIXEL`].
    place: [i32; 2],
    /// Edge of a pixel on the ground [`PIXEL`]; odd, so that the lattice is the same.
    edge: i32,
    /// Upward direction of the picture, x and z.
    up: [i32; 2],
}

/// To a distance three times as large, back with a quarter turn, and aside.
const POSES: [Pose; 4] = [
    Pose { place: [-75, -5], edge: 1, up: [0, -1] },
    Pose { place: [-45, 10], edge: 3, up: [0, -1] },
    Pose { place: [-70, -15], edge: 1, up: [1, 0] },
    Pose { place: [-60, 2], edge: 1, up: [0, -1] },
];
/// The camera's keys.
const KEYS: [&str; 3] = ["eye", "target", "up"];

impl Pose {
    /// Values of [`KEYS`].
    fn vectors(&self) -> [[f64; 3]; 3] {
        let [x, z] = self.place.map(|at| PIXEL * f64::from(at));
        let height = PIXEL * f64::from(self.edge * SIZE[1]) / 2.0 / 20f64.to_radians().tan();
        let up = self.up.map(f64::from);
        [[x, height, z], [x, 0.0, z], [up[0], 0.0, up[1]]]
    }

    /// Place of the ground that a pixel shows [halves of `PIXEL`].
    fn seen(&self, at: usize) -> [i32; 2] {
        let from_middle = |at: i32, size: i32| self.edge * (2 * at + 1 - size);
        let right = from_middle(at as i32 % SIZE[0], SIZE[0]);
        let down = from_middle(at as i32 / SIZE[0], SIZE[1]);
        let ([x, z], [up_x, up_z]) = (self.place, self.up);
        [2 * x - up_z * right - up_x * down, 2 * z + up_x * right - up_z * down]
    }

    /// A scene whose camera stays there.
    fn alone(&self, rest: &str) -> Scene {
        let values = KEYS.iter().zip(self.vectors());
        let camera: String = values.map(|(key, value)| format!("{key} = {value:?}\n")).collect();
        scene(&camera, rest)
    }
}

/// Nearby surfaces in the picture do not darken the ground: they are others from elsewhere.
fn scene(camera: &str, rest: &str) -> Scene {
    let head = format!("fov_y = 40\nsize = {SIZE:?}\nsamples = 1\nocclusion = false\n");
    read(&format!("[camera]\n{camera}{head}{rest}")).unwrap_or_else(|error| panic!("{error}"))
}

/// A scene whose camera is in each pose for a moment, a second after the former.
fn moving(rest: &str) -> Scene {
    let tracks = KEYS.iter().enumerate().map(|(index, key)| {
        let values = POSES.each_ref().map(|pose| pose.vectors()[index]);
        format!("[[animate]]\ntarget = 'camera.{key}'\ntimes = [0, 1, 2, 3]\nvalues = {values:?}\n")
    });
    scene("eye = [0, 5, 1]\n", &(rest.to_owned() + &tracks.collect::<String>()))
}

/// Places of the ground that several pictures show, and how many of them change by more than [`VISIBLE`], and
/// by how much at most.
fn changes(grounds: &[Vec<bool>], pictures: &[Vec<[u8; 3]>]) -> (usize, usize, u8) {
    let mut places: HashMap<[i32; 2], Vec<[u8; 3]>> = HashMap::new();
    for (pose, (ground, picture)) in POSES.iter().zip(grounds.iter().zip(pictures)) {
        for at in (0..picture.len()).filter(|&at| ground[at]) {
            places.entry(pose.seen(at)).or_default().push(picture[at]);
        }
    }
    let range = |colors: &Vec<[u8; 3]>| {
        let of = |c: usize| {
            let values = colors.iter().map(|color| color[c]);
            values.clone().max().unwrap() - values.min().unwrap()
        };
        (0..3).map(of).max().unwrap()
    };
    let ranges: Vec<u8> = places.values().filter(|colors| colors.len() > 1).map(range).collect();
    let changed = ranges.iter().filter(|&&range| range > VISIBLE).count();
    (ranges.len(), changed, ranges.iter().copied().max().unwrap_or(0))
}

#[test]
fn light_stays_where_it_is_while_the_camera_moves() {
    let mut renderer = Renderer::on(gpu(Tier::Native)).unwrap();
    let rect = "source = { kind = 'rect', width = 0.4, height = 0.2 }\n";
    for (name, light) in
        [("a sun", SUN), ("a spot", SPOT), ("a rectangle", &format!("{SPOT}{rect}"))]
    {
        let rest = format!("{STILL}{light}");
        let mut picture = |scene: &mut Scene, seconds: f64| {
            let options = RenderOptions::default();
            renderer.render_at(scene, seconds, 0.04, &options).unwrap().picture.rgb
        };
        // Where the ground is seen, all is dark without its colour.
        let black = rest.replace("0.6, 0.58, 0.55", "0, 0, 0");
        let is_black = |color: &[u8; 3]| color.iter().all(|&c| c < BLACK);
        let grounds = POSES.each_ref().map(|pose| {
            let shown = picture(&mut pose.alone(&black), 0.0);
            shown.iter().map(is_black).collect::<Vec<_>>()
        });
        let mut whole = moving(&rest);
        let kept = [0.0, 1.0, 2.0, 3.0].map(|seconds| picture(&mut whole, seconds));
        let alone = POSES.each_ref().map(|pose| picture(&mut pose.alone(&rest), 0.0));
        let (kept, alone) = (changes(&grounds, &kept), changes(&grounds, &alone));
        println!("{name}: {kept:?}, with views of each place: {alone:?}");
        assert!(kept.0 > 5000, "{name}: {} places", kept.0);
        assert_eq!(kept.1, 0, "{name}: {kept:?}");
        // The check must notice views that follow the camera.
        assert!(alone.1 > 20, "{name}: {alone:?}");
    }
}
