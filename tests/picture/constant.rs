//! Still objects in constant light look the same, whatever moves beside them.
use super::steady::VISIBLE;
use crate::common::{files::read, gpu};
use gobo::{
    View,
    gpu::Tier,
    model::Course,
    view::{atlas::AtlasLimits, picture_views},
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::Scene;

/// A box and a pane at the left of a ground.
const STILL: &str = "
[[shape]]
kind = 'box'
material = 'brick'
translation = [-2, 0.4, 0]
scale = [0.5, 0.8, 0.5]
rotation = [0, 25, 0]
[[shape]]
kind = 'pane'
material = 'glass'
translation = [-1, 0.5, 0.6]
rotation = [0, -35, 0]
scale = [0.8, 0.9, 1]
";

const HEAD: &str = "
[camera]
eye = [-0.4, 2.6, 5.2]
target = [0.1, 0.3, 0]
fov_y = 46
size = [160, 100]
samples = 1
[shadow]
size = 128
receiver = 'curve'
[[material]]
name = 'ground'
transfer = 'opaque'
casts = false
tint = [0.6, 0.58, 0.55, 1]
[[material]]
name = 'brick'
transfer = 'opaque'
tint = [0.5, 0.3, 0.2, 1]
[[material]]
name = 'glass'
tint = [0.2, 0.5, 0.9, 1]
[[material]]
name = 'smoke'
tint = [0.6, 0.6, 0.6, 0.3]
[[shape]]
kind = 'plane'
material = 'ground'
scale = [60, 1, 60]
";

const SMOKE: &str = "
[[emitter]]
material = 'smoke'
rate = 120
lifetime = [1, 2]
start = -2
position = [2.6, 0.2, 0]
velocity = [0.8, 1.5, 0]
spread = 0.8
drag = 0.3
radius = [0.1, 0.3]
";

const BALL: &str = "
[[shape]]
name = 'ball'
kind = 'sphere'
material = 'brick'
translation = [2, 0.8, 0]
scale = [0.6, 0.6, 0.6]
[[animate]]
target = 'shape.ball.translation'
times = [0, 0.37, 0.8, 1.4]
values = [[2, 0.8, 0], [2.3, 1.7, 0.5], [2.1, 0.5, -0.9], [3.4, 1.1, 0.2]]
";

/// Two legs and a body that walk to the right, away from the box.
const WALKER: &str = "
[[shape]]
name = 'left'
kind = 'box'
material = 'brick'
translation = [1.6, 0.4, 0.1]
scale = [0.15, 0.8, 0.15]
[[shape]]
name = 'right'
kind = 'box'
material = 'brick'
translation = [1.6, 0.4, -0.1]
scale = [0.15, 0.8, 0.15]
[[shape]]
name = 'body'
kind = 'sphere'
material = 'brick'
translation = [1.6, 1.1, 0]
scale = [0.4, 0.6, 0.4]
[[animate]]
target = 'shape.left.rotation'
times = [0, 0.4, 0.8, 1.2, 1.6]
values = [[0, 0, 30], [0, 0, -30], [0, 0, 30], [0, 0, -30], [0, 0, 30]]
[[animate]]
target = 'shape.right.rotation'
times = [0, 0.4, 0.8, 1.2, 1.6]
values = [[0, 0, -30], [0, 0, 30], [0, 0, -30], [0, 0, 30], [0, 0, -30]]
[[animate]]
target = 'shape.left.translation'
times = [0, 1.6]
values = [[1.6, 0.4, 0.1], [4, 0.4, 0.1]]
[[animate]]
target = 'shape.right.translation'
times = [0, 1.6]
values = [[1.6, 0.4, -0.1], [4, 0.4, -0.1]]
[[animate]]
target = 'shape.body.translation'
times = [0, 1.6]
values = [[1.6, 1.1, 0], [4, 1.1, 0]]
";

/// A lamp over the ground's right side, which sways.
const SWAYING: &str = "
[[light]]
name = 'swaying'
kind = 'spot'
position = [2.4, 3, 0]
direction = [0, -1, 0]
angle = 30
intensity = 12
[[animate]]
target = 'light.swaying.position'
times = [0, 0.7, 1.4]
values = [[2.4, 3, 0], [3, 2, 0.4], [2.2, 3.4, -0.3]]
";

const SUN: &str = "
[[light]]
kind = 'directional'
direction = [0.7, -1, -0.3]
intensity = 3
";
const SPOT: &str = "
[[light]]
kind = 'spot'
position = [-3.5, 4, 1]
direction = [0.6, -1, -0.15]
angle = 80
intensity = 40
";
const POINT: &str = "
[[light]]
kind = 'point'
position = [-3.2, 3, 1]
intensity = 25
";

/// Lights, and the movement beside the box.
fn scenes() -> Vec<(&'static str, String, &'static str)> {
    let rect = "source = { kind = 'rect', width = 0.4, height = 0.2 }\n";
    vec![
        ("a sun, smoke", SUN.to_owned(), SMOKE),
        ("a sun, a ball", SUN.to_owned(), BALL),
        ("cascades, a walker", format!("{SUN}cascades = 2\n"), WALKER),
        ("a spot, a ball", SPOT.to_owned(), BALL),
        ("a spot, a lamp", SPOT.to_owned(), SWAYING),
        ("a rectangle, a walker", format!("{SPOT}{rect}"), WALKER),
        ("a point, smoke", POINT.to_owned(), SMOKE),
        ("viewpoints, a ball", format!("{SPOT}{}", rect.replace(" }", ", viewpoints = 4 }")), BALL),
    ]
}

/// Times of the frames [s].
const TIMES: [f64; 7] = [0.0, 0.21, 0.37, 0.6, 0.83, 1.1, 1.4];
/// Pixels by which filters and samples extend a moving object beyond its visible outline.
const APART: i32 = 3;

fn pictures(renderer: &mut Renderer, mut scene: Scene) -> Vec<Vec<[u8; 3]>> {
    let options = RenderOptions::default();
    let picture = |&time| renderer.render_at(&mut scene, time, 0.04, &options).unwrap().picture.rgb;
    TIMES.iter().map(picture).collect()
}

/// Largest minus smallest of each pixel's channels.
fn ranges(pictures: &[Vec<[u8; 3]>]) -> Vec<u8> {
    let range = |pixel: usize| {
        let of = |c: usize| {
            let values = pictures.iter().map(|picture| picture[pixel][c]);
            values.clone().max().unwrap() - values.min().unwrap()
        };
        (0..3).map(of).max().unwrap()
    };
    (0..pictures[0].len()).map(range).collect()
}

/// Whether each pixel has the same light in all frames: nothing that moves is close, by the ground alone.
fn constant(ranges: &[u8], width: i32) -> Vec<bool> {
    let height = ranges.len() as i32 / width;
    let is_still = |at: i32| {
        let (x, y) = (at % width, at / width);
        let rows = (y - APART).max(0)..=(y + APART).min(height - 1);
        rows.flat_map(|y| {
            ((x - APART).max(0)..=(x + APART).min(width - 1)).map(move |x| y * width + x)
        })
        .all(|near| ranges[near as usize] == 0)
    };
    (0..ranges.len() as i32).map(is_still).collect()
}

#[test]
fn nothing_that_stands_still_changes() {
    let mut renderer = Renderer::on(gpu(Tier::Native)).unwrap();
    let mut wrong = Vec::new();
    for (name, light, mover) in scenes() {
        let alone = read(&format!("{HEAD}{light}{mover}")).unwrap();
        let constant = constant(&ranges(&pictures(&mut renderer, alone)), 160);
        let still = constant.iter().filter(|&&it| it).count();
        assert!((constant.len() / 4..constant.len()).contains(&still), "{name}: {still}");
        let mut changes = |scene: Scene| {
            let all = ranges(&pictures(&mut renderer, scene));
            let ranges = all.iter().zip(&constant).filter(|&(_, &it)| it).map(|(&range, _)| range);
            let most = ranges.clone().max().unwrap();
            (ranges.filter(|&range| range > VISIBLE).count(), most)
        };
        let whole = read(&format!("{HEAD}{light}{STILL}{mover}")).unwrap();
        let followed = changes(Scene { course: Course::default(), ..whole.clone() });
        let kept = changes(whole);
        println!("{name}: {still} pixels, {kept:?}; views of the frame: {followed:?}");
        if kept.0 > 0 {
            wrong.push(name);
        }
        // The check must notice views that follow the frame.
        assert!(light != SUN || followed.0 > 0, "{name}");
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// A still light has the same views in all frames, in any order; so has a scene that is rendered at one time
/// alone.
#[test]
fn lights_that_stand_still_keep_their_views() {
    let camera = "
[[animate]]
target = 'camera.eye'
times = [0, 0.5, 1.4]
values = [[-1.2, 2.4, 4.6], [-12, 8, 30], [2.5, 1.6, 3]]
";
    let views = |scene: &mut Scene, time: f64| -> Vec<View> {
        scene.set_time(time);
        picture_views(scene, &AtlasLimits::CORE).0
    };
    for (light, mover) in [(SUN, BALL), (SUN, SMOKE), (SPOT, WALKER), (POINT, BALL)] {
        let text =
            format!("{HEAD}{light}{STILL}{mover}{camera}").replace("[160, 100]", "[640, 400]");
        let mut scene = read(&text).unwrap();
        let first = views(&mut scene, 0.0);
        assert_eq!(first.iter().any(View::is_detail), light != POINT, "{light}");
        for time in [1.4, 0.3, 0.5, 9.0] {
            assert_eq!(views(&mut scene, time), first, "{light}{mover} at {time} s");
            assert_eq!(views(&mut read(&text).unwrap(), time), first, "{light}{mover} at {time} s");
        }
    }
}
