//! The kernels against the CPU reference, and properties of a whole frame on the GPU.
use crate::common::{
    TIERS, gpu, map_frame, map_frame_tiny,
    rounding::{MIXED, on},
    scenes::{Chance, empty, light, material, particle, random_discs, triangle},
    tiers,
};
use gobo::{
    glam::{Vec3, Vec4},
    gpu::Tier,
    model::{LightKind, Material, Profile, Receiver, Shape, Transfer},
    records::ViewMaps,
    stage::bin::tile_grid,
    view::shadow_views,
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_reference as reference;
use gobo_scene::Scene;

/// `F` is stored in 16 bits; CPU reference and kernel may round to neighbours, and sums in fixed point add as
/// much again.
const FILTER: f32 = 1.0 / 512.0;
/// Light depths are `f32`; a few operations separate CPU reference and kernel.
const DEPTH: f32 = 2e-6;
/// Share of texels that differ by more than rounding.
fn share_apart(a: &[ViewMaps], b: &[ViewMaps]) -> f64 {
    assert_eq!(a.len(), b.len());
    let (mut apart, mut texels) = (0, 0);
    for (a, b) in a.iter().zip(b) {
        assert_eq!(a.filter.len(), b.filter.len());
        texels += a.filter.len();
        apart += (0..a.filter.len())
            .filter(|&i| {
                let near = |a: f32, b: f32, tolerance: f32| (a - b).abs() <= tolerance;
                !((0..3).all(|c| near(a.filter[i][c], b.filter[i][c], FILTER))
                    && near(a.nearest[i], b.nearest[i], DEPTH)
                    && near(a.opaque[i], b.opaque[i], DEPTH))
            })
            .count();
    }
    apart as f64 / texels as f64
}

fn largest_apart(a: &[ViewMaps], b: &[ViewMaps]) -> f32 {
    let channels = |maps: &[ViewMaps]| -> Vec<f32> {
        maps.iter().flat_map(|view| view.filter.iter().flatten().copied()).collect()
    };
    let (a, b) = (channels(a), channels(b));
    a.iter().zip(&b).fold(0.0, |largest, (a, b)| largest.max((a - b).abs()))
}

fn cpu(scene: &Scene) -> (Vec<ViewMaps>, gobo::model::Counters) {
    reference::render_maps(scene, &shadow_views(scene))
}

pub(super) fn lights() -> Vec<gobo::model::Light> {
    let position = Vec3::new(3.0, 4.0, 2.5);
    vec![
        light(LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() }),
        light(LightKind::Spot { position, direction: -position.normalize(), angle: 0.9 }),
        light(LightKind::Point { position: Vec3::new(0.1, 0.2, -0.1) }),
    ]
}

fn materials() -> Vec<Material> {
    let shaped = |transfer, shape, profile| Material { shape, profile, ..material(transfer) };
    vec![
        shaped(Transfer::Filter, Shape::Disc, Profile::Soft),
        shaped(Transfer::Stain, Shape::Quad, Profile::Flat),
        shaped(Transfer::Smoke, Shape::Disc, Profile::Flat),
        shaped(Transfer::Filter, Shape::Puff, Profile::Soft),
        shaped(Transfer::None, Shape::Disc, Profile::Soft),
        shaped(Transfer::Opaque, Shape::Disc, Profile::Flat),
        Material { tint: Vec4::new(0.2, 0.7, 0.9, 0.8), ..material(Transfer::Filter) },
        Material { reflectivity: 0.4, ..material(Transfer::Stain) },
    ]
}

/// Particles of every shape, many materials; `count` of them.
fn mixture(count: usize) -> Scene {
    let mut chance = Chance::new(count as u64);
    let mut scene = empty(materials());
    scene.lights = lights();
    scene.particles = random_discs(count, 3);
    for particle in &mut scene.particles {
        particle.material = [0, 0, 0, 1, 2, 3, 4, 7][chance.below(8)];
        particle.radius *= 0.5;
        if chance.below(20) == 0 {
            particle.material = 5;
        }
    }
    for i in 0..12 {
        let positions = [0; 3].map(|_| chance.vec3(-2.0, 2.0));
        scene.triangles.push(triangle(positions, 5 + u32::from(i % 3 != 0)));
    }
    scene
}

