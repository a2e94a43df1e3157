//! Shadows of still casters stand still while other casters move.
use crate::common::{files::read, gpu, tiers};
use gobo::{Bounds, HeldBounds, Light, glam::Vec3, gpu::Tier, light_views};
use gobo_picture::{RenderOptions, Renderer};

/// A box and its shadow fill the picture. A moving caster is beside it, with its shadow on the other side.
const STILL: &str = "
[camera]
eye = [-2, 2.2, 4]
target = [-1.6, 0.3, 0]
fov_y = 40
size = [96, 72]
[shadow]
size = 256
[[light]]
name = 'sun'
kind = 'directional'
direction = [0.9, -1, -0.1]
[[material]]
name = 'ground'
transfer = 'opaque'
casts = false
[[material]]
name = 'brick'
transfer = 'opaque'
[[material]]
name = 'smoke'
tint = [0.6, 0.6, 0.6, 0.3]
[[shape]]
kind = 'plane'
material = 'ground'
scale = [60, 1, 60]
[[shape]]
kind = 'box'
material = 'brick'
translation = [-2, 0.5, 0]
scale = [0.7, 1, 0.7]
";

const MOVING: [(&str, &str); 3] = [
    (
        "smoke",
        "
[[emitter]]
material = 'smoke'
rate = 60
lifetime = [1, 2]
start = -2
position = [4, 0.2, 0]
velocity = [1, 1.5, 0]
spread = 0.8
drag = 0.3
radius = [0.1, 0.3]
",
    ),
    (
        "a ball",
        "
[[shape]]
name = 'ball'
kind = 'sphere'
material = 'brick'
translation = [4, 1, 0]
[[animate]]
target = 'shape.ball.translation'
times = [0, 0.37, 0.8, 1.4]
values = [[4, 1, 0], [4.3, 1.9, 0.5], [4.1, 0.7, -0.9], [5, 1.1, 0.2]]
",
    ),
    (
        "a cloud",
        "
[[shape]]
kind = 'sphere'
material = 'brick'
translation = [4, 2, 0]
displace = { amplitude = 0.4, frequency = 1.3, speed = 2, seed = 5 }
",
    ),
];

/// Least step that a viewer sees as a flicker: 6 of 255.
pub(super) const VISIBLE: u8 = 6;
const FRAMES: usize = 16;

/// Median over the frames of the largest step of each displayed pixel.
fn median_steps(tier: Tier, scene: &str) -> Vec<u8> {
    let mut scene = read(scene).unwrap();
    let mut renderer = Renderer::on(gpu(tier)).unwrap();
    let pictures: Vec<Vec<[u8; 3]>> = (0..FRAMES)
        .map(|frame| {
            scene.set_time(frame as f64 / 24.0);
            renderer.render(&scene, &RenderOptions::default()).unwrap().picture.rgb
        })
        .collect();
    let dark = pictures[0].iter().filter(|rgb| rgb[1] < 150).count();
    assert!((pictures[0].len() / 40..pictures[0].len() / 2).contains(&dark), "{dark}");
    (0..pictures[0].len())
        .map(|pixel| {
            let step = |pair: &[Vec<[u8; 3]>]| {
                let [a, b] = [pair[0][pixel], pair[1][pixel]];
                (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap()
            };
            let mut steps: Vec<u8> = pictures.windows(2).map(step).collect();
            steps.sort_unstable();
            steps[steps.len() / 2]
        })
        .collect()
}

#[test]
fn shadows_of_still_casters_do_not_crawl() {
    for tier in tiers(Tier::Native) {
        for (name, moving) in MOVING {
            for light in ["", "cascades = 2"] {
                let still = STILL.replace("[0.9, -1, -0.1]", &format!("[0.9, -1, -0.1]\n{light}"));
                let steps = median_steps(tier, &format!("{still}{moving}"));
                let seen = steps.iter().filter(|&&step| step > VISIBLE).count();
                assert_eq!(seen, 0, "{tier}, {name}, {light}");
            }
        }
    }
}

/// A host's views around moving casters: until the window grows by a step, every texel stays at its place in
/// the world, and so do the planes.
#[test]
fn views_of_a_host_keep_their_texels() {
    const SIZE: u32 = 512;
    let sun = Light::directional(Vec3::new(0.4, -1.0, 0.3));
    let view = |frame: u32| {
        let time = frame as f32 * 0.21;
        let moved = Vec3::new(time.sin(), 0.4 * (time * 1.7).cos(), (time * 0.6).sin());
        let bounds = Bounds { min: Vec3::splat(-3.0) - moved.abs(), max: Vec3::splat(3.0) + moved };
        light_views(0, &sun, SIZE, None, &bounds).unwrap().remove(0)
    };
    let point = Vec3::new(0.3, 0.1, -0.7);
    let views: Vec<_> = (0..200).map(view).collect();
    let mut grown = 0;
    for pair in views.windows(2) {
        if pair[0].scale != pair[1].scale {
            grown += 1;
            continue;
        }
        let [a, b] =
            [&pair[0], &pair[1]].map(|v| v.view_from_world.transform_point3(point) * v.scale);
        let apart = (a - b).truncate();
        assert!((apart - apart.round()).abs().max_element() < 1e-3, "{apart}");
    }
    // Two steps at most lie between the least and the largest window.
    assert!(grown < views.len() / 8, "{grown}");
}

/// Views around bounds that a host holds are the same in all but a few frames, and contain the moving caster.
#[test]
fn views_of_held_bounds_stay() {
    let sun = Light::directional(Vec3::new(0.4, -1.0, 0.3));
    let bounds = |frame: u32| {
        let time = frame as f32 * 0.07;
        let moved = Vec3::new(time.sin(), 0.4 * (time * 1.7).cos(), (time * 0.6).sin());
        Bounds { min: Vec3::splat(-3.0) - moved.abs(), max: Vec3::splat(3.0) + moved }
    };
    let views = |hold: &mut dyn FnMut(&Bounds) -> Bounds| {
        let view = |frame| light_views(0, &sun, 512, None, &hold(&bounds(frame))).unwrap();
        let views: Vec<_> = (0..600).map(view).collect();
        views.windows(2).filter(|pair| pair[0] != pair[1]).count()
    };
    let mut held = HeldBounds::default();
    let changes = views(&mut |bounds| {
        let held = held.hold(bounds);
        assert!(held.with(bounds) == held && held.radius() < 3.0 * bounds.radius());
        held
    });
    assert!(changes <= 2, "{changes}");
    assert!(views(&mut |bounds| *bounds) > 100);
    // Vanished casters are no longer held.
    let small = Bounds { min: Vec3::ZERO, max: Vec3::ONE };
    assert!(held.hold(&small).radius() < 2.0 * small.radius());
    let empty = held.hold(&Bounds::EMPTY);
    assert_eq!(empty, Bounds::EMPTY);
}
