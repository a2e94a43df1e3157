//! Curves of puffs and volumes, which absorb along the ray, and of `over`, which adds light.
use crate::{
    common::{
        TIERS, Tier, map_frame,
        scenes::{Chance, empty, light, material, particle, triangle},
        tiers,
    },
    maps::{
        curve::{cpu, curved, discs, holds, mixture},
        volumes::{COLOR, DISTANCE, FOG, SUN, WALL, all_maps, cuboid, floor, fog, spot, stage},
    },
};
use gobo::{
    glam::{DVec3, Vec3, Vec4},
    model::{LightKind, Material, Particle, Profile, Receiver, Shape, Transfer},
    records::ViewMaps,
};
use gobo_reference::curve::bodies::MIN_BEND;
use gobo_scene::Scene;

/// Rounding of a stored channel, of f16 in `F`, and of a depth in 16 bits.
const ROUNDING: f32 = 2e-3;
/// Largest error of a ramp that is no longer split: its bend in the middle, and 5% because the maximum is
/// beside the middle.
const FLAT: f32 = 1.05 * 0.5 * MIN_BEND * MIN_BEND;

fn middle(maps: &ViewMaps) -> usize {
    let size = maps.view.size;
    ((size.y / 2) * size.x + size.x / 2) as usize
}

/// Light at a point of the central ray.
fn light_at(maps: &ViewMaps, point: Vec3) -> Vec3 {
    let p = maps.view.view_from_world.transform_point3(point);
    let z = (-p.z - maps.view.near) / (maps.view.far - maps.view.near);
    maps.curve.as_ref().unwrap().light_at(middle(maps), z)
}

/// Largest difference between a linear ramp and exponential absorption.
fn bend(passed: Vec3) -> Vec3 {
    let straight = |a: f32| (0..=100).map(|i| i as f32 / 100.0).map(move |t| 1.0 - (1.0 - a) * t);
    passed.map(|a| {
        straight(a)
            .zip((0..=100).map(|i| a.powf(i as f32 / 100.0)))
            .fold(0.0, |most: f32, (line, exact)| most.max(line - exact))
    })
}

/// Largest error inside a body of `count` ramps, a power of two: that of as many equal ramps in the most bent
/// channel, or less than is worth a node.
fn parts(passed: Vec3, count: u32) -> Vec3 {
    Vec3::splat(bend(passed.powf(1.0 / count as f32)).max_element().max(FLAT))
}

/// Transmittance of some metres of fog.
fn through(metres: f32) -> Vec3 {
    COLOR.powf(f64::from(metres) / DISTANCE).as_vec3()
}

fn near(is: Vec3, should: Vec3, slack: Vec3, what: &str) {
    assert!((is - should).abs().cmple(slack + ROUNDING).all(), "{what}: {is} {should} {slack}");
}

/// Two fogs with air between, and a wall inside a third.
#[test]
fn volumes_are_ramps() {
    for kind in [SUN, spot()] {
        let mut scene = stage(kind);
        for (low, high) in [(3.0, 4.0), (0.0, 1.5), (-4.0, -2.0)] {
            let (min, max) = (Vec3::new(-2.0, -2.0, low), Vec3::new(2.0, 2.0, high));
            scene.triangles.extend(cuboid(min, max, FOG));
        }
        scene.triangles.extend(floor(-3.0, WALL));
        let scene = curved(scene, 8);
        // Fog above height z: along the light's axis, close to the middle.
        let fog_above = |z: f32| {
            let part = |low: f32, high: f32| (high - z.clamp(low, high)).max(0.0);
            part(3.0, 4.0) + part(0.0, 1.5) + part(-3.0, -2.0)
        };
        for (maps, _) in all_maps(&scene) {
            for i in 0..140 {
                let z = 4.4 - i as f32 * 0.0527;
                // The light ends at the end of the ray.
                if (z + 3.0).abs() < 0.02 {
                    continue;
                }
                let inside = [(3.0, 4.0), (0.0, 1.5), (-3.0, -2.0)]
                    .iter()
                    .any(|&(low, high)| z < high + 0.02 && z > low - 0.02);
                // Three bodies in eight nodes: each has at least two.
                let half = through(1.5).powf(0.5);
                let slack = if inside { bend(half) } else { Vec3::ZERO };
                let is = light_at(&maps[0], Vec3::new(0.0, 0.0, z.max(-2.98)));
                near(is, through(fog_above(z.max(-2.98))), slack, &format!("{kind:?} {z}"));
            }
            let filter = Vec3::from_array(maps[0].filter[middle(&maps[0])]);
            near(filter, through(3.5), Vec3::ZERO, "F");
        }
        // The check can fail: it is wrong at a step of the curve.
        assert!((through(1.0) - through(0.5)).abs().max_element() > 0.1);
    }
}