fn assert_matches_reference(scene: &Scene) {
    let (expected, counted) = cpu(scene);
    for tier in TIERS {
        let frame = map_frame(tier, scene);
        let apart = share_apart(&frame.maps, &expected);
        assert!(apart <= on(&gpu(tier), MIXED), "{tier:?}: {apart} of the texels");
        let near = |a: u64, b: u64| a.abs_diff(b) <= b / 1000;
        let counters = &frame.counters;
        assert!(near(counters.visible, counted.visible), "{tier:?} {counters:?} {counted:?}");
        // The reference does not scatter; a tiny particle touches up to four tiles.
        let pairs = counted.pairs.clamp(counters.pairs, counters.pairs + 4 * counters.scattered);
        assert!(near(pairs, counted.pairs), "{tier:?} {counters:?} {counted:?}");
    }
}

#[test]
fn gpu_matches_reference_at_awkward_counts() {
    for count in [0, 1, 63, 64, 65, 1000] {
        assert_matches_reference(&mixture(count));
    }
}

#[test]
fn gpu_matches_reference_with_plain_discs() {
    let mut scene = empty(vec![material(Transfer::Filter)]);
    scene.lights = lights();
    scene.particles = random_discs(1000, 5);
    assert_matches_reference(&scene);
    scene.shadow.size = 80; // no whole number of 32s
    assert_matches_reference(&scene);
}

/// Walks for GPUs, whose loops visit both kinds, and for software adapters.
#[test]
#[ignore = "each kernel twice: make test-all"]
fn loops_for_each_kind_change_no_bit() {
    let mut scene = mixture(600);
    for tier in TIERS {
        let mut renderer = Renderer::on(gpu(tier)).unwrap();
        for receiver in [Receiver::Nearest, Receiver::Curve] {
            scene.shadow.receiver = receiver;
            let mut maps = |apart| {
                renderer.configure(|config| config.tuning.kinds_apart = apart);
                let options =
                    RenderOptions { maps: true, maps_only: true, ..RenderOptions::default() };
                renderer.render(&scene, &options).unwrap_or_else(|error| panic!("{error}")).maps
            };
            for (a, b) in maps(true).iter().zip(&maps(false)) {
                let same = a.filter == b.filter && a.nearest == b.nearest && a.opaque == b.opaque;
                assert!(same && a.curve == b.curve, "{tier:?}, {receiver:?}");
            }
        }
    }
}

#[test]
fn gpu_matches_reference_with_many_casters() {
    let mut scene = empty(vec![material(Transfer::Filter)]);
    scene.lights = lights()[..1].to_vec();
    scene.shadow.size = 256;
    scene.particles = random_discs(100_003, 9);
    for particle in &mut scene.particles {
        particle.radius *= 0.2;
        particle.color.w *= 0.02;
    }
    assert_matches_reference(&scene);
}

#[test]
fn a_missing_caster_is_noticed() {
    let scene = mixture(1000);
    let mut fewer = scene.clone();
    let large = |p: &gobo::model::Particle| p.material == 0 && p.radius > 0.1 && p.color.w > 0.1;
    fewer.particles.remove(scene.particles.iter().position(large).expect("a large disc"));
    let frame = map_frame(Tier::Native, &fewer);
    assert!(share_apart(&frame.maps, &cpu(&scene).0) > on(&gpu(Tier::Native), MIXED));
}

#[test]
fn frames_are_bit_identical() {
    let scene = mixture(1000);
    for tier in TIERS {
        let (a, b) = (map_frame(tier, &scene), map_frame(tier, &scene));
        for (a, b) in a.maps.iter().zip(&b.maps) {
            assert!(a.filter == b.filter && a.nearest == b.nearest && a.opaque == b.opaque);
        }
    }
}

