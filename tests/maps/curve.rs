//! Transmittance curves.
use crate::{
    common::{
        map_frame, map_frame_scattered,
        scenes::{Chance, empty, light, material, random_discs, triangle},
    },
    curves::{Method, Rays, Sample},
    moments::Moments,
    rivals::{Fourier, Hit, exact},
};
use gobo::{
    glam::{Vec3, Vec4},
    internals::{
        gpu::Tier,
        records::ViewMaps,
        reference::{
            self,
            curve::{DEPTHS, MAX_NODES, Streaming, light_at},
        },
        view::shadow_views,
    },
    model::{LightKind, Material, Profile, Receiver, ShadowSettings, Shape, Transfer, Triangle},
    scene::{self, Scene},
};
use std::path::Path;

/// Rounding of a stored depth and of a stored channel.
const DEPTH_ROUNDING: f32 = 0.5 / 65535.0;
pub(super) const LIGHT_ROUNDING: f32 = 0.5 / 4095.0 + 1.0 / 65535.0;

fn random_hits(count: usize, seed: u64) -> Vec<Hit> {
    let mut chance = Chance::new(seed);
    (0..count).map(|_| (chance.within(0.001, 0.999), chance.vec3(0.3, 1.0))).collect()
}

fn streamed(hits: &[Hit], nodes: u32) -> Vec<[u32; 2]> {
    let mut curve = Streaming::new(nodes, false);
    for &(depth, light) in hits {
        curve.insert(depth, depth, light);
    }
    curve.pack().collect()
}

/// Largest difference of a channel; light under 1/1024 is stored as 0.
fn apart(packed: &[[u32; 2]], hits: &[Hit], z: f32) -> f32 {
    let (is, should) = (light_at(packed, z, false), exact(hits, z));
    let channel = |i: usize| {
        let black = is[i] == 0.0 && should[i] < reference::resolve::BLACK + LIGHT_ROUNDING;
        if black { 0.0 } else { (is[i] - should[i]).abs() }
    };
    (0..3).map(channel).fold(0.0, f32::max)
}

/// Depths that no rounding of a hit's depth reaches.
fn clear_depths(hits: &[Hit]) -> impl Iterator<Item = f32> {
    let near = |z: f32| hits.iter().any(|hit| (hit.0 - z).abs() <= 2.0 * DEPTH_ROUNDING);
    (0..997).map(|i| (i as f32 + 0.5) / 997.0).filter(move |&z| !near(z))
}

#[test]
fn curves_beat_what_others_store() {
    for rays in Rays::ALL {
        let sample = Sample::new(rays);
        let (fourier, moments) = (sample.error(Method::Fourier), sample.error(Method::Moments));
        let share = match rays {
            Rays::Smoke => 0.7,
            Rays::Panes => 0.01,
            Rays::Puffs => 0.25,
        };
        for method in [Method::Curve(8), Method::Slabs(8)] {
            let error = sample.error(method);
            let (mean, high) = (error.mean, error.high);
            assert!(high < fourier.high, "{rays:?} {method:?}: {high} {fourier:?}");
            assert!(mean <= share * fourier.mean, "{rays:?} {method:?}: {mean} {fourier:?}");
            assert!(mean <= 0.25 * moments.mean, "{rays:?} {method:?}: {mean} {moments:?}");
        }
        // More nodes are better, and none are exact: the comparison can fail.
        let of = |nodes| sample.error(Method::Curve(nodes)).mean;
        assert!(of(16) < of(8) && of(8) < of(4), "{rays:?}");
        assert!(sample.error(Method::Nearest).mean > 2.0 * fourier.mean, "{rays:?}");
    }
}

