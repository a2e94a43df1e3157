//! Maps past the pair budget, whose tiles are walked in parts: the same bits as with room for all.
use super::{curve, volumes};
use crate::common::{
    Tier, map_frame,
    scenes::{Chance, empty, hold_view, light, material, particle, random_discs, triangle},
    tiers,
};
use gobo::{
    glam::{Vec3, Vec4},
    model::{LightKind, Material, Particle, Profile, Receiver, Shape, Transfer},
    records::ViewMaps,
};
use gobo_scene::Scene;

const POINT: LightKind = LightKind::Point { position: Vec3::new(0.4, 2.6, 0.3) };

/// Particles of all looks, with panes between them, under lamps of two kinds.
fn of_looks(looks: Vec<Material>) -> Scene {
    let count = looks.len();
    let mut scene = empty(looks);
    scene.shadow.size = 96; // no whole number of parts
    scene.lights = vec![
        light(LightKind::Directional { direction: Vec3::new(0.3, -1.0, 0.2).normalize() }),
        light(POINT),
    ];
    let mut chance = Chance::new(7);
    scene.particles = random_discs(900, 12);
    for (i, particle) in scene.particles.iter_mut().enumerate() {
        particle.material = (i % count) as u32;
        particle.color.w *= 0.3;
    }
    for _ in 0..30 {
        let corners = [0; 3].map(|_| chance.vec3(-1.5, 1.5));
        scene.triangles.push(triangle(corners, chance.below(count) as u32));
    }
    scene
}

fn tint(transfer: Transfer, rgba: [f32; 4]) -> Material {
    Material { tint: Vec4::from_array(rgba), ..material(transfer) }
}

pub(super) fn scenes() -> Vec<(&'static str, Scene)> {
    let glass = tint(Transfer::Filter, [0.9, 0.4, 0.6, 0.7]);
    let wall = material(Transfer::Opaque);
    let dithered = tint(Transfer::Dither, [1.0, 1.0, 1.0, 0.5]);
    let quad = Material { shape: Shape::Quad, ..material(Transfer::Stain) };
    let puff = Material { shape: Shape::Puff, ..material(Transfer::Filter) };
    let over = tint(Transfer::Over, [0.9, 0.6, 0.5, 0.5]);
    let gain = tint(Transfer::Gain, [1.3, 1.1, 1.0, 1.0]);
    let smoke = material(Transfer::Smoke);
    let mut soft = of_looks(vec![material(Transfer::Filter)]);
    soft.triangles.clear(); // soft discs alone are walked by other kernels
    let mut softened = of_looks(vec![glass.clone(), smoke.clone(), wall.clone(), dithered]);
    softened.shadow.soften = true;
    let mut mist = of_looks(vec![material(Transfer::Filter)]);
    mist.particles.iter_mut().for_each(|particle| particle.color.w *= 1e-5);
    let mut bodies = volumes::stage(POINT);
    for i in 0..40 {
        let corner = Vec3::new(-4.0, -4.0, -8.0 + 0.3 * i as f32);
        let size = Vec3::new(6.0, 5.0 + 0.1 * i as f32, 0.2);
        bodies.triangles.extend(volumes::cuboid(corner, corner + size, volumes::FOG));
    }
    vec![
        ("soft discs", soft),
        ("mixture", of_looks(vec![glass.clone(), smoke, quad, wall])),
        ("puffs", of_looks(vec![puff, glass.clone()])),
        ("over", of_looks(vec![over, glass])),
        ("gain", of_looks(vec![gain, material(Transfer::Filter)])),
        ("softened", softened),
        ("faint discs", mist),
        ("volumes", bodies),
    ]
}

pub(super) fn assert_same(found: &[ViewMaps], expected: &[ViewMaps], what: &str) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!(found.opaque == expected.opaque, "{what}: opaque");
        assert!(found.nearest == expected.nearest, "{what}: nearest");
        assert!(found.filter == expected.filter, "{what}: filter");
        let packed = |maps: &ViewMaps| maps.curve.as_ref().map(|curve| curve.packed.clone());
        assert!(packed(found) == packed(expected), "{what}: curve");
    }
}

/// The maps are the same with room for all pairs, for a tenth of them, and for almost none.
pub(super) fn assert_budget_does_not_matter(name: &str, scene: &Scene) {
    for tier in tiers(Tier::Native) {
        let whole = map_frame(tier, scene);
        let (pairs, disordered) = (whole.counters.pairs, whole.counters.disordered);
        assert_eq!(whole.counters.overflowed, 0, "{name}");
        for pair_budget in [pairs as u32 / 10, 7] {
            let mut scene = scene.clone();
            scene.shadow.pair_budget = pair_budget;
            let frame = map_frame(tier, &scene);
            let what = format!("{name}, {tier:?}, {pair_budget} of {pairs}");
            let counters = &frame.counters;
            assert!(counters.overflowed > 0 && counters.unordered == 0, "{what}: {counters:?}");
            assert_eq!(counters.disordered, disordered, "{what}");
            assert_same(&frame.maps, &whole.maps, &what);
        }
    }
}

#[test]
fn maps_do_not_depend_on_the_budget() {
    let (name, mut scene) = scenes().swap_remove(1);
    assert_budget_does_not_matter(name, &scene);
    scene.shadow.receiver = Receiver::Curve;
    assert_budget_does_not_matter(name, &scene);
}

#[test]
#[ignore = "kernels of every kind of caster: make test-all"]
fn maps_of_every_kind_do_not_depend_on_the_budget() {
    for (name, mut scene) in scenes() {
        // The others are binned, sorted and walked like a mixture.
        if ["soft discs", "over", "faint discs", "volumes"].contains(&name) {
            assert_budget_does_not_matter(name, &scene);
        }
        scene.shadow.receiver = Receiver::Curve;
        assert_budget_does_not_matter(name, &scene);
    }
    for nodes in [4, 16] {
        assert_budget_does_not_matter("nodes", &curve::discs(nodes));
    }
}

/// Tiles with more pairs than a segment, beside others: many on one texel, few of which fit.
pub(super) fn long_tiles() -> [(&'static str, Scene); 3] {
    let flat = Material { profile: Profile::Flat, ..material(Transfer::Filter) };
    let over = Material { profile: Profile::Flat, ..tint(Transfer::Over, [0.9, 0.6, 0.5, 1.0]) };
    let looks = [("discs", material(Transfer::Filter)), ("flat discs", flat), ("over", over)];
    looks.map(|(name, look)| {
        let mut scene = empty(vec![look, material(Transfer::Opaque)]);
        hold_view(&mut scene, 1);
        scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Y })];
        scene.lights[0].size = Some(48);
        let mut chance = Chance::new(3);
        for id in 0..9_000 {
            let spread = if id % 8 == 0 { 8.0 } else { 0.5 };
            let center = Vec3::new(1.0, 1.0, 1.0) + chance.vec3(-spread, spread);
            let color = chance.vec3(0.0, 1.0).extend(2e-3 * chance.unit());
            scene.particles.push(Particle { id, ..particle(center, 0.8, color) });
        }
        (name, scene)
    })
}

#[test]
#[ignore = "many casters: make test-all"]
fn long_tiles_do_not_depend_on_the_budget() {
    for (name, mut scene) in long_tiles() {
        for receiver in [Receiver::Curve, Receiver::Nearest] {
            scene.shadow.receiver = receiver;
            assert_budget_does_not_matter(name, &scene);
        }
    }
}