/// A light inside a fog, and a body whose back face precedes its front face in the sorted order.
#[test]
fn volumes_that_hold_the_light_begin_with_it() {
    let mut scene = stage(LightKind::Point { position: Vec3::new(0.0, 0.0, 2.0) });
    scene.triangles.extend(cuboid(Vec3::splat(-3.0), Vec3::splat(3.0), FOG));
    scene.lights[0].near = Some(0.05);
    let scene = curved(scene, 8);
    for (maps, _) in all_maps(&scene) {
        let down = maps
            .iter()
            .find(|maps| maps.view.view_from_world.transform_vector3(Vec3::NEG_Z).z < -0.9);
        let down = down.unwrap();
        for (z, metres) in [(-1.0, 3.0), (-2.9, 4.9), (-3.5, 5.0), (-6.0, 5.0)] {
            // One body in eight nodes.
            let slack = if z > -3.0 { parts(through(5.0), 8) } else { Vec3::splat(4e-3) };
            near(light_at(down, Vec3::new(0.0, 0.0, z)), through(metres), slack, "down");
        }
    }
}

/// Behind everything, the filter equals that of nearest-depth mode for any mixture.
#[test]
fn the_filter_is_that_of_nearest_depth() {
    let mut scene = mixture();
    scene.materials.push(fog());
    scene
        .materials
        .push(Material { tint: Vec4::new(0.9, 0.7, 0.2, 0.4), ..material(Transfer::Over) });
    let (fog, over) = (scene.materials.len() as u32 - 2, scene.materials.len() as u32 - 1);
    scene.triangles.extend(cuboid(Vec3::new(-1.5, -0.5, -1.0), Vec3::new(0.5, 0.8, 1.2), fog));
    scene.triangles.extend(cuboid(Vec3::new(-0.5, -1.2, -0.4), Vec3::new(1.5, 0.1, 1.0), fog));
    let mut chance = Chance::new(3);
    for id in 0..4 {
        let corners = [0; 3].map(|_| chance.vec3(-2.0, 2.0));
        let pane = triangle(corners, over);
        scene.triangles.push(gobo::model::Triangle { id, ..pane });
    }
    let mut nearest = scene.clone();
    nearest.shadow.receiver = Receiver::Nearest;
    let expected = cpu(&nearest);
    let mut changes = 0;
    for tier in tiers(Tier::Core) {
        let frame = map_frame(tier, &scene);
        for (map, expected) in frame.maps.iter().zip(&expected) {
            let pairs = map.filter.iter().zip(&expected.filter);
            let far = pairs.filter(|(a, b)| (0..3).any(|i| (a[i] - b[i]).abs() > 0.004)).count();
            // Rays that graze an edge.
            assert!(far as f64 <= 2e-3 * map.filter.len() as f64, "{tier:?}: {far}");
            changes += map.filter.iter().filter(|light| light[0] < 0.9).count();
        }
    }
    assert!(changes > 1000, "{changes}");
    holds(Tier::Native, &scene, "bodies and over");
    holds(Tier::Core, &scene, "bodies and over");
}

/// A puff absorbs along its chord; two overlapping puffs each absorb their own share.
#[test]
fn puffs_are_ramps_that_may_overlap() {
    let puff = Material { shape: Shape::Puff, ..material(Transfer::Filter) };
    let mut scene = empty(vec![puff]);
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Z })];
    scene.shadow.size = 65;
    let colors = [Vec4::new(0.2, 0.6, 1.0, 0.5), Vec4::new(1.0, 0.4, 0.3, 0.4)];
    let centers = [0.0, -0.7];
    for (id, (color, z)) in (0..).zip(colors.into_iter().zip(centers)) {
        let own = particle(Vec3::new(0.0, 0.0, z), 1.0, color);
        scene.particles.push(Particle { id, ..own });
    }
    let scene = curved(scene, 8);
    let passed = |i: usize, z: f32| {
        let share = ((centers[i] + 1.0 - z) / 2.0).clamp(0.0, 1.0);
        (1.0 - colors[i].w * (1.0 - colors[i].truncate())).powf(share)
    };
    for (maps, _) in all_maps(&scene) {
        for i in 0..60 {
            let z = 1.3 - i as f32 * 0.05;
            let slack = bend(passed(0, -9.0)) + bend(passed(1, -9.0));
            // The middle's ray passes half a texel from the centres: the chord is a little shorter.
            let is = light_at(&maps[0], Vec3::new(0.0, 0.0, z));
            near(is, passed(0, z) * passed(1, z), slack, &format!("{z}"));
        }
        // Half-way through both, the chord of the first is incomplete: steps would be far off.
        let is = light_at(&maps[0], Vec3::new(0.0, 0.0, 0.2));
        assert!((is - passed(0, -9.0) * passed(1, 0.2)).abs().max_element() > 0.05, "{is}");
    }
}

