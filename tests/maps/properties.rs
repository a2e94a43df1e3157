//! Properties of all scenes, for the CPU reference's maps and the kernels'.
use crate::common::{
    Tier, map_frame,
    scenes::{Chance, empty, light, material, random_discs, triangle},
    tiers,
};
use gobo::{
    glam::{Vec3, Vec4},
    model::{LightKind, Material, Profile, Shape, Transfer},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_reference::render_maps;
use gobo_scene::Scene;

/// Largest change of `F` when the casters are permuted.
const PERMUTED: f32 = 1.0 / 1024.0;

fn materials() -> Vec<Material> {
    [Transfer::Filter, Transfer::Stain, Transfer::Smoke, Transfer::None, Transfer::Opaque]
        .into_iter()
        .zip([Shape::Disc, Shape::Quad, Shape::Disc, Shape::Puff, Shape::Disc])
        .map(|(transfer, shape)| Material { shape, reflectivity: 0.3, ..material(transfer) })
        .chain([Material { shape: Shape::Puff, ..material(Transfer::Filter) }])
        .collect()
}

fn random_scene(seed: u64) -> Scene {
    let mut chance = Chance::new(seed);
    let mut scene = empty(materials());
    let position = chance.vec3(-2.5, 2.5);
    scene.lights = vec![
        light(LightKind::Directional { direction: chance.vec3(-1.0, 1.0).normalize() }),
        light(LightKind::Spot { position, direction: -position.normalize(), angle: 1.2 }),
        light(LightKind::Point { position: chance.vec3(-0.5, 0.5) }),
    ];
    scene.particles = random_discs(300, seed);
    for particle in &mut scene.particles {
        // Few are opaque.
        particle.material = [0, 0, 1, 2, 2, 3, 5, 5, 0, 4][chance.below(10)];
        if particle.material == 4 {
            particle.radius *= 0.3;
        }
    }
    for _ in 0..12 {
        let positions = [0; 3].map(|_| chance.vec3(-2.0, 2.0));
        scene.triangles.push(triangle(positions, chance.below(3) as u32));
    }
    scene
}

/// Maps of the CPU reference, and of the kernels of a tier.
fn maps_of(scene: &Scene) -> Vec<Vec<ViewMaps>> {
    let kernels = tiers(Tier::Native).into_iter().map(|tier| map_frame(tier, scene).maps);
    [render_maps(scene, &shadow_views(scene)).0].into_iter().chain(kernels).collect()
}

/// Differences between corresponding maps.
fn all_apart(a: &[Vec<ViewMaps>], b: &[Vec<ViewMaps>]) -> Vec<f32> {
    a.iter().zip(b).map(|(a, b)| apart(a, b)).collect()
}

/// Largest difference of `F`; infinite if depths differ at all.
fn apart(a: &[ViewMaps], b: &[ViewMaps]) -> f32 {
    assert_eq!(a.len(), b.len());
    let of_view = |(a, b): (&ViewMaps, &ViewMaps)| {
        if a.nearest != b.nearest || a.opaque != b.opaque {
            return f32::INFINITY;
        }
        let texels = a.filter.iter().flatten().zip(b.filter.iter().flatten());
        texels.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    };
    a.iter().zip(b).map(of_view).fold(0.0, f32::max)
}

#[test]
fn the_order_of_casters_does_not_matter() {
    for seed in 1..4 {
        let scene = random_scene(seed);
        let maps = maps_of(&scene);
        let mut permuted = scene.clone();
        let mut chance = Chance::new(seed);
        chance.shuffle(&mut permuted.particles);
        chance.shuffle(&mut permuted.triangles);
        let by_order = all_apart(&maps, &maps_of(&permuted));
        assert!(by_order.iter().all(|apart| *apart <= PERMUTED), "{by_order:?}");
        let large = |p: &gobo::model::Particle| p.material == 0 && p.radius > 0.2;
        permuted.particles.retain(|p| !large(p));
        assert!(permuted.particles.len() < scene.particles.len());
        let by_loss = all_apart(&maps, &maps_of(&permuted));
        assert!(by_loss.iter().all(|apart| *apart > PERMUTED), "what is left out is noticed");
    }
}

#[test]
fn light_stays_between_none_and_all() {
    for seed in 10..14 {
        for maps in maps_of(&random_scene(seed)).into_iter().flatten() {
            let unit = 0.0..=1.0;
            assert!(maps.filter.iter().flatten().all(|light| unit.contains(light)));
            assert!(maps.nearest.iter().chain(&maps.opaque).all(|depth| unit.contains(depth)));
            let pairs = maps.nearest.iter().zip(&maps.opaque);
            assert!(pairs.clone().all(|(d, z)| d < z || *d == 1.0));
        }
    }
}

#[test]
fn casters_past_the_pair_budget_cost_no_light() {
    let scene = random_scene(20);
    let (maps, counters) = render_maps(&scene, &shadow_views(&scene));
    assert_eq!(counters.overflowed, 0);
    for pair_budget in [0, 100] {
        let mut tight = scene.clone();
        tight.shadow.pair_budget = pair_budget;
        let (tight_maps, tight_counters) = render_maps(&tight, &shadow_views(&tight));
        assert!(tight_counters.overflowed > 0);
        assert!(tight_counters.pairs <= u64::from(pair_budget) * maps.len() as u64);
        assert_eq!(tight_counters.visible, counters.visible);
        assert!(apart(&maps, &tight_maps) <= PERMUTED);
        for tier in tiers(Tier::Native) {
            let by_budget = apart(&map_frame(tier, &scene).maps, &map_frame(tier, &tight).maps);
            assert!(by_budget <= PERMUTED, "{tier}: {by_budget}");
        }
    }
}

#[test]
fn extremes_make_no_nan() {
    let mut scene = random_scene(30);
    let extremes = [
        (Vec3::ZERO, 1e-7, 1.0),
        (Vec3::ZERO, 1e6, 1.0),
        (Vec3::splat(1e7), 1.0, 1.0),
        (Vec3::new(-1e7, 1e-30, 0.0), 1e7, 0.5),
        (Vec3::splat(1e-38), 1e-38, 0.0),
        (Vec3::new(0.0, 3.0, 0.0), 3.0, 1.0),
    ];
    for (i, (center, radius, alpha)) in extremes.into_iter().enumerate() {
        for material in 0..6 {
            let color = Vec4::new(0.0, 1.0, 0.5, alpha);
            let first = scene.particles[i];
            let extreme = gobo::model::Particle { center, radius, color, material, ..first };
            scene.particles.push(extreme);
        }
    }
    for positions in [[Vec3::ZERO; 3], [Vec3::ZERO, Vec3::splat(1e7), Vec3::splat(-1e7)]] {
        scene.triangles.push(triangle(positions, 0));
    }
    for maps in maps_of(&scene).iter().flatten() {
        assert!(maps.filter.iter().flatten().all(|light| (0.0..=1.0).contains(light)));
        assert!(maps.nearest.iter().chain(&maps.opaque).all(|depth| (0.0..=1.0).contains(depth)));
    }
}

#[test]
fn only_gain_brightens() {
    let mut scene = random_scene(40);
    let bright = Material { profile: Profile::Flat, ..material(Transfer::Gain) };
    scene.materials.push(bright);
    for particle in scene.particles.iter_mut().filter(|p| p.id % 7 == 0) {
        particle.material = 6;
        particle.color = Vec4::new(16.0, 2.0, 1.0, 1.0);
    }
    for maps in maps_of(&scene) {
        let lights = || maps.iter().flat_map(|maps| &maps.filter);
        assert!(lights().any(|light| light[0] > 1.0));
        assert!(lights().flatten().all(|light| light.is_finite()));
    }
}