#[test]
fn order_of_the_casters_hardly_matters() {
    let scene = mixture(1000);
    let mut shuffled = scene.clone();
    Chance::new(1).shuffle(&mut shuffled.particles);
    for tier in tiers(Tier::Core) {
        let apart = largest_apart(&map_frame(tier, &scene).maps, &map_frame(tier, &shuffled).maps);
        assert!(apart <= 1.0 / 1024.0, "{tier:?} {apart}");
    }
}

#[test]
fn overflow_costs_no_light() {
    let mut scene = mixture(1000);
    let whole = map_frame(Tier::Native, &scene);
    assert_eq!(whole.counters.overflowed, 0);
    scene.shadow.pair_budget = 500;
    for tier in tiers(Tier::Core) {
        let scattered = map_frame(tier, &scene);
        assert!(scattered.counters.overflowed > 0);
        let apart = largest_apart(&whole.maps, &scattered.maps);
        assert!(apart <= 1.0 / 1024.0, "{tier:?} {apart}");
        let depths = |maps: &[ViewMaps]| -> Vec<Vec<f32>> {
            maps.iter().map(|view| view.opaque.clone()).collect()
        };
        assert_eq!(depths(&whole.maps), depths(&scattered.maps));
    }
}

/// 10,000 discs, alone and with 400 panes, with room for nine tenths of their pairs: the rest is counted, and
/// loses no light.
#[test]
fn pairs_past_a_small_budget_are_counted_and_scattered() {
    let mut scene = empty(materials());
    scene.lights = lights()[..1].to_vec(); // one view, one batch
    scene.shadow.size = 128;
    scene.particles = random_discs(10_000, 21);
    for particle in &mut scene.particles {
        particle.radius = 0.12 + 0.1 * particle.radius; // none is tiny
        particle.color.w *= 0.05;
    }
    let discs = scene.clone();
    let mut chance = Chance::new(22);
    for _ in 0..400 {
        let first = chance.vec3(-2.0, 2.0);
        let corners = [Vec3::ZERO, chance.vec3(-0.3, 0.3), chance.vec3(-0.3, 0.3)];
        scene.triangles.push(triangle(corners.map(|corner| first + corner), 6));
    }
    let cases = [("discs", discs, &TIERS[1..]), ("discs and panes", scene, &TIERS)];
    for (name, scene, tiers) in cases {
        let mut tight = scene.clone();
        let mut expected = None;
        for &tier in tiers {
            let whole = map_frame(tier, &scene);
            let all = &whole.counters;
            assert_eq!((all.scattered, all.overflowed), (0, 0), "{name}, {tier:?}");
            tight.shadow.pair_budget = (all.pairs / 10 * 9) as u32;
            let frame = map_frame(tier, &tight);
            let counters = &frame.counters;
            let message = format!("{name}, {tier:?}: {counters:?}");
            let counted = expected.get_or_insert_with(|| cpu(&tight).1);
            assert!(counters.pairs <= u64::from(tight.shadow.pair_budget), "{message}");
            // Casters of equal depth may come in either order.
            assert!(counters.overflowed.abs_diff(counted.overflowed) <= 3, "{message} {counted:?}");
            assert!(counters.overflowed > all.visible / 16, "{message}");
            assert_eq!(counters.scattered, counters.overflowed, "{message}");
            assert_eq!(counters.visible, all.visible, "{message}");
            let apart = largest_apart(&whole.maps, &frame.maps);
            assert!(apart <= 1.0 / 1024.0, "{name}, {tier:?}: {apart}");
            assert!(frame.maps[0].nearest == whole.maps[0].nearest, "{name}, {tier:?}");
        }
    }
}

#[test]
fn tiny_particles_give_one_map_on_both_paths() {
    let mut scene = mixture(1000);
    for particle in &mut scene.particles {
        particle.radius *= 0.02;
    }
    for tier in tiers(Tier::Core) {
        let scattered = map_frame_tiny(tier, &scene, true);
        let tiled = map_frame_tiny(tier, &scene, false);
        assert!(scattered.counters.scattered > 1000, "{:?}", scattered.counters);
        assert_eq!(tiled.counters.scattered, 0);
        let apart = largest_apart(&scattered.maps, &tiled.maps);
        assert!(apart <= 1.0 / 1024.0, "{tier:?} {apart}");
    }
}

