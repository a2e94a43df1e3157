//! Softening with curves: the CPU reference against closed forms, kernels against the CPU reference.
use crate::common::{
    TIERS, map_frame,
    scenes::{empty, flat_view, light, material, pane, particle},
};
use gobo::{
    glam::{Vec3, Vec4},
    model::{LightKind, Material, Pattern, Profile, Receiver, Shape, Transfer, dither::window},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_reference::render_maps;
use gobo_scene::Scene;

/// Rounding of a light and its merges: three roundings of a channel.
const ROUNDING: f32 = 1e-3;

fn curved(mut scene: Scene, nodes: u32) -> Scene {
    scene.shadow.receiver = Receiver::Curve;
    scene.shadow.nodes = nodes;
    scene
}

fn gel(color: Vec3) -> Material {
    Material { tint: color.extend(1.0), ..material(Transfer::Filter) }
}

fn dithered(pattern: Pattern, tint: Vec4) -> Material {
    Material { pattern, tint, profile: Profile::Flat, ..material(Transfer::Dither) }
}

const FIRST: Vec3 = Vec3::new(0.8, 0.4, 0.2);
const LAST: Vec3 = Vec3::new(0.5, 0.9, 0.7);

/// A gel, a dithered pane of 25%, a gel.
fn stack(pattern: Pattern) -> Scene {
    let dithered = dithered(pattern, Vec4::new(0.0, 0.0, 0.0, 0.25));
    let mut scene = empty(vec![gel(FIRST), dithered, gel(LAST)]);
    for (depth, material) in [(0.2, 0), (0.5, 1), (0.7, 2)] {
        scene.triangles.extend(pane(depth, 100.0, material));
    }
    scene.shadow.soften = true;
    scene
}

/// Light in front of the dithered surface, behind it, and behind a further caster: a texel that the pattern
/// blocks has no light of its own there.
#[test]
fn light_is_exact_at_every_depth() {
    const SIZE: usize = 96;
    let expected = [
        (0.1, Vec3::ONE),
        (0.3, FIRST),
        (0.49, FIRST),
        (0.51, FIRST * 0.75),
        (0.69, FIRST * 0.75),
        (0.9, FIRST * 0.75 * LAST),
    ];
    for (pattern, nodes) in [(Pattern::Bayer2, 4), (Pattern::Bayer4, 8), (Pattern::Bayer8, 16)] {
        let scene = curved(stack(pattern), nodes);
        let maps = render_maps(&scene, &[flat_view(SIZE as u32, 1.0)]).0.remove(0);
        let curve = maps.curve.as_ref().unwrap();
        let edge = window(&scene.materials) as usize / 2;
        for y in edge..SIZE - edge {
            for x in edge..SIZE - edge {
                for (z, light) in expected {
                    let is = curve.light_at(y * SIZE + x, z);
                    let off = (is - light).abs().max_element();
                    assert!(off <= ROUNDING, "{pattern:?} {x} {y} at {z}: {is} for {light}");
                }
            }
        }
        // No dithered depth is left to block a receiver.
        assert!(maps.opaque.iter().all(|&depth| depth == 1.0));
    }
}

/// A slanted surface absorbs at its depth in each texel, not at its nearest point.
#[test]
fn a_slope_is_a_ramp_around_its_own_depth() {
    const SIZE: usize = 64;
    let mut scene = stack(Pattern::Bayer8);
    scene.triangles = pane(0.5, 100.0, 1).to_vec();
    for corner in scene.triangles.iter_mut().flat_map(|face| &mut face.positions) {
        corner.z += 0.1 * corner.x;
    }
    let scene = curved(scene, 8);
    let maps = render_maps(&scene, &[flat_view(SIZE as u32, 1.0)]).0.remove(0);
    let curve = maps.curve.as_ref().unwrap();
    for x in 8..SIZE - 8 {
        let own = 0.5 - 0.01 * (x as f32 + 0.5 - 0.5 * SIZE as f32);
        for y in 8..SIZE - 8 {
            // Half a window of 8 texels on either side.
            for (z, light) in [(own - 0.05, 1.0), (own, 0.875), (own + 0.05, 0.75)] {
                let is = curve.light_at(y * SIZE + x, z).x;
                assert!((is - light).abs() < 0.03, "{x} {y} at {z}: {is} for {light}");
            }
        }
    }
}

/// Gel, dithered discs and panes, a wall; a light whose six maps are neighbours in the atlas.
fn mixture(pattern: Pattern, transfer: Transfer) -> Scene {
    let mut scene = empty(vec![
        dithered(pattern, Vec4::new(0.9, 0.5, 0.2, 0.7)),
        Material { tint: Vec4::new(0.2, 0.9, 0.4, 0.5), ..material(transfer) },
        material(Transfer::Opaque),
    ]);
    scene.lights = vec![
        light(LightKind::Directional { direction: Vec3::NEG_Z }),
        light(LightKind::Point { position: Vec3::new(0.2, 0.3, 2.0) }),
    ];
    scene.lights[1].size = Some(48);
    for i in 0..12 {
        let center = Vec3::new(i as f32 * 0.2 - 1.0, 0.1, -0.3 - 0.15 * i as f32);
        let color = Vec4::new(0.5, 0.6, 0.7, 0.3 + 0.05 * i as f32);
        let disc = particle(center, 0.7, color);
        scene.particles.push(gobo::model::Particle { material: i % 2, id: i, ..disc });
    }
    scene.triangles.extend(pane(0.25, 0.8, 1));
    scene.triangles.extend(pane(0.5, 0.6, 2));
    scene.shadow.soften = true;
    scene
}

/// Three hits of a curve with four nodes, one of them a dense puff: the softening has a node of its own.
#[test]
fn a_dense_puff_leaves_a_node_to_the_softening() {
    const SIZE: usize = 64;
    let gel = gel(Vec3::splat(0.97));
    let dithered = dithered(Pattern::Bayer8, Vec4::new(0.0, 0.0, 0.0, 0.25));
    let puff = Material { shape: Shape::Puff, ..material(Transfer::Filter) };
    let mut scene = empty(vec![gel, dithered, puff]);
    for (depth, material) in [(0.2, 0), (0.22, 0), (0.95, 1)] {
        scene.triangles.extend(pane(depth, 100.0, material));
    }
    let soot = particle(Vec3::new(0.0, 0.0, -7.0), 1.0, Vec4::new(0.0, 0.0, 0.0, 0.95));
    scene.particles.push(gobo::model::Particle { material: 2, ..soot });
    scene.shadow.soften = true;
    let scene = curved(scene, 4);
    let maps = render_maps(&scene, &[flat_view(SIZE as u32, 30.0)]).0.remove(0);
    let curve = maps.curve.as_ref().unwrap();
    let middle = SIZE / 2 * SIZE + SIZE / 2;
    // Not in the middle of the gels, where a single ramp for both is right, too.
    for (z, light) in [(0.1, 1.0), (0.203, 0.97), (0.5, 0.9409), (0.9, 0.047), (0.97, 0.0353)] {
        let is = curve.light_at(middle, z).x;
        assert!((is - light).abs() <= ROUNDING, "{z}: {is} for {light}");
    }
}

/// Share of (texel, depth) whose light differs.
fn share_apart(a: &[ViewMaps], b: &[ViewMaps]) -> f64 {
    let (mut apart, mut count) = (0, 0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a.curve.as_ref().unwrap(), b.curve.as_ref().unwrap());
        for texel in 0..a.texel_count() {
            for i in 0..20 {
                let z = (i as f32 + 0.5) / 20.0;
                let off = (a.light_at(texel, z) - b.light_at(texel, z)).abs().max_element();
                apart += u32::from(off > 4e-3);
                count += 1;
            }
        }
    }
    f64::from(apart) / f64::from(count)
}