/// A dense body in a curve of its own, a fog and a puff: a receiver inside gets the exponential, as exactly
/// as K ramps can express it. One ramp is off by up to 0.32.
#[test]
fn receivers_inside_a_dense_body_get_what_reaches_them() {
    assert_inside(&[8]);
}

#[test]
#[ignore = "kernels of other curves: make test-all"]
fn receivers_inside_a_dense_body_get_what_reaches_them_in_shorter_and_longer_curves() {
    assert_inside(&[4, 16]);
}

fn assert_inside(nodes: &[u32]) {
    let mut fog = stage(SUN);
    fog.triangles.extend(cuboid(Vec3::new(-2.0, -2.0, -2.0), Vec3::new(2.0, 2.0, 2.0), FOG));
    let puff = Material { shape: Shape::Puff, ..material(Transfer::Filter) };
    let mut steam = empty(vec![puff]);
    steam.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Z })];
    steam.shadow.size = 65;
    let soot = Vec4::new(0.0, 0.5, 0.9, 0.95);
    steam.particles.push(particle(Vec3::ZERO, 1.0, soot));
    let of_soot = 1.0 - soot.w * (1.0 - soot.truncate());
    for (scene, half, passed) in [(fog, 2.0, through(4.0)), (steam, 1.0, of_soot)] {
        for &nodes in nodes {
            let scene = curved(scene.clone(), nodes);
            for (maps, _) in all_maps(&scene) {
                let mut apart = 0.0_f32;
                for i in 0..200 {
                    let share = (i as f32 + 0.5) / 200.0;
                    let is = light_at(&maps[0], Vec3::new(0.0, 0.0, half - 2.0 * half * share));
                    let what = format!("{nodes} nodes, {share}");
                    near(is, passed.powf(share), parts(passed, nodes), &what);
                    apart = apart.max((is - passed.powf(share)).abs().max_element());
                }
                // The nodes are used.
                let used = maps[0].curve.as_ref().unwrap().ramps(middle(&maps[0])).count();
                assert!(used > 3 && used <= nodes as usize, "{nodes} nodes: {used}, {apart}");
            }
        }
    }
    assert!(bend(of_soot).max_element() > 0.3);
}

/// Kernels split the same bodies as the CPU reference, among other puffs and volumes; no body takes a hit's
/// node.
#[test]
fn bodies_take_free_nodes_only() {
    let mut scene = discs(4);
    scene.materials = vec![Material { shape: Shape::Puff, ..material(Transfer::Filter) }, fog()];
    scene.particles.truncate(60);
    for particle in &mut scene.particles {
        (particle.radius, particle.color.w) = (particle.radius.max(0.1), 0.9);
    }
    scene.triangles.extend(cuboid(Vec3::new(-1.5, -0.5, -1.0), Vec3::new(0.5, 0.8, 1.2), 1));
    for (tier, nodes) in TIERS.into_iter().zip([4, 8]) {
        holds(tier, &curved(scene.clone(), nodes), "puffs and a fog");
    }
    // Four puffs in four nodes, one behind another: between them, all light is exact.
    let puff = Material { shape: Shape::Puff, ..material(Transfer::Filter) };
    let mut row = empty(vec![puff]);
    row.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Z })];
    row.shadow.size = 65;
    let color = Vec4::new(0.1, 0.5, 0.8, 0.6);
    let passed = 1.0 - color.w * (1.0 - color.truncate());
    for i in 0..4 {
        let center = Vec3::new(0.0, 0.0, 1.5 - i as f32);
        row.particles.push(Particle { id: i, ..particle(center, 0.3, color) });
    }
    for (maps, _) in all_maps(&curved(row, 4)) {
        for i in 0..3 {
            let is = light_at(&maps[0], Vec3::new(0.0, 0.0, 1.0 - i as f32));
            near(is, passed.powf(i as f32 + 1.0), Vec3::ZERO, &format!("behind puff {i}"));
        }
    }
}

