//! Emitters of scene files on the device: the same maps and pictures as on the CPU, and the same frame alone
//! and in a sequence.
use crate::common::{TIERS, files::read, gpu, own_gpu, tiers};
use gobo::gpu::Tier;
use gobo_picture::{Frame, RenderOptions, Renderer};
use gobo_scene::Scene;

const STAGE: &str = "
[camera]
eye = [0, 2, 7]
target = [0, 0.8, 0]
size = [64, 48]
[shadow]
size = 96
receiver = 'nearest'
[[light]]
name = 'sun'
kind = 'directional'
direction = [0.3, -1, -0.2]
[[light]]
name = 'lamp'
kind = 'spot'
position = [2, 4, 2]
direction = [-2, -3.4, -2]
angle = 60
[[material]]
name = 'ground'
transfer = 'opaque'
casts = false
[[material]]
name = 'smoke'
tint = [0.9, 0.6, 0.3, 0.5]
[[material]]
name = 'grit'
transfer = 'opaque'
profile = 'flat'
[[material]]
name = 'gel'
transfer = 'stain'
shape = 'quad'
tint = [0.3, 0.8, 0.9, 1]
texture = { generate = 'noise', seed = 3, size = 16 }
receives = 'others'
[[material]]
name = 'fire'
transfer = 'none'
emission = [4, 2, 0.5]
[[shape]]
kind = 'plane'
material = 'ground'
scale = [9, 1, 9]
[[particles]]
material = 'smoke'
generate = { kind = 'dust', count = 200, min = [-1.5, 0.2, -1], max = [-0.5, 1.6, 1] }
";

/// Emitters without turbulence and boxes, so that rounding stays small: one on a path, and one that stops.
const CALM: &str = "
[[emitter]]
material = 'smoke'
rate = 500
lifetime = [0.8, 1.6]
start = -1
shape = 'sphere'
spread = 0.5
buoyancy = 1
drag = 1.2
wind = [0.6, 0, 0]
radius = [0.04, 0.16]
alpha = [0, 0.8, 0.2]
path = [[-1, -1, 0, 0], [0.2, 0.5, 0.2, 0], [0.25, 0.5, 0.4, 0], [1.5, 1, 0.2, 0.5]]
seed = 3
[[emitter]]
material = 'grit'
rate = 200
lifetime = 2
start = -0.5
stop = 0.3
position = [0.5, 0.3, 0.6]
velocity = [0.2, 2.5, 0.1]
spread = 0.9
gravity = 6
radius = [0.03]
color = [[0.2, 0.3, 0.9], [0.9, 0.3, 0.2]]
seed = 4
[[emitter]]
material = 'gel'
rate = 60
lifetime = [1, 2]
start = -1
shape = 'box'
extent = [1, 0.2, 1]
position = [0.8, 0.1, -0.4]
velocity = [0, 0.6, 0]
radius = [0.08, 0.14]
seed = 5
[[emitter]]
material = 'fire'
rate = 300
lifetime = 0.7
start = -1
shape = 'disc'
velocity = [0.3, 1.6, 0]
spread = 0.4
drag = 0.4
radius = [0.05, 0.01]
seed = 6
";

/// Turbulence, a ground and boxes, a path and a stop: all of them amplify rounding.
const WILD: &str = "
[[emitter]]
material = 'smoke'
rate = 400
lifetime = [0.4, 1.1]
start = -0.5
stop = 1.9
shape = 'disc'
spread = 1
buoyancy = 3
drag = 2
wind = [1, 0, 0.5]
turbulence = 2
evolve = 0.4
ground = 0
boxes = [{ min = [0.5, -1, -1], max = [1, 1.5, 1] }]
radius = [0.05, 0.2]
alpha = [0, 0.6, 0.1]
path = [[-0.5, 0, 0.2, 0], [0.51, 0.5, 0.2, 0], [0.513, 0.5, 0.4, 0], [2, -1, 0.2, 0]]
[[emitter]]
material = 'grit'
rate = 90
lifetime = 0.5
turbulence = 3
drag = 1
radius = [0.03]
";

const OPTIONS: RenderOptions<'static> = RenderOptions {
    maps: true,
    maps_of: None,
    sums: false,
    sample: None,
    curves_stay: false,
    keep: true,
    light: true,
    debug: &[],
    maps_only: false,
    watch: None,
};

