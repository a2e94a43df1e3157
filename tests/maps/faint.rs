//! Many casters of next to no opacity. Truth: the closed form of their product.
use crate::common::{
    TIERS,
    scenes::{Chance, empty, light, material, particle},
};
use gobo::{
    glam::{Vec3, Vec4},
    model::{LightKind, Material, Particle, Profile, Shape, Transfer},
    records::ViewMaps,
    reference::render_maps,
    scene::Scene,
    view::shadow_views,
};

/// What permuting casters or a lack of room may change: 2^-10.
const PROMISED: f64 = 1.0 / 1024.0;
const COLOR: Vec3 = Vec3::new(0.0, 0.5, 0.9);

/// `count` casters of opacity `alpha`, each over the whole of a map of one tile.
fn veils(look: Material, count: u32, alpha: f32) -> Scene {
    let mut scene = empty(vec![look]);
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Y })];
    scene.lights[0].size = Some(16);
    let mut chance = Chance::new(5);
    for id in 0..count {
        let center = Vec3::Y * chance.within(-1.0, 1.0);
        scene.particles.push(Particle { id, ..particle(center, 20.0, COLOR.extend(alpha)) });
    }
    scene
}

fn flat(transfer: Transfer) -> Material {
    Material { profile: Profile::Flat, ..material(transfer) }
}

fn middle(maps: &ViewMaps) -> [f64; 3] {
    let size = maps.view.size.x as usize;
    maps.filter[size / 2 * size + size / 2].map(f64::from)
}

/// Twin and tiers, with room for all pairs and for none.
fn assert_passes(scene: &Scene, absorbed: [f64; 3]) {
    let count = scene.particles.len() as f64;
    let expected = absorbed.map(|x| (count * (-x).ln_1p()).exp());
    for pair_budget in [scene.shadow.pair_budget, 0] {
        let mut scene = scene.clone();
        scene.shadow.pair_budget = pair_budget;
        let mut all = vec![render_maps(&scene, &shadow_views(&scene)).0];
        all.extend(TIERS.map(|tier| crate::common::render(tier, &scene).maps));
        for (maps, who) in all.iter().zip(["twin", "core", "native"]) {
            for (found, expected) in middle(&maps[0]).into_iter().zip(expected) {
                let apart = (found - expected).abs();
                assert!(apart <= PROMISED, "{who}, {pair_budget}: {found} for {expected}");
            }
        }
    }
}

#[test]
fn faint_discs_add_up() {
    for (count, alpha) in [(200_000, 2e-6), (30_000, 1e-5)] {
        let absorbed = COLOR.to_array().map(|c| (1.0 - f64::from(c)) * f64::from(alpha));
        assert_passes(&veils(flat(Transfer::Filter), count, alpha), absorbed);
    }
}

#[test]
fn faint_soft_discs_add_up() {
    let scene = veils(material(Transfer::Filter), 20_000, 2e-5);
    // The middle texel is next to the centre of discs of many texels.
    let maps = &render_maps(&scene, &shadow_views(&scene)).0[0];
    let texel = f64::from(maps.view.scale).recip();
    let profile = (1.0 - (0.5 * texel * texel) / 400.0_f64).powi(2);
    let absorbed = COLOR.to_array().map(|c| (1.0 - f64::from(c)) * f64::from(2e-5_f32) * profile);
    assert_passes(&scene, absorbed);
}

#[test]
fn faint_smoke_and_stains_add_up() {
    let alpha = f64::from(5e-5_f32);
    let smoke = COLOR.to_array().map(|c| {
        let filter = alpha * (1.0 - f64::from(c));
        1.0 - (1.0 - alpha) * (1.0 - filter)
    });
    assert_passes(&veils(flat(Transfer::Smoke), 8_000, 5e-5), smoke);
    let mut glass = veils(flat(Transfer::Stain), 8_000, 5e-5);
    glass.particles.iter_mut().for_each(|p| p.color = Vec4::new(1.0, 1.0, 1.0, 5e-5));
    assert_passes(&glass, [alpha; 3]);
}

#[test]
fn faint_puffs_add_up() {
    let puff = Material { shape: Shape::Puff, ..material(Transfer::Filter) };
    let mut scene = veils(puff, 6_000, 5e-5);
    scene.particles.iter_mut().for_each(|p| p.center = Vec3::ZERO);
    let maps = &render_maps(&scene, &shadow_views(&scene)).0[0];
    let texel = f64::from(maps.view.scale).recip();
    let share = (1.0 - 0.5 * texel * texel / 400.0_f64).sqrt();
    let absorbed = COLOR
        .to_array()
        .map(|c| -((-(1.0 - f64::from(c)) * f64::from(5e-5_f32)).ln_1p() * share).exp_m1());
    assert_passes(&scene, absorbed);
}
