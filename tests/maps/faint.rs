//! Many casters of almost no opacity. Truth: the closed form of their product.
use crate::common::{
    Tier, map_frame,
    scenes::{Chance, empty, hold_view, light, material, particle},
    tiers,
};
use gobo::{
    glam::{Vec3, Vec4},
    model::{LightKind, Material, Particle, Profile, Receiver, Shape, Transfer},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_reference::render_maps;
use gobo_scene::Scene;

/// Largest change when casters are permuted: 2^-10.
const PROMISED: f64 = 1.0 / 1024.0;
/// A step of 16-bit filters from 1/2 to 1, as drivers may truncate, and a tenth of it. If each of `COUNT`
/// casters lost the rounding of `1 - ALPHA`, the error would be larger.
const STORAGE: f64 = 1.1 / 2048.0;
/// Largest difference of a curve of 8 nodes when half the light is lost evenly: its ramps are straight, and a
/// channel has 12 bits. Lost casters would be 0.06 to 0.5.
const CURVE: f64 = 0.01;
const COUNT: u32 = 40_000;
/// Halfway between two 32-bit floats when it is subtracted from 1.
const ALPHA: f32 = 167.5 / 16_777_216.0;
/// Radius of a caster [m]; a texel is 1.25 m.
const RADIUS: f32 = 2.0;
const COLOR: Vec3 = Vec3::new(0.0, 0.5, 0.9);

/// `count` casters of opacity `alpha`, each over the middle of a map of one tile.
fn veils(look: Material, count: u32, alpha: f32) -> Scene {
    let mut scene = empty(vec![look, material(Transfer::Opaque)]);
    hold_view(&mut scene, 1);
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Y })];
    scene.lights[0].size = Some(16);
    let mut chance = Chance::new(5);
    for id in 0..count {
        let center = Vec3::Y * chance.within(-1.0, 1.0);
        scene.particles.push(Particle { id, ..particle(center, RADIUS, COLOR.extend(alpha)) });
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

/// Checks CPU reference and tiers, with capacity for all pairs, for those of most casters, and for none.
fn assert_passes(scene: &Scene, absorbed: [f64; 3], tolerance: f64) {
    let count = scene.particles.len() as f64;
    let expected = absorbed.map(|x| (count * (-x).ln_1p()).exp());
    for pair_budget in [scene.shadow.pair_budget, scene.particles.len() as u32 / 20 * 13, 0] {
        let mut scene = scene.clone();
        scene.shadow.pair_budget = pair_budget;
        let mut all = vec![render_maps(&scene, &shadow_views(&scene)).0];
        all.extend(tiers(Tier::Native).into_iter().map(|tier| map_frame(tier, &scene).maps));
        for (maps, who) in all.iter().zip(["cpu", "core", "native"]) {
            for (found, expected) in middle(&maps[0]).into_iter().zip(expected) {
                let apart = (found - expected).abs();
                assert!(apart <= tolerance, "{who}, {pair_budget}: {found} for {expected}");
            }
        }
    }
}

/// Squared distance of the middle texel's centre from the middle of the casters, in units of their radius.
fn squared_distance(scene: &Scene) -> f64 {
    let texel = f64::from(shadow_views(scene)[0].scale).recip();
    0.5 * texel * texel / f64::from(RADIUS * RADIUS)
}

fn assert_discs_pass(count: u32, alpha: f32, tolerance: f64) {
    let absorbed = COLOR.to_array().map(|c| (1.0 - f64::from(c)) * f64::from(alpha));
    assert_passes(&veils(flat(Transfer::Filter), count, alpha), absorbed, tolerance);
}

#[test]
#[ignore = "many casters: make test-all"]
fn faint_discs_add_up() {
    assert_discs_pass(COUNT, ALPHA, STORAGE);
}

#[test]
#[ignore = "many casters: make test-all"]
fn the_faintest_discs_add_up() {
    assert_discs_pass(200_000, 2e-6, PROMISED);
}

#[test]
#[ignore = "many casters: make test-all"]
fn faint_soft_discs_add_up() {
    let scene = veils(material(Transfer::Filter), COUNT, ALPHA);
    let profile = (1.0 - squared_distance(&scene)).powi(2);
    let absorbed = COLOR.to_array().map(|c| (1.0 - f64::from(c)) * f64::from(ALPHA) * profile);
    assert_passes(&scene, absorbed, STORAGE);
}

#[test]
#[ignore = "many casters: make test-all"]
fn faint_smoke_and_stains_add_up() {
    let alpha = f64::from(ALPHA);
    let smoke = COLOR.to_array().map(|c| {
        let filter = alpha * (1.0 - f64::from(c));
        1.0 - (1.0 - alpha) * (1.0 - filter)
    });
    assert_passes(&veils(flat(Transfer::Smoke), COUNT, ALPHA), smoke, STORAGE);
    let mut glass = veils(flat(Transfer::Stain), COUNT, ALPHA);
    glass.particles.iter_mut().for_each(|p| p.color = Vec4::new(1.0, 1.0, 1.0, ALPHA));
    assert_passes(&glass, [alpha; 3], STORAGE);
}

#[test]
#[ignore = "many casters: make test-all"]
fn faint_puffs_add_up() {
    let puff = Material { shape: Shape::Puff, ..material(Transfer::Filter) };
    let mut scene = veils(puff, COUNT, ALPHA);
    scene.particles.iter_mut().for_each(|p| p.center = Vec3::ZERO);
    let share = (1.0 - squared_distance(&scene)).sqrt();
    let absorbed = COLOR
        .to_array()
        .map(|c| -((-(1.0 - f64::from(c)) * f64::from(ALPHA)).ln_1p() * share).exp_m1());
    assert_passes(&scene, absorbed, STORAGE);
}

/// Checks the curves of CPU reference and tiers at three depths, and the filter, for casters below and above
/// the opacity from which a single one has a place in a curve.
fn assert_curves_pass(look: &Material, profile: f64) {
    for (count, alpha) in [(6_000, 1.2e-4), (8_000, 1e-5)] {
        let mut scene = veils(look.clone(), count, alpha);
        scene.shadow.receiver = Receiver::Curve;
        let mut all = vec![render_maps(&scene, &shadow_views(&scene)).0];
        all.extend(tiers(Tier::Native).into_iter().map(|tier| map_frame(tier, &scene).maps));
        for (maps, who) in all.iter().zip(["cpu", "core", "native"]) {
            let (curve, view) = (maps[0].curve.as_ref().unwrap(), &maps[0].view);
            let size = view.size.x as usize;
            for height in [0.5, 0.0, -1.5] {
                let along = -view.view_from_world.transform_point3(Vec3::Y * height).z;
                let depth = (along - view.near) / (view.far - view.near);
                let found = curve.light_at(size / 2 * size + size / 2, depth);
                let before = scene.particles.iter().filter(|p| p.center.y > height).count();
                for channel in 0..3 {
                    let absorbed = (1.0 - f64::from(COLOR[channel])) * f64::from(alpha) * profile;
                    let expected = (before as f64 * (-absorbed).ln_1p()).exp();
                    let apart = (f64::from(found[channel]) - expected).abs();
                    let message = format!("{who}, {count} of {alpha} at {height}: {found}");
                    assert!(apart <= CURVE, "{message} for {expected}");
                }
            }
        }
    }
}

#[test]
fn curves_hold_faint_discs() {
    assert_curves_pass(&flat(Transfer::Filter), 1.0);
}

#[test]
fn curves_hold_faint_soft_discs() {
    let middle = squared_distance(&veils(material(Transfer::Filter), 1, ALPHA));
    assert_curves_pass(&material(Transfer::Filter), (1.0 - middle).powi(2));
}

#[test]
#[ignore = "many casters: make test-all"]
fn filters_beside_curves_add_up() {
    for look in [flat(Transfer::Filter), flat(Transfer::Smoke)] {
        let mut scene = veils(look, 200_000, 2e-6);
        scene.shadow.receiver = Receiver::Curve;
        let once = COLOR.to_array().map(|c| (1.0 - f64::from(c)) * 2e-6);
        let smoke = once.map(|absorbed| 1.0 - (1.0 - 2e-6) * (1.0 - absorbed));
        let is_smoke = scene.materials[0].transfer == Transfer::Smoke;
        assert_passes(&scene, if is_smoke { smoke } else { once }, PROMISED);
    }
}

/// Nearly white casters absorb their small share: records store 1 - c to a thousandth.
#[test]
fn nearly_white_casters_keep_their_colour() {
    const COUNT: u32 = 20_000;
    let disc = Material { profile: Profile::Flat, ..material(Transfer::Filter) };
    let mut scene = empty(vec![disc]);
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Y })];
    scene.shadow.size = 16;
    for id in 0..COUNT {
        let center = Vec3::Y * (id as f32 / COUNT as f32);
        let color = Vec4::new(0.9999, 0.99999, 1.0, 0.5);
        scene.particles.push(Particle { id, ..particle(center, 50.0, color) });
    }
    let taken = [1e-4, 1e-5, 0.0].map(|absorbed: f64| (-0.5 * absorbed * f64::from(COUNT)).exp());
    for tier in tiers(Tier::Core) {
        let filter = map_frame(tier, &scene).maps[0].filter[16 * 8 + 8];
        for (is, should) in filter.iter().zip(taken) {
            assert!((f64::from(*is) - should).abs() <= 1e-3, "{tier:?}: {is} for {should}");
        }
    }
}