/// On the native tier no material needs owners, so tiny particles may be scattered.
fn staged(tier: Tier, emitters: &str) -> Scene {
    let owners = if tier == Tier::Core { "" } else { "receives = 'others'\n" };
    let stage = STAGE.replace(owners, "");
    read(&format!("{stage}{emitters}")).unwrap_or_else(|error| panic!("{error}"))
}

/// The scene with all of its emitters on the device.
fn left_to_device(tier: Tier, emitters: &str) -> Scene {
    let mut scene = staged(tier, emitters);
    assert_eq!(scene.simulate_on_device(1 << 20), [""; 0]);
    scene
}

/// On the native tier tiny particles are scattered, as on a GPU.
fn new_renderer(tier: Tier) -> Renderer {
    let mut renderer = Renderer::on(gpu(tier)).unwrap();
    renderer.configure(|config| config.toggles.scatter_tiny = tier == Tier::Native);
    renderer
}

fn at(renderer: &mut Renderer, scene: &mut Scene, seconds: f64) -> Frame {
    scene.set_time(seconds);
    renderer.render(scene, &OPTIONS).unwrap_or_else(|error| panic!("{error}"))
}

/// Shares of texels whose filter differs by more than 0.01, of texels whose opaque depth differs by more than
/// 0.002, and of pixels whose light differs by more than 0.02.
fn shares_off(a: &Frame, b: &Frame) -> [f64; 3] {
    let far = |x: &[f32; 3], y: &[f32; 3], most: f32| (0..3).any(|c| (x[c] - y[c]).abs() > most);
    let (mut texels, mut filters, mut depths) = (0, 0, 0);
    assert_eq!(a.maps.len(), b.maps.len());
    for (a, b) in a.maps.iter().zip(&b.maps) {
        texels += a.filter.len();
        filters += a.filter.iter().zip(&b.filter).filter(|(x, y)| far(x, y, 0.01)).count();
        let pairs = a.opaque.iter().zip(&b.opaque);
        depths += pairs.filter(|(x, y)| (*x - *y).abs() > 0.002).count();
    }
    let (a, b) = (&a.picture.light, &b.picture.light);
    let pixels = a.iter().zip(b).filter(|(x, y)| far(x, y, 0.02)).count();
    let share = |count: usize, all: usize| count as f64 / all as f64;
    [share(filters, texels), share(depths, texels), share(pixels, a.len())]
}

fn assert_same(a: &Frame, b: &Frame, what: &str) {
    assert_eq!(a.maps.len(), b.maps.len(), "{what}");
    for (a, b) in a.maps.iter().zip(&b.maps) {
        assert!(a.view == b.view, "{what}: {:?} {:?}", a.view, b.view);
        assert!(a.filter == b.filter && a.nearest == b.nearest && a.opaque == b.opaque, "{what}");
        assert!(a.owner == b.owner, "{what}");
    }
    assert!(a.picture.light == b.picture.light, "{what}");
    assert_eq!(a.counters.casters, b.counters.casters, "{what}");
}