/// The competing methods are implemented correctly: they are exact where their papers say so.
#[test]
fn rivals_are_honest() {
    let hits = random_hits(6, 3);
    let fourier = Fourier::new(&hits);
    // The integral over the whole range is the constant coefficient's.
    assert!((fourier.light_at(1.0) - exact(&hits, 1.0)).abs().max_element() < 1e-4);
    // Four moments bound a single step from both sides: 0 before it, all of it behind.
    let single = [(0.5, Vec3::splat(0.25))];
    let moments = Moments::new(&single, 4);
    assert!((moments.light_at(0.2) - Vec3::ONE).abs().max_element() < 0.01);
    assert!((moments.light_at(0.8) - Vec3::splat(0.25)).abs().max_element() < 0.01);
}

#[test]
fn exact_while_at_most_k_hits_in_any_order() {
    for nodes in [4, 8, 16] {
        for seed in 0..20 {
            let hits = random_hits(nodes as usize, seed);
            let packed = streamed(&hits, nodes);
            for z in clear_depths(&hits) {
                let apart = apart(&packed, &hits, z);
                assert!(apart <= LIGHT_ROUNDING, "{nodes} {seed} {z}: {apart}");
            }
        }
        // One hit more is not exact: the check can fail.
        let hits = random_hits(nodes as usize + 1, 7);
        let packed = streamed(&hits, nodes);
        assert!(clear_depths(&hits).any(|z| apart(&packed, &hits, z) > LIGHT_ROUNDING), "{nodes}");
    }
}

/// For any merges, the error is at most the light lost in one node.
#[test]
fn the_bound_holds() {
    for (count, seed) in [(9, 1), (12, 2), (30, 3), (100, 4), (300, 5)] {
        let mut hits = random_hits(count, seed);
        for hit in &mut hits {
            hit.1 = hit.1.powf(8.0 / count as f32);
        }
        hits.sort_by(|a, b| a.0.total_cmp(&b.0));
        for nodes in [4, 8, MAX_NODES as u32] {
            let packed = streamed(&hits, nodes);
            // Light behind the last of the first i nodes.
            let behind = |i: usize| light_at(&packed[..i], 2.0, false);
            let loss = |i: usize| (behind(i) - behind(i + 1)).max_element();
            let bound = (0..packed.len()).map(loss).fold(0.0, f32::max);
            let worst = clear_depths(&hits).map(|z| apart(&packed, &hits, z)).fold(0.0, f32::max);
            assert!(worst <= bound + 2.0 * LIGHT_ROUNDING, "{count} {nodes}: {worst} > {bound}");
            assert!(worst > 0.0);
        }
    }
}