type Case = (Pattern, Transfer, bool, u32);

#[test]
fn gpu_matches_reference() {
    matches_reference(&[
        (Pattern::Bayer4, Transfer::Filter, false, 8),
        (Pattern::Hashed, Transfer::Filter, true, 8),
    ]);
}

#[test]
#[ignore = "kernels of other curves: make test-all"]
fn gpu_matches_reference_of_every_curve() {
    matches_reference(&[
        (Pattern::Blue, Transfer::Over, false, 4),
        (Pattern::Bayer8, Transfer::Gain, true, 16),
    ]);
}

fn matches_reference(cases: &[Case]) {
    for &(pattern, transfer, colored, nodes) in cases {
        let mut scene = curved(mixture(pattern, transfer), nodes);
        scene.shadow.colored = colored;
        let expected = render_maps(&scene, &shadow_views(&scene)).0;
        for tier in TIERS {
            let apart = share_apart(&map_frame(tier, &scene).maps, &expected);
            assert!(apart < 4e-3, "{pattern:?} {transfer:?} {tier:?}: {apart}");
        }
        scene.shadow.soften = false;
        let hard = render_maps(&scene, &shadow_views(&scene)).0;
        assert!(share_apart(&hard, &expected) > 4e-3, "{pattern:?}");
    }
}
