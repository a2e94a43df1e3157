//! Casters beside a light and around it: more than 87 degrees off a view's axis, behind its plane, and puffs
//! that contain the light. Truth: the renderer in 64 bits, and closed forms.
use super::brute_force::assert_agrees;
use crate::common::{
    Tier,
    brute_force::render,
    compare::{Tolerance, compare_maps},
    scenes::{Chance, empty, light, material, particle},
    tiers,
};
use gobo::{
    glam::{Vec3, Vec4},
    model::{Light, LightKind, Material, Particle, Profile, Receiver, Shape, Transfer},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_reference::render_maps;
use gobo_scene::Scene;

const LAMP: Vec3 = Vec3::Y;
const TOLERANCE: Tolerance = Tolerance { filter: 1e-3, depth: 1e-5, undecided: 0.0 };
const EDGED: Tolerance = Tolerance { undecided: 0.25, ..TOLERANCE };

/// Views of 32 texels that reach from 1 mm to 10 m.
fn lit_by(kind: LightKind, materials: Vec<Material>) -> Scene {
    let lamp = Light { near: Some(0.001), far: Some(10.0), size: Some(32), ..light(kind) };
    Scene { lights: vec![lamp], ..empty(materials) }
}

fn lamp(materials: Vec<Material>) -> Scene {
    lit_by(LightKind::Point { position: LAMP }, materials)
}

/// A spot that sees nearly everything below the lamp.
fn wide_spot(materials: Vec<Material>) -> Scene {
    let direction = Vec3::new(0.1, -1.0, 0.05).normalize();
    lit_by(LightKind::Spot { position: LAMP, direction, angle: 170_f32.to_radians() }, materials)
}

/// Particles all around the lamp, as close to it as a tenth of their radius; of `materials`.
fn around(count: u32, seed: u64, materials: usize) -> Vec<Particle> {
    let mut chance = Chance::new(seed);
    let particles = (0..count).map(|id| {
        let radius = chance.within(0.02, 0.6);
        let away = radius * chance.within(0.1, 6.0);
        let center = LAMP + chance.vec3(-1.0, 1.0).normalize() * away;
        let color = chance.vec3(0.0, 1.0).extend(chance.within(0.1, 0.5));
        let material = chance.below(materials) as u32;
        let rotation = chance.within(-7.0, 7.0);
        Particle { rotation, id, material, ..particle(center, radius, color) }
    });
    particles.collect()
}

fn shapes() -> Vec<Material> {
    let flat = Material { profile: Profile::Flat, ..material(Transfer::Filter) };
    let quad = Material { shape: Shape::Quad, ..material(Transfer::Stain) };
    let puff = Material { shape: Shape::Puff, ..material(Transfer::Filter) };
    vec![material(Transfer::Smoke), flat, quad, puff]
}

#[expect(clippy::needless_pass_by_value, reason = "each caller makes its scene")]
fn in_both_modes(scene: Scene, tolerance: Tolerance) {
    let mut curves = scene.clone();
    curves.shadow.receiver = Receiver::Curve;
    assert_agrees(&scene, tolerance);
    assert_agrees(&curves, tolerance);
}

#[test]
fn soft_discs_around_a_lamp() {
    let mut scene = lamp(vec![material(Transfer::Filter)]);
    scene.particles = around(60, 1, 1);
    in_both_modes(scene, TOLERANCE);
}

#[test]
fn soft_discs_around_a_wide_spot() {
    let mut scene = wide_spot(vec![material(Transfer::Filter)]);
    scene.particles = around(100, 2, 1);
    in_both_modes(scene, EDGED);
}

#[test]
fn every_shape_around_a_lamp() {
    let mut scene = lamp(shapes());
    scene.particles = around(24, 3, 4);
    in_both_modes(scene, EDGED);
}

#[test]
fn every_shape_around_a_wide_spot() {
    let mut scene = wide_spot(shapes());
    scene.particles = around(24, 4, 4);
    in_both_modes(scene, EDGED);
}

#[test]
fn a_disc_beside_the_lamp_left_out_is_noticed() {
    let mut scene = lamp(vec![Material { profile: Profile::Flat, ..material(Transfer::Filter) }]);
    scene.particles =
        vec![particle(Vec3::new(0.2, 1.0, 0.002), 0.5, Vec4::new(0.0, 0.0, 0.0, 0.9))];
    assert_agrees(&scene, EDGED);
    let views = shadow_views(&scene);
    let dark = |view| render(&scene, view).iter().filter(|texel| texel.filter[0] < 0.5).count();
    let dark: Vec<_> = views.iter().map(dark).collect();
    assert!(dark.iter().filter(|&&texels| texels > 200).count() == 5, "{dark:?}");
    let without = Scene { particles: Vec::new(), ..scene.clone() };
    let (maps, _) = render_maps(&without, &views);
    for (view, maps) in views.iter().zip(&maps).filter(|(view, _)| view.name != "nx") {
        assert!(compare_maps(&render(&scene, view), maps, EDGED).is_err(), "{}", view.name);
    }
}

/// Maps of the CPU reference and of both tiers.
fn all_maps(scene: &Scene) -> Vec<Vec<ViewMaps>> {
    let mut all = vec![render_maps(scene, &shadow_views(scene)).0];
    all.extend(
        tiers(Tier::Core).into_iter().map(|tier| crate::common::map_frame(tier, scene).maps),
    );
    all
}

#[test]
fn a_lamp_in_a_puff_is_dimmed_all_around() {
    let black = Vec4::new(0.0, 0.0, 0.0, 0.9);
    for offset in [Vec3::ZERO, Vec3::splat(0.05), Vec3::X * 0.9] {
        let mut scene = lamp(vec![Material { shape: Shape::Puff, ..material(Transfer::Filter) }]);
        scene.particles = vec![particle(LAMP + offset, 1.0, black)];
        for maps in all_maps(&scene).into_iter().flatten() {
            let axis = maps.view.direction();
            let size = maps.view.size.x as usize;
            // The ray through the corner of the middle four texels is the axis.
            let at = size / 2 * size + size / 2;
            let slope = 0.5 * 2.0 / size as f32;
            let right = maps.view.view_from_world.row(0).truncate();
            let up = maps.view.view_from_world.row(1).truncate();
            let way = axis + right * slope - up * slope;
            let (way, near) = (way.normalize(), maps.view.near * way.length());
            let along = offset.dot(way);
            let leaves = along + (1.0 - offset.length_squared() + along * along).sqrt();
            let chord = leaves - near;
            let expected = 0.1_f32.powf(chord / 2.0);
            let name = maps.view.name;
            assert!((maps.filter[at][0] - expected).abs() < 1e-3, "{name}: {}", maps.filter[at][0]);
            let nearest = if 1.0 - expected < 1.0 / 255.0 { 1.0 } else { 0.0 };
            assert_eq!(maps.nearest[at], nearest, "{name}");
        }
    }
}

#[test]
fn a_puff_behind_the_plane_counts_where_it_reaches_in_front() {
    let mut scene = wide_spot(vec![Material { shape: Shape::Puff, ..material(Transfer::Filter) }]);
    scene.lights[0].kind =
        LightKind::Spot { position: LAMP, direction: Vec3::NEG_Y, angle: 120_f32.to_radians() };
    scene.particles =
        vec![particle(LAMP + Vec3::new(0.5, 0.2, 0.0), 0.6, Vec4::new(0.0, 0.0, 0.0, 0.9))];
    in_both_modes(scene.clone(), EDGED);
    let view = &shadow_views(&scene)[0];
    let reached = render(&scene, view).iter().filter(|texel| texel.filter[0] < 0.9).count();
    assert!(reached > 50, "{reached}");
}