/// Steps and ramps that overlap, some of them late: at each depth the error is at most the light lost in the node there
/// and in the next.
#[test]
fn the_bound_holds_where_ramps_overlap() {
    let mut chance = Chance::new(31);
    let (mut depths, mut past_one) = (0, 0);
    for ray in 0..320 {
        let count = 9 + chance.below(120);
        let mut ramps: Vec<_> = (0..count)
            .map(|i| {
                let start = chance.within(0.001, 0.95);
                let length = [0.0, chance.within(0.0, 0.004), chance.within(0.0, 0.2)][i % 3];
                let light = chance.vec3(0.2, 1.0).powf(8.0 / count as f32);
                (start, (start + length).min(0.999), light)
            })
            .collect();
        let late = [0.0, 0.002, 0.05][ray % 3];
        let mut order: Vec<_> =
            (0..count).map(|i| (ramps[i].0 + chance.within(0.0, late), i)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        ramps = order.into_iter().map(|(_, i)| ramps[i]).collect();
        let nodes = [4, 8, 16][ray % 3];
        let mut curve = Streaming::new(nodes, false);
        ramps.iter().for_each(|&(start, end, light)| curve.insert(start, end, light));
        let packed: Vec<_> = curve.pack().collect();
        let behind = |i: usize| light_at(&packed[..i], 2.0, false);
        let loss = |i: usize| (behind(i) - behind((i + 1).min(packed.len()))).max_element();
        for z in (0..997).map(|i| (i as f32 + 0.5) / 997.0) {
            if ramps.iter().any(|&(start, ..)| (z - start).abs() <= 2.0 * DEPTH_ROUNDING) {
                continue;
            }
            let exact: Vec3 = ramps
                .iter()
                .map(|&(start, end, light)| {
                    let share = ((z - start) / (end - start).max(1e-9)).clamp(0.0, 1.0);
                    Vec3::ONE.lerp(light, share)
                })
                .product();
            let worst = (light_at(&packed, z, false) - exact).abs().max_element();
            // The node in or behind whose start the depth is, and the next; unused ones come first.
            let begun = |node: &[u32; 2]| ((node[0] >> 16) as f32) < z * DEPTHS;
            let next = packed.iter().take_while(|node| begun(node)).count();
            let around = [next.checked_sub(1).map_or(0.0, loss), loss(next)];
            depths += 1;
            past_one += usize::from(worst > around[0].max(around[1]) + 2.0 * LIGHT_ROUNDING);
            let both = around[0] + around[1];
            assert!(worst <= both + 2.0 * LIGHT_ROUNDING, "ray {ray}, {z}: {worst} > {both}");
        }
    }
    println!("{past_one} of {depths} depths are off by more than the light lost in one node");
    assert!(past_one > 0, "one node bounds them all: the page says too much");
}

#[test]
fn light_never_grows_with_depth() {
    let mut hits = random_hits(200, 9);
    hits.iter_mut().for_each(|hit| hit.1 = hit.1.powf(0.05));
    let packed = streamed(&hits, 8);
    let mut before = Vec3::ONE;
    for i in 0..=2000 {
        let light = light_at(&packed, i as f32 / 2000.0, false);
        assert!(light.cmple(before + 1e-6).all(), "{i}");
        before = light;
    }
}

#[test]
fn a_curve_may_brighten() {
    let hits = [(0.2, Vec3::splat(4.0)), (0.5, Vec3::new(0.5, 2.0, 1.0)), (0.7, Vec3::splat(0.1))];
    let mut curve = Streaming::new(4, true);
    for (depth, light) in hits {
        curve.insert(depth, depth, light);
    }
    let packed: Vec<_> = curve.pack().collect();
    for z in [0.1, 0.3, 0.6, 0.9] {
        let (is, should) = (light_at(&packed, z, true), exact(&hits, z));
        // 20 octaves in 4,095 steps.
        assert!(((is - should) / should).abs().max_element() < 0.003, "{z}: {is} {should}");
    }
}

pub(crate) fn curved(scene: Scene, nodes: u32) -> Scene {
    let shadow = ShadowSettings { receiver: Receiver::Curve, nodes, ..scene.shadow };
    Scene { shadow, ..scene }
}

/// Discs of all sizes, a plain sort, under a directional light and a spot.
pub(crate) fn discs(nodes: u32) -> Scene {
    let mut scene = empty(vec![material(Transfer::Filter)]);
    let position = Vec3::new(3.0, 4.0, 2.5);
    scene.lights = vec![
        light(LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() }),
        light(LightKind::Spot { position, direction: -position.normalize(), angle: 0.9 }),
    ];
    scene.particles = random_discs(3000, 5);
    for particle in &mut scene.particles {
        particle.color.w *= 0.3;
    }
    curved(scene, nodes)
}

/// Share of the texels whose curves differ by more than rounding at some depth.
pub(crate) fn share_apart(a: &[ViewMaps], b: &[ViewMaps]) -> f64 {
    let (mut apart, mut count) = (0, 0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a.curve.as_ref().unwrap(), b.curve.as_ref().unwrap());
        for texel in 0..a.packed.len() / a.nodes {
            let far = (0..50).any(|i| {
                let z = (i as f32 + 0.5) / 50.0;
                (a.light_at(texel, z) - b.light_at(texel, z)).abs().max_element() > 0.004
            });
            apart += usize::from(far);
            count += 1;
        }
    }
    apart as f64 / f64::from(count)
}

