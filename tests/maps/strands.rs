//! Strands: the CPU reference and the kernels against the definition in 64 bits.
use crate::common::{
    Tier,
    brute_force::render,
    compare::{Tolerance, compare_maps},
    scenes::{Chance, empty, hold_view, light, material, random_discs, triangle},
    tiers,
};
use gobo::{
    glam::{Vec3, Vec4},
    model::{LightKind, Material, Shape, Strand, StrandVertex, Transfer},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_reference::render_maps;
use gobo_scene::Scene;

/// 16-bit colours, planes in 32 bits; depths in 32 bits.
const TOLERANCE: Tolerance = Tolerance { filter: 2e-3, depth: 1e-5, undecided: 0.1 };

pub(super) fn kinds() -> [LightKind; 3] {
    let position = Vec3::new(3.0, 4.0, 2.5);
    [
        LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() },
        LightKind::Spot { position, direction: -position.normalize(), angle: 0.9 },
        // Among the strands: every face of the cube sees some, and some cross its seams.
        LightKind::Point { position: Vec3::new(0.1, 0.2, -0.1) },
    ]
}

pub(super) fn hair(transfer: Transfer) -> Material {
    Material { shape: Shape::Capsule, ..material(transfer) }
}

/// Curved strands around the origin, far thinner than a texel to several texels thick, some with a tip.
pub(super) fn random_strands(count: u32, seed: u64) -> Vec<Strand> {
    let mut chance = Chance::new(seed);
    let one = |id| {
        let mut position = chance.vec3(-1.6, 1.6);
        let mut way = chance.vec3(-1.0, 1.0).normalize_or(Vec3::X);
        let mut radius = 0.002 * 50.0_f32.powf(chance.unit());
        let vertices = (0..2 + chance.below(6)).map(|_| {
            let color = chance.vec3(0.0, 1.0).extend(chance.unit());
            let vertex = StrandVertex { position, radius, color };
            position += way * chance.within(0.1, 0.5);
            way = (way + chance.vec3(-0.5, 0.5)).normalize_or(Vec3::Y);
            radius *= chance.within(0.8, 1.1);
            vertex
        });
        let mut vertices: Vec<_> = vertices.collect();
        if id % 3 == 0 {
            vertices.last_mut().expect("at least two").radius = 0.0;
        }
        Strand { vertices, material: 0, id }
    };
    (0..count).map(one).collect()
}

pub(super) fn lit_by(kind: LightKind, materials: Vec<Material>, count: u32) -> Scene {
    let mut scene = empty(materials);
    scene.shadow.size = 128;
    scene.lights.push(light(kind));
    scene.strands = random_strands(count, 3);
    scene
}

pub(super) fn all_maps(scene: &Scene) -> Vec<Vec<ViewMaps>> {
    let mut all = vec![render_maps(scene, &shadow_views(scene)).0];
    let kernels = tiers(Tier::Native).into_iter();
    all.extend(kernels.map(|tier| crate::common::map_frame(tier, scene).maps));
    all
}

pub(super) fn assert_agrees(scene: &Scene, tolerance: Tolerance) {
    let views = shadow_views(scene);
    let truth: Vec<_> = views.iter().map(|view| render(scene, view)).collect();
    for (who, maps) in all_maps(scene).iter().enumerate() {
        for (truth, maps) in truth.iter().zip(maps) {
            if let Err(wrong) = compare_maps(truth, maps, tolerance) {
                panic!("renderer {who}: {wrong}");
            }
        }
    }
}

#[test]
fn strands_agree_with_their_definition() {
    for kind in kinds() {
        assert_agrees(&lit_by(kind, vec![hair(Transfer::Filter)], 50), TOLERANCE);
    }
}

/// All commuting transfers, with discs, a pane of glass and opaque triangles.
#[test]
fn strands_mix_with_all_other_casters() {
    for kind in kinds() {
        let glass = Material { tint: Vec4::new(0.9, 0.5, 0.3, 0.7), ..material(Transfer::Filter) };
        let materials = vec![
            hair(Transfer::Filter),
            hair(Transfer::Stain),
            hair(Transfer::Smoke),
            material(Transfer::Filter),
            glass,
            material(Transfer::Opaque),
        ];
        let mut scene = lit_by(kind, materials, 24);
        for (strand, material) in scene.strands.iter_mut().zip((0..3).cycle()) {
            strand.material = material;
        }
        scene.particles = random_discs(40, 11);
        scene.particles.retain(|p| p.center.distance(Vec3::new(0.1, 0.2, -0.1)) > 0.8);
        scene.particles.iter_mut().for_each(|p| p.material = 3);
        let mut chance = Chance::new(9);
        for i in 0..6 {
            let center = chance.vec3(-1.5, 1.5);
            let positions = [0; 3].map(|_| center + chance.vec3(-0.6, 0.6));
            scene.triangles.push(triangle(positions, 4 + u32::from(i % 3 == 0)));
        }
        assert_agrees(&scene, Tolerance { undecided: 0.3, ..TOLERANCE });
    }
}

