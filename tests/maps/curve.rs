//! Transmittance curves.
use super::curve_bounds::LIGHT_ROUNDING;
use crate::{
    common::{
        map_frame, map_frame_scattered,
        scenes::{Chance, empty, light, material, random_discs, triangle},
    },
    curves::{Method, Rays, Sample},
};
use gobo::{
    glam::{Vec3, Vec4},
    gpu::Tier,
    model::{LightKind, Material, Profile, Receiver, ShadowSettings, Shape, Transfer, Triangle},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_reference as reference;
use gobo_scene as scene;
use gobo_scene::Scene;

pub(crate) fn curved(scene: Scene, nodes: u32) -> Scene {
    let shadow = ShadowSettings { receiver: Receiver::Curve, nodes, ..scene.shadow };
    Scene { shadow, ..scene }
}

/// Discs of all sizes, plainly sorted, under a directional light and a spot.
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

/// A ground whose nearest corner, beside the discs, is in front of them all: slabs are cut by the discs'
/// depths alone.
#[test]
fn discs_do_not_depend_on_opaque_casters() {
    let mut scene = discs(8);
    scene.materials.push(material(Transfer::Opaque));
    let corner = |x: f32, z: f32| Vec3::new(x, -3.0, z);
    let corners = [corner(-30.0, -30.0), corner(40.0, -30.0), corner(0.0, 60.0)];
    scene.triangles.push(triangle(corners, 1));
    holds(Tier::Native, &scene, "over a ground");
    holds(Tier::Core, &scene, "over a ground");
}

/// Share of texels whose nodes end elsewhere, because another hit of a plane comes first.
const FEW: f64 = 0.12;

/// Discs in 16 planes of one depth each: nodes end between planes, whatever the order in a plane.
#[test]
fn discs_do_not_depend_on_the_order_of_equal_depths() {
    let mut scene = discs(8);
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Y })];
    for particle in &mut scene.particles {
        particle.center.y = (particle.center.y * 4.0).round() / 4.0;
        // Each texel has too many hits to insert them one by one.
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

/// A cloud of overlapping puffs, whose ramps are merged at every hit: ramps ascend, so light never grows.
#[test]
fn ramps_of_overlapping_puffs_ascend() {
    let path = crate::common::root().join("data/issues/oloengine-723.toml");
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

fn are_same(a: &[ViewMaps], b: &[ViewMaps]) -> bool {
    let is_same = |(a, b): (&ViewMaps, &ViewMaps)| {
        a.filter == b.filter && a.nearest == b.nearest && a.curve == b.curve
    };
    a.len() == b.len() && a.iter().zip(b).all(is_same)
}

/// Maps with too few bytes for their nodes are those with fewer, or of nearest depth, and say so.
#[test]
fn curves_stay_within_their_budget() {
    let of = |nodes: u32| match nodes {
        0 => Scene {
            shadow: ShadowSettings { receiver: Receiver::Nearest, ..discs(8).shadow },
            ..discs(8)
        },
        _ => discs(nodes),
    };
    let texels: u64 =
        shadow_views(&discs(8)).iter().map(|view| u64::from(view.size.element_product())).sum();
    for (asked, given, curve_budget) in [
        (8, 8, 64 * texels),
        (8, 4, 64 * texels - 1),
        (16, 4, 32 * texels),
        (16, 0, 32 * texels - 1),
    ] {
        let mut scene = of(asked);
        scene.shadow.curve_budget = curve_budget;
        let (maps, counters) = reference::render_maps(&scene, &shadow_views(&scene));
        assert_eq!(counters.nodes_dropped, u64::from(asked - given), "cpu, {asked}");
        assert!(are_same(&maps, &cpu(&of(given))), "cpu, {asked}");
        for tier in [Tier::Native, Tier::Core] {
            let (frame, expected) = (map_frame(tier, &scene), map_frame(tier, &of(given)));
            assert!(are_same(&frame.maps, &expected.maps), "{tier:?}, {asked}");
            assert_eq!(frame.counters.nodes_dropped, u64::from(asked - given), "{tier:?}, {asked}");
            let bytes: u64 = frame.memory.iter().filter(|it| it.0 == "curves").map(|it| it.1).sum();
            // Without curves a texel is there for kernels that have a place for them.
            let expected = (8 * u64::from(given) * texels).max(16);
            assert!(
                bytes == expected && bytes <= curve_budget,
                "{tier:?}, {asked}: {bytes} for {expected}"
            );
        }
    }
}

/// The page has the measured figures.
#[test]
fn the_page_is_in_step() {
    let page = include_str!("../../docs/curves.md");
    let samples = Rays::ALL.map(Sample::new);
    let mut wrong = String::new();
    for method in Method::ALL {
        let start = format!("| {} | {} |", method.name(), method.bytes());
        let line = page.lines().find(|line| line.starts_with(&start));
        let line = line.unwrap_or_else(|| panic!("no line {start}: run make quality"));
        let cells: Vec<f32> = line.split('|').filter_map(|cell| cell.trim().parse().ok()).collect();
        for (i, sample) in samples.iter().enumerate() {
            let (error, stated) = (sample.error(method), &cells[1 + 3 * i..]);
            // Elementary functions differ in their last bits between platforms.
            let is_mean = (error.mean - stated[0]).abs() <= 2e-5 + 0.01 * stated[0];
            if !(is_mean && (error.max - stated[1]).abs() <= 0.011) {
                wrong += &format!("{line}\n{:.5}, {:.2} at place {i}\n", error.mean, error.max);
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}