/// Share of the texels that may differ, because a ray grazes an edge, or two merges cost the same.
const GRAZED: f64 = 2e-3;

/// Casters of every kind, opaque ones too.
pub(crate) fn mixture() -> Scene {
    let like = |transfer, shape, profile| Material { shape, profile, ..material(transfer) };
    let mut scene = discs(8);
    scene.materials = vec![
        like(Transfer::Filter, Shape::Disc, Profile::Soft),
        like(Transfer::Smoke, Shape::Quad, Profile::Flat),
        like(Transfer::Filter, Shape::Puff, Profile::Soft),
        Material { tint: Vec4::new(0.3, 0.9, 0.5, 0.6), ..material(Transfer::Stain) },
        like(Transfer::Opaque, Shape::Disc, Profile::Flat),
    ];
    scene.particles.truncate(600);
    let mut chance = Chance::new(8);
    for particle in &mut scene.particles {
        particle.material = [0, 0, 1, 2, 4][chance.below(5)];
    }
    for id in 0..8 {
        let corners = [0; 3].map(|_| chance.vec3(-2.0, 2.0));
        scene.triangles.push(Triangle { id, ..triangle(corners, 3) });
    }
    scene
}

pub(crate) fn cpu(scene: &Scene) -> Vec<ViewMaps> {
    reference::render_maps(scene, &shadow_views(scene)).0
}

pub(crate) fn holds(tier: Tier, scene: &Scene, name: &str) {
    let expected = cpu(scene);
    let frame = map_frame(tier, scene);
    let apart = share_apart(&frame.maps, &expected);
    assert!(apart <= GRAZED, "{name} {tier:?}: {apart}");
    for (map, expected) in frame.maps.iter().zip(&expected) {
        let pairs = map.filter.iter().zip(&expected.filter);
        let far = pairs.filter(|(a, b)| (0..3).any(|i| (a[i] - b[i]).abs() > 0.004)).count();
        assert!(far as f64 <= GRAZED * map.filter.len() as f64, "{name} {tier:?}: F {far}");
        assert_eq!(map.nearest.len(), expected.nearest.len());
    }
}

#[test]
fn gpu_matches_reference() {
    holds(Tier::Native, &discs(8), "8 nodes");
    holds(Tier::Native, &discs(16), "16 nodes");
    holds(Tier::Core, &discs(4), "4 nodes");
    // The comparison can fail, and there is something to compare.
    let (four, eight) = (cpu(&discs(4)), cpu(&discs(8)));
    assert!(share_apart(&four, &eight) > 0.05);
}

#[test]
fn gpu_matches_reference_of_every_kind() {
    holds(Tier::Core, &mixture(), "mixture");
    let mut gain = mixture();
    gain.materials[1].transfer = Transfer::Gain;
    holds(Tier::Native, &gain, "gain");
}

/// A ground in front of all discs by its nearest corner, which is beside them: slabs are cut by the discs'
/// depths alone.
#[test]
fn slabs_do_not_depend_on_opaque_casters() {
    let mut scene = discs(8);
    scene.materials.push(material(Transfer::Opaque));
    let corner = |x: f32, z: f32| Vec3::new(x, -3.0, z);
    let corners = [corner(-30.0, -30.0), corner(40.0, -30.0), corner(0.0, 60.0)];
    scene.triangles.push(triangle(corners, 1));
    holds(Tier::Native, &scene, "over a ground");
    holds(Tier::Core, &scene, "over a ground");
}

/// Share of texels at the rim of a cloud, where few hits are inserted one by one, in the order of casters.
const FEW: f64 = 6e-3;

