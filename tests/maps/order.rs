//! `over` in the order of each ray's hits, for any order of the casters. Truth: the renderer in 64 bits,
//! which sorts the hits of every texel.
use super::brute_force::assert_agrees;
use crate::common::{
    Tier,
    brute_force::render,
    compare::{Tolerance, compare_maps},
    scenes::{Chance, empty, light, material, particle, triangle},
    tiers,
};
use gobo::{
    glam::{Vec3, Vec4},
    model::{
        Counters, Light, LightKind, Material, Particle, Profile, Receiver, Transfer, Triangle,
    },
    view::shadow_views,
};
use gobo_reference::render_maps;
use gobo_scene::Scene;

const EDGED: Tolerance = Tolerance { filter: 2e-3, depth: 1e-5, undecided: 0.25 };
const RED: Vec4 = Vec4::new(1.0, 0.0, 0.0, 0.6);
const BLUE: Vec4 = Vec4::new(0.0, 0.0, 1.0, 0.6);

fn over(tint: Vec4) -> Material {
    Material { profile: Profile::Flat, tint, ..material(Transfer::Over) }
}

fn lit_by(kind: LightKind, materials: Vec<Material>) -> Scene {
    Scene { lights: vec![Light { size: Some(32), ..light(kind) }], ..empty(materials) }
}

fn sun() -> LightKind {
    LightKind::Directional { direction: Vec3::NEG_Y }
}

/// Two triangles around `center`.
fn pane(center: Vec3, x: Vec3, y: Vec3, material: u32) -> [Triangle; 2] {
    let [a, b, c, d] = [-x - y, x - y, x + y, y - x].map(|corner| center + corner);
    [[a, b, c], [a, c, d]].map(|positions| triangle(positions, material))
}

/// Checks both modes of a scene.
fn assert_ordered(scene: &Scene, tolerance: Tolerance) {
    let mut curves = scene.clone();
    curves.shadow.receiver = Receiver::Curve;
    for scene in [scene, &curves] {
        for counters in assert_agrees(scene, tolerance) {
            assert_eq!((counters.disordered, counters.unordered), (0, 0));
        }
    }
}

/// Counters of the kernels, and of the reference's curves; the reference's filters sort all hits of a ray.
fn all_counters(scene: &Scene) -> Vec<Counters> {
    let kernels =
        tiers(Tier::Native).into_iter().map(|tier| crate::common::map_frame(tier, scene).counters);
    let reference = scene.shadow.receiver == Receiver::Curve;
    kernels.chain(reference.then(|| render_maps(scene, &shadow_views(scene)).1)).collect()
}

/// A slanted blue pane whose nearest point is in front of a red one, and most of it behind.
fn slanted() -> Scene {
    let mut scene = lit_by(sun(), vec![over(RED), over(BLUE)]);
    let slope = Vec3::new(0.0, 1.0, -1.0).normalize();
    scene.triangles.extend(pane(Vec3::Y, Vec3::X, slope * 2.0, 1));
    scene.triangles.extend(pane(Vec3::new(0.0, 1.6, 0.6), Vec3::X * 0.5, Vec3::Z * 0.5, 0));
    scene
}

#[test]
fn a_slanted_pane_is_behind_where_it_is_behind() {
    assert_ordered(&slanted(), EDGED);
}

#[test]
fn panes_in_the_other_order_are_noticed() {
    let scene = slanted();
    let mut lower = scene.clone();
    for triangle in &mut lower.triangles[2..] {
        triangle.positions = triangle.positions.map(|corner| corner - Vec3::Y * 1.4);
    }
    let view = &shadow_views(&scene)[0];
    let (maps, _) = render_maps(&lower, std::slice::from_ref(view));
    assert!(compare_maps(&render(&scene, view), &maps[0], EDGED).is_err());
}

/// Soft smoke of discs of 0.1 to 0.3 m around the light.
fn smoke(kind: LightKind, count: u32) -> Scene {
    let soft = Material { profile: Profile::Soft, ..over(Vec4::ONE) };
    let mut scene = lit_by(kind, vec![soft]);
    let mut chance = Chance::new(11);
    let discs = (0..count).map(|id| {
        let center = chance.vec3(-1.0, 1.0);
        let color = chance.vec3(0.0, 1.0).round().extend(chance.within(0.2, 0.7));
        Particle { id, ..particle(center, chance.within(0.1, 0.3), color) }
    });
    scene.particles = discs.collect();
    scene
}

#[test]
fn smoke_around_a_point_light_is_in_order_on_all_faces() {
    assert_ordered(&smoke(LightKind::Point { position: Vec3::ZERO }, 250), EDGED);
}

#[test]
fn smoke_in_a_spot_is_in_order() {
    let (position, direction) = (Vec3::new(0.3, 2.5, 0.2), Vec3::NEG_Y);
    assert_ordered(&smoke(LightKind::Spot { position, direction, angle: 1.2 }, 250), EDGED);
}

/// One large triangle across the sun, `tilt` [m] higher at one end.
fn tilted(height: f32, tilt: f32, material: u32) -> Triangle {
    let corner = |x: f32, z: f32| Vec3::new(x, height + tilt * x / 6.0, z);
    triangle([corner(-6.0, -6.0), corner(6.0, -6.0), corner(0.0, 9.0)], material)
}

#[test]
fn hits_on_both_sides_of_a_segments_end_are_in_order() {
    let haze = over(Vec4::new(0.5, 0.5, 0.5, 1e-5));
    let mut scene = lit_by(sun(), vec![over(RED), over(BLUE), haze]);
    scene.lights[0].size = Some(16);
    // All pairs of the first segment except one.
    for id in 0..2047 {
        let center = Vec3::new(0.0, 8.0 + id as f32 * 1e-3, 0.0);
        scene.particles.push(Particle { id, material: 2, ..particle(center, 20.0, Vec4::ONE) });
    }
    // Its last pair is in front at one end of the map, and behind the next pair at the other.
    scene.triangles = vec![tilted(4.0, 3.0, 1), tilted(4.0, 0.0, 0)];
    let (_, counters) = render_maps(&scene, &shadow_views(&scene));
    assert_eq!((counters.pairs, counters.segments), (2049, 2));
    assert_ordered(&scene, EDGED);
}

#[test]
fn hits_whose_place_is_lost_are_counted() {
    let mut scene = lit_by(sun(), vec![over(RED), over(BLUE)]);
    for i in 0..12 {
        scene.triangles.push(tilted(4.0 + i as f32 * 0.01, 3.0, 1));
    }
    scene.triangles.push(tilted(4.0, 0.0, 0));
    for receiver in [Receiver::Nearest, Receiver::Curve] {
        scene.shadow.receiver = receiver;
        for counters in all_counters(&scene) {
            assert!(counters.disordered > 0 && counters.unordered == 0, "{counters:?}");
        }
    }
}