/// `count` discs, one behind another, within one tile.
fn stack(count: usize, alpha: f32) -> Scene {
    let mut scene = empty(vec![material(Transfer::Filter)]);
    scene.lights = lights()[..1].to_vec();
    let forward = Vec3::new(-0.4, -1.0, -0.3).normalize();
    // Beside the map's middle, a corner of four texels, where an enlarged disc would end at their centres.
    let aside = Vec3::new(0.05, 0.0, 0.03);
    scene.particles = (0..count)
        .map(|i| {
            let depth = i as f32 / count as f32 * 4.0 - 2.0;
            particle(aside + forward * depth, 0.25, Vec4::new(0.2, 0.5, 0.8, alpha))
        })
        .collect();
    // Keeps the view larger than the stack.
    scene.particles.push(particle(Vec3::new(3.0, 0.0, -3.0), 0.1, Vec4::new(1.0, 1.0, 1.0, 0.1)));
    scene
}

/// llvmpipe stops all loops of an invocation after 65,535 iterations.
#[test]
#[ignore = "many casters: make test-all"]
fn a_hundred_thousand_casters_on_one_tile() {
    for alpha in [0.00005, 0.01] {
        let scene = stack(100_000, alpha);
        let (expected, _) = cpu(&scene);
        for tier in TIERS {
            let frame = map_frame(tier, &scene);
            let apart = share_apart(&frame.maps, &expected);
            assert!(apart <= on(&gpu(tier), MIXED), "{tier:?}, alpha {alpha}: {apart}");
        }
    }
}

/// By the scatter path with large texels, through tiles with small ones.
#[test]
#[ignore = "many casters: make test-all"]
fn a_million_casters_on_one_texel_saturate() {
    let mut scene = stack(1_000_000, 1.0);
    for (size, scatters) in [(16, true), (64, false)] {
        scene.shadow.size = size;
        let frame = map_frame(Tier::Native, &scene);
        assert_eq!(frame.counters.scattered >= 1_000_000, scatters, "{:?}", frame.counters);
        let maps = &frame.maps[0];
        assert!(maps.filter.iter().flatten().all(|f| (0.0..=1.0).contains(f)));
        let first = maps.nearest.iter().copied().fold(1.0, f32::min);
        let dark = maps.filter.iter().zip(&maps.nearest).filter(|(f, _)| **f == [0.0; 3]);
        let nearest = dark.map(|(_, &depth)| depth).fold(1.0, f32::min);
        assert!(nearest == first && first < 0.5, "{nearest} {first}");
    }
}

/// A map of 65,536 tiles, more than a dispatch has workgroups in a row: both halves are rendered.
#[test]
fn more_tiles_than_a_row_of_workgroups() {
    for count in [1, 4, 65_532, 65_536, 300 * 260] {
        let [x, y, z] = tile_grid(count);
        assert!(x <= 65_535 && x * y * z == count, "{count}: {x} {y} {z}");
    }
    let mut scene = empty(vec![material(Transfer::Filter)]);
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Z })];
    scene.shadow.size = 4096;
    for y in [-0.9, 0.9] {
        let disc = particle(Vec3::new(0.0, y, 0.0), 0.1, Vec4::new(0.5, 0.5, 0.5, 0.8));
        scene.particles.push(disc);
    }
    let map = map_frame(TIERS[1], &scene).maps.remove(0);
    let (top, bottom) = map.filter.split_at(map.filter.len() / 2);
    let filtered = |half: &[[f32; 3]]| half.iter().filter(|f| f[0] < 1.0).count();
    // A soft disc's rim is too faint for 16 bits.
    let whole = std::f32::consts::PI * (0.1 * map.view.scale).powi(2);
    for half in [top, bottom] {
        let share = filtered(half) as f32 / whole;
        assert!((0.9..1.01).contains(&share), "{share}");
    }
}