/// Positions of both differ by 1e-5 m, a ten-thousandth of a radius and less than a thousandth of a texel: a
/// soft disc's opacity changes by less than 1e-3, and a hard edge crosses the centre of one texel in a
/// thousand. So one texel in a thousand may be off, in a map of little more than soft discs. A force that is
/// off by an eighth moves particles by centimetres, and changes several texels in a thousand.
#[test]
fn the_device_draws_what_the_cpu_does() {
    const MAX: f64 = 0.001;
    for tier in tiers(Tier::Native) {
        let mut renderer = new_renderer(tier);
        let (mut on_cpu, mut on_device) = (staged(tier, CALM), left_to_device(tier, CALM));
        let wrong = |from: &str, to: &str| {
            assert!(CALM.contains(from));
            left_to_device(tier, &CALM.replace(from, to))
        };
        for seconds in [0.0, 0.71, 2.1] {
            let expected = at(&mut renderer, &mut on_cpu, seconds);
            let found = at(&mut renderer, &mut on_device, seconds);
            assert!(on_device.particles.len() == 200 && on_cpu.particles.len() > 600);
            for (a, b) in found.maps.iter().zip(&expected.maps) {
                let (a, b) = (&a.view, &b.view);
                assert!((a.far - b.far).abs() < 1e-3 && (a.scale / b.scale - 1.0).abs() < 1e-4);
            }
            let off = shares_off(&found, &expected);
            assert!(off.iter().all(|&share| share <= MAX), "{tier}, {seconds} s: {off:?}");
            let (a, b) = (&found.counters, &expected.counters);
            assert_eq!((a.casters, &a.skipped), (b.casters, &b.skipped), "{tier}, {seconds} s");
            let pairs = [(a.visible, b.visible), (a.pairs, b.pairs), (a.scattered, b.scattered)];
            assert!(seconds == 0.0 || (b.scattered > 0) == (tier == Tier::Native), "{b:?}");
            for (a, b) in pairs {
                assert!(a.abs_diff(b) <= 3 + b / 200, "{tier}, {seconds} s: {a} {b}");
            }
            assert!(found.stages.iter().any(|(name, _)| *name == "simulate"));
            assert!(expected.stages.iter().all(|(name, _)| *name != "simulate"));
        }
        let expected = at(&mut renderer, &mut on_cpu, 0.71);
        for (from, to, place) in [
            ("buoyancy = 1\n", "buoyancy = 0.875\n", 0),
            ("wind = [0.6, 0, 0]", "wind = [0.525, 0, 0]", 0),
            ("[0.2, 0.5, 0.2, 0]", "[0.2, 0.5, 0.175, 0]", 0),
            ("gravity = 6", "gravity = 5.25", 1),
            ("stop = 0.3", "stop = 0", 1),
            ("[0.05, 0.01]", "[0.05, 0.02]", 2),
        ] {
            let off = shares_off(&at(&mut renderer, &mut wrong(from, to), 0.71), &expected);
            assert!(off[place] > MAX, "{tier}, {to}: {off:?}");
        }
    }
}

#[test]
#[ignore = "many frames on both tiers: make test-all"]
fn a_frame_alone_is_that_of_the_sequence() {
    let moments = [0.0, 1.0 / 24.0, 0.52, 0.7, 2.3, 6.0];
    for (tier, receiver) in [(TIERS[0], "curve"), (TIERS[1], "nearest")] {
        let scene = || {
            let mut scene = staged(tier, WILD);
            if receiver == "curve" {
                scene.shadow.receiver = gobo::model::Receiver::Curve;
            }
            assert_eq!(scene.simulate_on_device(1 << 20), [""; 0]);
            scene
        };
        let new = || new_renderer(tier);
        let (mut renderer, mut in_turn) = (new(), scene());
        let all = moments.map(|seconds| at(&mut renderer, &mut in_turn, seconds));
        for (seconds, expected) in moments.into_iter().zip(&all) {
            let alone = at(&mut new(), &mut scene(), seconds);
            assert_same(&alone, expected, &format!("{tier}, {seconds} s alone"));
            let back = at(&mut renderer, &mut in_turn, seconds);
            assert_same(&back, expected, &format!("{tier}, {seconds} s, back from later"));
            // Nothing has moved: the maps are kept.
            let again = at(&mut renderer, &mut in_turn, seconds);
            assert_same(&again, expected, &format!("{tier}, {seconds} s again"));
            assert_eq!((again.counters.views_kept, again.counters.views_rendered), (2, 0));
        }
        let casters = all.each_ref().map(|frame| frame.counters.casters);
        assert!(casters[3] > 450 && casters[3] > casters[5], "{casters:?}");
        assert!(shares_off(&all[2], &all[3])[0] > 0.02);
    }
}

/// A scene of emitters alone, from before its first particle until after its last.
#[test]
fn an_emitter_may_have_sent_out_nothing() {
    let emitter = "[[material]]\nname = 'm'\n[[emitter]]\nmaterial = 'm'\nrate = 90\nlifetime = 0.5\n\
        start = 1\nstop = 2\n";
    let text = format!("[camera]\nsize = [16, 16]\n[shadow]\nsize = 32\n{emitter}");
    let mut renderer = Renderer::on(gpu(TIERS[0])).unwrap();
    for (seconds, least) in [(0.5, 0), (1.5, 43), (3.0, 0)] {
        let [on_cpu, on_device] = [false, true].map(|leaves| {
            let mut scene = read(&text).unwrap();
            if leaves {
                assert!(scene.simulate_on_device(1 << 20).is_empty());
            }
            at(&mut renderer, &mut scene, seconds)
        });
        assert_eq!(on_device.counters.casters, on_cpu.counters.casters);
        assert!((least..=least + 2).contains(&on_device.counters.casters), "{seconds}");
        assert!(shares_off(&on_device, &on_cpu).iter().all(|&share| share < 0.005), "{seconds}");
    }
}