#[test]
fn a_strand_left_out_or_moved_is_noticed() {
    let scene = lit_by(kinds()[1], vec![hair(Transfer::Filter)], 50);
    let view = &shadow_views(&scene)[0];
    let expected = render(&scene, view);
    let differs = |scene: &Scene| {
        let (maps, _) = render_maps(scene, std::slice::from_ref(view));
        compare_maps(&expected, &maps[0], TOLERANCE).is_err()
    };
    assert!(!differs(&scene));
    let mut fewer = scene.clone();
    fewer.strands.pop();
    assert!(differs(&fewer));
    let mut moved = scene.clone();
    moved.strands[7].vertices[1].position.x += 0.05;
    assert!(differs(&moved));
}

/// The same straight strand, tapered, in one piece and in many: thick, and thinner than a texel.
#[test]
fn a_strand_in_pieces_is_the_same_strand() {
    for (kind, radius) in kinds().into_iter().flat_map(|kind| [(kind, 0.08), (kind, 0.002)]) {
        let pieces = |count: u32| {
            let mut scene = empty(vec![hair(Transfer::Filter), material(Transfer::Opaque)]);
            scene.shadow.size = 128;
            scene.lights.push(light(kind));
            hold_view(&mut scene, 1);
            let [from, to] = [Vec3::new(-1.2, -0.9, 0.6), Vec3::new(0.9, 0.7, -0.8)];
            let vertex = |i: u32| {
                let t = i as f32 / count as f32;
                let color = Vec4::new(0.2, 0.5, 0.8, 0.7);
                StrandVertex { position: from.lerp(to, t), radius: radius * (1.0 - 0.5 * t), color }
            };
            let vertices = (0..=count).map(vertex).collect();
            scene.strands.push(Strand { vertices, material: 0, id: 1 });
            all_maps(&scene)
        };
        let whole = pieces(1);
        for count in [2, 50] {
            for (found, expected) in pieces(count).iter().flatten().zip(whole.iter().flatten()) {
                for (found, expected) in found.filter.iter().zip(&expected.filter) {
                    let apart = (Vec3::from_array(*found) - Vec3::from_array(*expected)).abs();
                    // Filters in half floats; sums of 50 pieces in fixed point.
                    assert!(
                        apart.max_element() <= 2e-3,
                        "{count}, {radius}: {found:?} {expected:?}"
                    );
                }
            }
        }
    }
}

/// Thinner than a texel: the sum of the shadow is the strand's own, its length times the mean over its width.
#[test]
fn strands_below_a_texel_conserve_light() {
    for (texels, alpha) in [(0.05, 1.0), (0.3, 1.0), (0.3, 0.4), (0.7, 0.9), (3.0, 0.5)] {
        let mut scene = empty(vec![hair(Transfer::Filter), material(Transfer::Opaque)]);
        let mut axis = light(LightKind::Directional { direction: Vec3::NEG_Z });
        axis.size = Some(256);
        scene.lights.push(axis);
        hold_view(&mut scene, 1);
        let texel = 1.0 / shadow_views(&scene)[0].scale;
        let mut length = 0.0;
        // Each crosses whole rows of texels, at all offsets alike.
        for i in 1..16 {
            let y = (i as f32 - 8.0) * 14.37;
            let ends = [Vec3::new(-100.0, y - i as f32, 0.0), Vec3::new(90.0, y, 30.0)];
            let color = Vec4::new(0.0, 0.0, 0.0, alpha);
            let vertex =
                |end: Vec3| StrandVertex { position: end * texel, radius: texels * texel, color };
            scene.strands.push(Strand { vertices: ends.map(vertex).to_vec(), material: 0, id: i });
            length += f64::from((ends[1] - ends[0]).truncate().length());
        }
        // Each ray's path is longer by 1 / sine than straight across.
        let lengthened = f64::from((190.0_f32.hypot(30.0)) / 190.0);
        let passed = 1.0 - f64::from(alpha).min(1.0 - 1e-9);
        let mean = (0..4000).map(|i| {
            let x = (f64::from(i) + 0.5) / 4000.0;
            1.0 - passed.powf((1.0 - x * x).sqrt() * lengthened)
        });
        let expected = length * 2.0 * f64::from(texels) * mean.sum::<f64>() / 4000.0;
        for maps in all_maps(&scene) {
            let shadow: f64 = maps[0].filter.iter().map(|f| 1.0 - f64::from(f[0])).sum();
            let share = shadow / expected;
            assert!((share - 1.0).abs() < 0.01, "{texels}, {alpha}: {share}");
        }
    }
}
