//! Discs, quads and puffs at round positions: lamps in their centres, on their rims and corners, equal
//! depths, edges along rows of texels, quarter turns. Truth: the renderer in 64 bits.
use super::{
    brute_force::assert_agrees,
    curve::curved,
    curve_bounds::LIGHT_ROUNDING,
    round::Round,
    round_triangles::{assert_seen, camera, shining},
};
use crate::common::{
    TIERS,
    brute_force::{render, render_before},
    compare::Tolerance,
    map_frame,
    scenes::{empty, material, particle},
};
use gobo::{
    glam::{Vec3, Vec4},
    model::{Material, Particle, Pattern, Profile, Receiver, Shape, Transfer, View},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_reference::render_maps;
use gobo_scene::Scene;

/// Rays within a twentieth of a texel of an edge are left out: rounding decides on which side they pass. So
/// are depths within 1e-5 of the range, whose order rounding decides: `meet`'s margins.
const TOLERANCE: Tolerance = Tolerance { filter: 1e-3, depth: 1e-5, undecided: 0.25 };
/// Tolerance of a curve's light: that of the filter, and its own rounding.
const LIGHT: f64 = 1e-3 + LIGHT_ROUNDING as f64;

fn flat(transfer: Transfer, shape: Shape) -> Material {
    Material { shape, profile: Profile::Flat, ..material(transfer) }
}

fn points() -> Vec<Material> {
    vec![
        material(Transfer::Filter),
        flat(Transfer::Stain, Shape::Disc),
        flat(Transfer::Filter, Shape::Quad),
        Material { reflectivity: 0.5, ..flat(Transfer::Smoke, Shape::Quad) },
        flat(Transfer::Opaque, Shape::Disc),
    ]
}

fn solids() -> Vec<Material> {
    let dither = |pattern| Material { pattern, ..flat(Transfer::Dither, Shape::Disc) };
    vec![
        flat(Transfer::Opaque, Shape::Quad),
        // One below and one above the opacities 0.5 and 1.
        Material { cutoff: 0.75, ..flat(Transfer::Cutout, Shape::Quad) },
        dither(Pattern::Bayer4),
        dither(Pattern::Hashed),
        flat(Transfer::Stain, Shape::Puff),
    ]
}

fn bodies() -> Vec<Material> {
    let puff = |transfer| flat(transfer, Shape::Puff);
    vec![
        puff(Transfer::Filter),
        puff(Transfer::Smoke),
        flat(Transfer::Gain, Shape::Disc),
        Material { tint: Vec4::new(1.0, 0.5, 0.5, 0.5), ..flat(Transfer::Stain, Shape::Quad) },
        flat(Transfer::Opaque, Shape::Disc),
    ]
}

/// `count` casters around three lamps; each contains one of them.
fn scene(seed: u64, materials: Vec<Material>, count: u32) -> Scene {
    let mut round = Round::new(seed);
    let kinds = materials.len() as u32;
    let mut scene = empty(materials);
    let mut places = Vec::new();
    for id in 0..count {
        let (center, radius) = (round.place(2.0), round.half(0.5, 1.5));
        places.push(round.on_box(center, Vec3::splat(radius)));
        let rotation = round.turn();
        let material = id % kinds;
        let mut color = round.color();
        let Material { transfer, shape, .. } = scene.materials[material as usize];
        if transfer == Transfer::Dither {
            color.w = 1.0;
        } else if shape == Shape::Puff {
            // An opaque one is as dense as 32 bits can express: its rim is clear.
            color = color.max(Vec3::splat(0.5).extend(0.0)).with_w(0.5);
        }
        scene.particles.push(Particle {
            rotation,
            id,
            material,
            ..particle(center, radius, color)
        });
    }
    let size = round.one_of(&[32, 33]);
    scene.lights = round.lights(&places, size).into();
    scene
}

fn assert_in_both_modes(scene: &Scene) {
    assert_agrees(scene, TOLERANCE);
    assert_agrees(&curved(scene.clone(), 8), TOLERANCE);
}

#[test]
fn points_at_round_places() {
    for seed in 0..4 {
        assert_in_both_modes(&scene(seed, points(), 10));
    }
}

#[test]
fn bodies_at_round_places() {
    for seed in 10..14 {
        assert_in_both_modes(&scene(seed, bodies(), 10));
    }
}

#[test]
fn solids_at_round_places() {
    for seed in 20..24 {
        assert_in_both_modes(&scene(seed, solids(), 10));
    }
}

#[test]
fn over_at_round_places() {
    let materials = vec![material(Transfer::Over), flat(Transfer::Over, Shape::Quad)];
    for seed in 30..33 {
        assert_in_both_modes(&scene(seed, materials.clone(), 6));
    }
}

/// Asserts that the light along a view's curves is the truth's, at depths apart from all round positions.
fn assert_curves(scene: &Scene, view: &View, all: &[&ViewMaps]) {
    /// Depths are stored in sixteen bits.
    const MARGIN: f64 = 1e-4;
    let whole = render(scene, view);
    let mut compared = 0;
    for depth in [0.1371, 0.3137, 0.5613, 0.7713] {
        let around = [-MARGIN, MARGIN].map(|off| render_before(scene, view, depth + off));
        for (texel, whole) in whole.iter().enumerate() {
            let [low, high] = around.each_ref().map(|around| &around[texel]);
            if low.undecided || high.undecided || whole.opaque < depth + MARGIN {
                continue;
            }
            for maps in all {
                let curve = maps.curve.as_ref().unwrap();
                let found = curve.light_at(texel, depth as f32).as_dvec3().to_array();
                for (i, found) in found.into_iter().enumerate() {
                    let (low, high) = (low.filter[i], high.filter[i]);
                    let is_right = found >= low.min(high) - LIGHT && found <= low.max(high) + LIGHT;
                    assert!(is_right, "{} {texel} {depth}: {found}, {low} {high}", view.name);
                }
                compared += 1;
            }
        }
    }
    assert!(compared > 0);
}

#[test]
fn curves_of_points_at_round_places() {
    for seed in 40..44 {
        let scene = curved(scene(seed, points(), 8), 8);
        assert_eq!(scene.shadow.receiver, Receiver::Curve);
        let views = shadow_views(&scene);
        let mut all = vec![render_maps(&scene, &views).0];
        all.extend(TIERS.map(|tier| map_frame(tier, &scene).maps));
        for (i, view) in views.iter().enumerate() {
            let maps: Vec<_> = all.iter().map(|maps| &maps[i]).collect();
            assert_curves(&scene, view, &maps);
        }
    }
}

#[test]
fn pictures_of_particles_from_round_places() {
    let mut filled = 0;
    for seed in 50..54 {
        let mut round = Round::new(seed);
        let mut scene = shining(camera(&mut round));
        let shape = |i| if i == 0 { Shape::Disc } else { Shape::Quad };
        for (i, material) in scene.materials.iter_mut().enumerate() {
            (material.shape, material.profile) = (shape(i), Profile::Flat);
        }
        for id in 0..9 {
            let (center, radius) = (round.place(2.5), round.half(0.5, 1.0));
            let rotation = round.turn();
            scene.particles.push(Particle {
                id,
                rotation,
                material: id % 3,
                ..particle(center, radius, Vec4::ONE)
            });
        }
        filled += assert_seen(&scene);
    }
    assert!(filled > 1000, "{filled}");
}