/// Particles that have ended, or have not begun, do not count as left out.
#[test]
fn particles_that_fly_too_far_are_counted_on_the_device() {
    let emitter = "[[emitter]]\nmaterial = 'm'\nrate = 60\nlifetime = 3\nvelocity = [6.1e6, 0, 0]\n\
        extent = [0, 0, 0]\n";
    let text = format!(
        "[camera]\neye = [0, 1, 9]\ntarget = [0, 0, 0]\nsize = [16, 16]\n[shadow]\nsize = 32\n\
         [[material]]\nname = 'm'\n{emitter}"
    );
    let far = "particle moved too far";
    let mut renderer = Renderer::on(gpu(TIERS[0])).unwrap();
    let mut scenes = [read(&text).unwrap(), read(&text).unwrap()];
    assert!(scenes[1].simulate_on_device(1 << 20).is_empty());
    for seconds in [0.5, 2.5, 2.5, 7.0, 0.5] {
        let [on_cpu, on_device] = scenes.each_mut().map(|scene| {
            let skipped = at(&mut renderer, scene, seconds).counters.skipped;
            skipped.get(far).copied().unwrap_or_default()
        });
        assert_eq!(on_device, on_cpu, "{seconds} s");
        assert_eq!(on_device > 40, seconds > 1.0, "{on_device} at {seconds} s");
    }
}

#[test]
fn what_a_device_cannot_simulate_stays_on_the_cpu() {
    let fluid = CALM.replace("seed = 4", "seed = 4\nfluid = { spacing = 0.1 }");
    let (mut mixed, mut on_cpu) = (staged(TIERS[0], &fluid), staged(TIERS[0], &fluid));
    let reasons = mixed.simulate_on_device(1 << 20);
    assert_eq!(reasons.len(), 1);
    assert!(reasons[0].contains("emitter 1") && reasons[0].contains("fluid"), "{reasons:?}");
    let mut renderer = Renderer::on(gpu(TIERS[0])).unwrap();
    let [found, expected] = [&mut mixed, &mut on_cpu].map(|scene| at(&mut renderer, scene, 0.5));
    assert!(mixed.emissions.len() == 3 && mixed.particles.len() > 250);
    assert!(shares_off(&found, &expected).iter().all(|&share| share < 0.005));
    assert_eq!(found.counters.casters, expected.counters.casters);
    // 120 particles that live for 2 s.
    let reasons = staged(TIERS[0], CALM).simulate_on_device(130);
    assert_eq!(reasons.len(), 3, "{reasons:?}");
    assert!(reasons[1].contains("buffer"), "{reasons:?}");
    let rows: Vec<_> = (0..40).map(|i| format!("[{}, 0, 0, 0]", f64::from(i) * 1e-4)).collect();
    let crowded = CALM.replace("seed = 6", &format!("path = [{}]", rows.join(", ")));
    let reasons = staged(TIERS[0], &crowded).simulate_on_device(1 << 20);
    assert!(reasons.len() == 1 && reasons[0].contains("rows"), "{reasons:?}");
}

#[test]
fn without_a_device_nothing_is_left_to_it() {
    let mut scene = left_to_device(TIERS[0], CALM);
    scene.set_time(0.5);
    let mut cpu = Renderer::on_cpu();
    assert!(cpu.most_simulated().is_none());
    let error = cpu.render(&scene, &OPTIONS).unwrap_err().to_string();
    assert!(error.contains("device"), "{error}");
    assert!(cpu.light_points(&scene, &[]).is_err());
}

/// A device's allocations do not grow with the frames.
#[test]
fn a_sequence_allocates_no_more_than_its_first_frames() {
    let gpu = own_gpu(TIERS[0]);
    let mut renderer = Renderer::on(gpu).unwrap();
    let mut scene = left_to_device(TIERS[0], CALM);
    let mut bytes = [24, 25, 90].map(|frame| {
        let frame = at(&mut renderer, &mut scene, f64::from(frame) / 24.0);
        let emitted = |name: &str| {
            frame.memory.iter().filter(|own| own.0 == name).map(|own| own.1).sum::<u64>()
        };
        [emitted("emitted"), emitted("emitted_groups"), emitted("casters")]
    });
    bytes.sort_unstable();
    assert_eq!(bytes[0], bytes[2]);
    assert!(bytes[0][0] >= 800 * 32, "{bytes:?}");
}