/// Layers of `over` in order: each texel's light is that of the painter's algorithm; exact with few hits, in
/// one segment and in many.
#[test]
fn over_is_composed_front_to_back() {
    let tints = [
        Vec4::new(0.9, 0.2, 0.1, 0.5),
        Vec4::new(0.1, 0.3, 0.9, 0.7),
        Vec4::new(1.0, 1.0, 1.0, 0.6),
        Vec4::new(0.0, 0.0, 0.0, 1.0),
        Vec4::new(0.4, 0.8, 0.3, 0.25),
    ];
    let pane = |tint| Material { tint, ..material(Transfer::Over) };
    let mut scene = empty(tints.map(pane).into());
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Y })];
    let height = |i: usize| 1.5 - 0.6 * i as f32;
    for i in 0..tints.len() {
        let corner = |x: f32, z: f32| Vec3::new(x, height(i), z);
        let corners = [corner(-4.0, -4.0), corner(4.0, -4.0), corner(0.0, 5.0)];
        scene.triangles.push(triangle(corners, i as u32));
    }
    let scene = curved(scene, 8);
    for (maps, counters) in all_maps(&scene) {
        let mut light = Vec3::ONE;
        for (i, tint) in tints.iter().enumerate() {
            light = light * (1.0 - tint.w) + tint.truncate() * tint.w;
            let behind = Vec3::new(0.0, height(i) - 0.3, 0.0);
            near(light_at(&maps[0], behind), light, Vec3::ZERO, &format!("layer {i}"));
        }
        assert_eq!(counters.disordered, 0);
    }
}

/// More pairs on one tile than a segment holds: layers of one colour, with fog among them.
#[test]
#[ignore = "many casters: make test-all"]
fn segments_follow_each_other() {
    const COUNT: u32 = 16_500;
    let soft =
        |transfer| Material { shape: Shape::Disc, profile: Profile::Flat, ..material(transfer) };
    let mut chance = Chance::new(12);
    let mut scene = empty(vec![soft(Transfer::Over), fog()]);
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Y })];
    scene.shadow.size = 16;
    let color = Vec3::new(0.8, 0.3, 0.1);
    for id in 0..COUNT {
        let center = Vec3::new(0.0, 1.0 - 2.0 * (id as f32 + chance.unit()) / COUNT as f32, 0.0);
        scene.particles.push(Particle { id, ..particle(center, 50.0, color.extend(1e-4)) });
    }
    let (low, high) = (-0.9, 0.7);
    scene.triangles.extend(cuboid(Vec3::new(-30.0, low, -30.0), Vec3::new(30.0, high, 30.0), 1));
    let opacity = f64::from(half::f16::from_f32(1e-4).to_f32());
    let scene = curved(scene, 8);
    for tier in tiers(Tier::Core) {
        let frame = map_frame(tier, &scene);
        assert!(frame.counters.segments > 2, "{:?}", frame.counters);
        let map = &frame.maps[0];
        // In nearest-depth mode volumes filter the light behind all `over` casters; along the ray the order
        // matters, and both agree only at the end.
        let kept = (-opacity * f64::from(COUNT)).exp();
        let painted = DVec3::splat(kept) + color.as_dvec3() * (1.0 - kept);
        let end = painted * through(high - low).as_dvec3();
        let filter = Vec3::from_array(map.filter[middle(map)]);
        near(filter, end.as_vec3(), Vec3::splat(5e-3), "F");
        let at_end = map.curve.as_ref().unwrap().light_at(middle(map), 0.9999);
        near(at_end, end.as_vec3(), Vec3::splat(1e-2), "end");
        let mut before = Vec3::splat(1.01);
        for i in 0..40 {
            let here = map.curve.as_ref().unwrap().light_at(middle(map), (i as f32 + 0.5) / 40.0);
            assert!(here.cmple(before + 0.02).all(), "{tier:?} {i}: {here} after {before}");
            before = here;
        }
    }
    holds(Tier::Native, &scene, "segments");
    let plain = Scene { triangles: Vec::new(), ..scene };
    holds(Tier::Core, &plain, "segments of over");
}

