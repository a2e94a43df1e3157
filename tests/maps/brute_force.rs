//! The CPU reference and the kernels against a renderer in 64 bits that shares no code with them.
use crate::common::{
    TIERS,
    brute_force::render,
    compare::{Tolerance, assert_maps_agree, compare_maps},
    gpu,
    rounding::{DECODED, on},
    scenes::{Chance, empty, light, material, random_discs, triangle},
};
use gobo::{
    glam::{Vec3, Vec4},
    model::{Counters, LightKind, Material, Profile, Shape, Texture, Transfer},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_reference::render_maps;
use gobo_scene::Scene;

const TOLERANCE: Tolerance = Tolerance { filter: 1e-3, depth: 1e-5, undecided: 0.0 };

fn directional() -> LightKind {
    LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() }
}

fn spot() -> LightKind {
    let position = Vec3::new(3.0, 4.0, 2.5);
    LightKind::Spot { position, direction: -position.normalize(), angle: 0.9 }
}

/// A light among the casters: every face of the cube sees some.
fn point() -> LightKind {
    LightKind::Point { position: Vec3::new(0.1, 0.2, -0.1) }
}

fn lit_by(kind: LightKind, materials: Vec<Material>) -> Scene {
    Scene { lights: vec![light(kind)], ..empty(materials) }
}

pub(super) fn assert_agrees(scene: &Scene, tolerance: Tolerance) -> Vec<Counters> {
    let views = shadow_views(scene);
    let truth: Vec<_> = views.iter().map(|view| render(scene, view)).collect();
    let agree = |maps: &[ViewMaps], tolerance: Tolerance| {
        assert_eq!(maps.len(), truth.len());
        truth.iter().zip(maps).for_each(|(truth, maps)| assert_maps_agree(truth, maps, tolerance));
    };
    let (maps, counters) = render_maps(scene, &views);
    agree(&maps, tolerance);
    let mut all = vec![counters];
    for tier in TIERS {
        let frame = crate::common::map_frame(tier, scene);
        let of_images = if scene.textures.is_empty() { 0.0 } else { on(&gpu(tier), DECODED) };
        agree(&frame.maps, Tolerance { filter: tolerance.filter + of_images, ..tolerance });
        all.push(frame.counters);
    }
    all
}

/// Moves particles away that are too close to a point light for a flat hit.
fn clear_of(scene: &mut Scene, position: Vec3) {
    for particle in &mut scene.particles {
        let way = particle.center - position;
        let least = 3.0 * particle.radius + 0.3;
        if way.length() < least {
            particle.center = position + way.normalize_or(Vec3::X) * least;
        }
    }
}

fn discs(kind: LightKind) -> Scene {
    let mut scene = lit_by(kind, vec![material(Transfer::Filter)]);
    scene.particles = random_discs(1000, 1);
    if let LightKind::Point { position } = kind {
        clear_of(&mut scene, position);
    }
    scene
}

#[test]
fn soft_discs_of_a_directional_light() {
    assert_agrees(&discs(directional()), TOLERANCE);
}

#[test]
fn soft_discs_of_a_spot() {
    assert_agrees(&discs(spot()), TOLERANCE);
}

#[test]
fn soft_discs_of_a_point_light() {
    assert_agrees(&discs(point()), TOLERANCE);
}

#[test]
fn one_disc_left_out_is_noticed() {
    let scene = discs(spot());
    let view = &shadow_views(&scene)[0];
    let expected = render(&scene, view);
    let mut fewer = scene.clone();
    let seen = |p: &gobo::model::Particle| p.radius > 0.1 && p.color.w > 0.1;
    fewer.particles.remove(scene.particles.iter().position(seen).expect("a large disc"));
    let (maps, _) = render_maps(&fewer, std::slice::from_ref(view));
    assert!(compare_maps(&expected, &maps[0], TOLERANCE).is_err());
}

#[test]
fn a_wrong_depth_is_noticed() {
    let scene = discs(spot());
    let view = &shadow_views(&scene)[0];
    let expected = render(&scene, view);
    let (mut maps, _) = render_maps(&scene, std::slice::from_ref(view));
    let seen = maps[0].nearest.iter().position(|&d| d < 1.0).expect("a hit");
    maps[0].nearest[seen] += 1e-4;
    assert!(compare_maps(&expected, &maps[0], TOLERANCE).is_err());
    maps[0].nearest[seen] -= 1e-4;
    maps[0].opaque[seen] = 0.5;
    assert!(compare_maps(&expected, &maps[0], TOLERANCE).is_err());
}

/// Patches of random colours, with opacities from `least` on; lower ones become transparent.
fn checkered(chance: &mut Chance, least: u8) -> Texture {
    let mut rgba: Vec<u8> = (0..4 * 6 * 4).map(|_| chance.below(256) as u8).collect();
    for alpha in rgba.iter_mut().skip(3).step_by(4).filter(|alpha| **alpha < 96) {
        *alpha = least;
    }
    Texture { name: "patches".into(), width: 6, height: 4, rgba }
}

/// Rotated textured quads, flat discs and puffs of all commutative transfers, opaque and translucent
/// triangles.
fn mixture(kind: LightKind) -> Scene {
    let tint = Vec4::new(0.9, 0.8, 0.7, 0.6);
    let quad = Material {
        shape: Shape::Quad,
        texture: Some(0),
        reflectivity: 0.1,
        tint,
        ..material(Transfer::Filter)
    };
    let flat = Material { profile: Profile::Flat, tint, ..material(Transfer::Stain) };
    let smoke = Material { tint, ..material(Transfer::Smoke) };
    let puff = Material { shape: Shape::Puff, tint, ..material(Transfer::Filter) };
    // Transparent texels of a reflecting material would show its colour.
    let glass = Material { texture: Some(1), reflectivity: 0.0, ..quad.clone() };
    let wall = material(Transfer::Opaque);
    let mut scene = lit_by(kind, vec![quad, flat, smoke, puff, glass, wall]);
    let mut chance = Chance::new(7);
    scene.textures.extend([96, 0].map(|least| checkered(&mut chance, least)));
    scene.particles = random_discs(80, 11);
    for particle in &mut scene.particles {
        particle.material = chance.below(4) as u32;
        particle.radius = particle.radius.max(0.03);
    }
    for i in 0..16 {
        let center = chance.vec3(-1.5, 1.5);
        let positions = [0; 3].map(|_| center + chance.vec3(-0.6, 0.6));
        scene.triangles.push(triangle(positions, 4 + u32::from(i % 4 == 0)));
    }
    if let LightKind::Point { position } = kind {
        clear_of(&mut scene, position);
    }
    scene
}

const EDGED: Tolerance = Tolerance { undecided: 0.25, ..TOLERANCE };

#[test]
fn a_mixture_of_a_directional_light() {
    assert_agrees(&mixture(directional()), EDGED);
}

#[test]
fn a_mixture_of_a_spot() {
    assert_agrees(&mixture(spot()), EDGED);
}

#[test]
fn a_triangle_left_out_is_noticed() {
    let scene = mixture(spot());
    let view = &shadow_views(&scene)[0];
    let expected = render(&scene, view);
    for out in [0, 1] {
        let mut fewer = scene.clone();
        fewer.triangles.remove(out);
        let (maps, _) = render_maps(&fewer, std::slice::from_ref(view));
        assert!(compare_maps(&expected, &maps[0], EDGED).is_err(), "triangle {out}");
    }
}