/// Discs in 16 planes of one depth each: slabs end between planes, whatever the order within them.
#[test]
fn slabs_do_not_depend_on_the_order_of_equal_depths() {
    let mut scene = discs(8);
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Y })];
    for particle in &mut scene.particles {
        particle.center.y = (particle.center.y * 4.0).round() / 4.0;
        // No texel has so few hits that they are inserted one by one.
        particle.radius = 0.45;
        particle.color.w = 0.1;
    }
    let mut mixed = scene.clone();
    let mut chance = Chance::new(3);
    for i in (1..mixed.particles.len()).rev() {
        mixed.particles.swap(i, chance.below(i + 1));
    }
    let expected = cpu(&scene);
    let near = |maps: &[ViewMaps], name: &str| {
        let apart = share_apart(maps, &expected);
        assert!(apart <= FEW, "{name}: {apart}");
    };
    near(&cpu(&mixed), "cpu of another order");
    near(&map_frame(Tier::Native, &scene).maps, "native");
    near(&map_frame(Tier::Core, &mixed).maps, "core, of another order");
}

/// A cloud of overlapping puffs, whose ramps are merged at every hit: they ascend, and so light never grows.
#[test]
fn ramps_of_overlapping_puffs_ascend() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/issues/oloengine-723.toml");
    let scene = scene::load(&path).unwrap();
    let expected = cpu(&scene);
    for (name, maps) in [
        ("cpu", &expected),
        ("native", &map_frame(Tier::Native, &scene).maps),
        ("core", &map_frame(Tier::Core, &scene).maps),
    ] {
        let curve = maps[0].curve.as_ref().unwrap();
        let mut full = 0;
        for texel in 0..curve.texel_count() {
            let (mut last, mut light, mut count) = (0.0, Vec3::ONE, 0);
            for (start, _, behind) in curve.ramps(texel) {
                assert!(start >= last, "{name}, texel {texel}: {start} behind {last}");
                let grows = (behind - light).max_element();
                assert!(grows <= LIGHT_ROUNDING, "{name}, texel {texel}: light grows by {grows}");
                (last, light, count) = (start, behind, count + 1);
            }
            full += usize::from(count == curve.nodes);
        }
        assert!(full > 1000, "{name}: {full} texels whose hits are merged");
        // Puffs of equal depth are merged in another order.
        let apart = share_apart(maps, &expected);
        assert!(apart <= 2.0 * GRAZED, "{name}: {apart}");
    }
}

#[test]
fn scattered_casters_go_behind() {
    let mut scene = discs(8);
    scene.shadow.pair_budget = 3000;
    let frame = map_frame_scattered(Tier::Native, &scene);
    assert!(frame.counters.overflowed > 0, "{:?}", frame.counters);
    let whole = map_frame(Tier::Native, &discs(8));
    for (few, whole) in frame.maps.iter().zip(&whole.maps) {
        for texel in 0..few.filter.len() {
            let apart = (0..3).map(|i| (few.filter[texel][i] - whole.filter[texel][i]).abs());
            assert!(apart.fold(0.0, f32::max) < 0.003, "light is lost at {texel}");
        }
    }
}

/// The page has the measured figures.
#[test]
fn the_page_is_in_step() {
    let page = include_str!("../../docs/curves.md");
    let samples = Rays::ALL.map(Sample::new);
    for method in Method::ALL {
        let start = format!("| {} | {} |", method.name(), method.bytes());
        let line = page.lines().find(|line| line.starts_with(&start));
        let line = line.unwrap_or_else(|| panic!("no line {start}: run make quality"));
        let cells: Vec<f32> = line.split('|').filter_map(|cell| cell.trim().parse().ok()).collect();
        for (i, sample) in samples.iter().enumerate() {
            let (error, stated) = (sample.error(method), &cells[1 + 3 * i..]);
            // Elementary functions differ in their last bits between platforms.
            assert!((error.mean - stated[0]).abs() <= 2e-5 + 0.01 * stated[0], "{line}");
            assert!((error.max - stated[1]).abs() <= 0.011, "{line}");
        }
    }
}