/// The tests above distinguish the modes.
#[test]
fn reference_of_other_bodies_differ() {
    let scene = discs(8);
    let mut puffs = scene.clone();
    puffs.materials[0].shape = Shape::Puff;
    assert!(crate::maps::curve::share_apart(&cpu(&scene), &cpu(&puffs)) > 0.05);
}

/// A lamp in the middle of a body, and another body behind it; then both in a third, which contains the lamp,
/// too.
#[test]
fn a_lamps_own_bodies_end_where_the_light_leaves_them() {
    let colors = [Vec3::new(0.3, 0.6, 0.8), Vec3::new(0.8, 0.5, 0.3), Vec3::new(0.9, 0.7, 0.95)];
    let body = |attenuation_color, attenuation_distance| Material {
        attenuation_color,
        attenuation_distance,
        ..material(Transfer::Filter)
    };
    let [first, second, third] = colors;
    let mut scene = empty(vec![body(first, 0.4), body(second, 0.6), body(third, 2.4)]);
    scene.shadow.size = 32;
    scene.lights.push(light(LightKind::Point { position: Vec3::ZERO }));
    (scene.lights[0].near, scene.lights[0].far) = (Some(0.01), Some(4.0));
    let cube = |center: Vec3, half: f32, material| cuboid(center - half, center + half, material);
    scene.triangles = cube(Vec3::ZERO, 0.4, 0);
    scene.triangles.extend(cube(Vec3::NEG_Z * 1.5, 0.3, 1));
    let mut nested = scene.clone();
    nested.triangles.extend(cube(Vec3::ZERO, 2.4, 2));
    // Light counts from the near plane.
    let exact = |metres: f32, is_nested: bool| {
        let share = |from: f32, to: f32| (metres.clamp(from, to) - from) / (to - from);
        let inside = |half: f32| (metres.min(half) - 0.01) / half;
        let held = if is_nested { third.powf(inside(2.4)) } else { Vec3::ONE };
        first.powf(inside(0.4)) * second.powf(share(1.2, 1.8)) * held
    };
    for (scene, is_nested) in [(scene, false), (nested, true)] {
        for (maps, counters) in all_maps(&curved(scene, 8)) {
            assert_eq!(counters.disordered, 0);
            let down = maps.iter().find(|maps| maps.view.name == "nz").expect("a face");
            // Between faces of the bodies a ramp of the third is straight.
            let slack = if is_nested { bend(third.powf(0.5)) } else { Vec3::ZERO };
            for metres in [0.41, 0.6, 1.0, 1.19, 1.81, 2.0, 2.39, 2.5, 3.5] {
                let is = light_at(down, Vec3::NEG_Z * metres);
                let slack = if metres < 2.4 { slack } else { Vec3::ZERO };
                near(
                    is,
                    exact(metres, is_nested),
                    slack + 4e-3,
                    &format!("{is_nested}, {metres} m"),
                );
            }
        }
    }
}

/// The same over several segments: veils that hardly filter are between the lamp and the faces.
#[test]
fn a_lamps_own_body_ends_in_a_later_segment() {
    const VEILS: u32 = 9_000;
    let color = Vec3::new(0.3, 0.6, 0.8);
    let disc =
        Material { shape: Shape::Disc, profile: Profile::Flat, ..material(Transfer::Filter) };
    let body = Material {
        attenuation_color: color,
        attenuation_distance: 1.0,
        ..material(Transfer::Filter)
    };
    let mut scene = empty(vec![disc, body]);
    scene.lights =
        vec![light(LightKind::Spot { position: Vec3::ZERO, direction: Vec3::NEG_Z, angle: 0.5 })];
    (scene.lights[0].near, scene.lights[0].far) = (Some(0.01), Some(4.0));
    scene.shadow.size = 16;
    for id in 0..VEILS {
        let center = Vec3::NEG_Z * (0.1 + 2.9 * (id as f32 + 0.5) / VEILS as f32);
        scene
            .particles
            .push(Particle { id, ..particle(center, 20.0, Vec4::new(0.0, 0.0, 0.0, 1e-6)) });
    }
    scene.triangles = cuboid(Vec3::splat(-1.0), Vec3::splat(1.0), 1);
    for (maps, counters) in all_maps(&curved(scene, 8)) {
        assert!(counters.segments > 2, "{counters:?}");
        for metres in [1.2, 2.0, 3.5] {
            near(
                light_at(&maps[0], Vec3::NEG_Z * metres),
                color,
                Vec3::splat(0.012),
                &format!("{metres} m"),
            );
        }
    }
}
