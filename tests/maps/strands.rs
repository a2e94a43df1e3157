//! Strands: the CPU reference and the kernels against 64 bits from the definition.
use crate::common::{
    Tier,
    brute_force::render,
    compare::{Tolerance, assert_maps_agree, compare_maps},
    scenes::{Chance, empty, hold_view, light, material, random_discs, triangle},
    tiers,
};
use gobo::{
    glam::{Vec3, Vec4},
    internals::{records::ViewMaps, reference::render_maps, view::shadow_views},
    model::{LightKind, Material, Shape, Strand, StrandVertex, Transfer},
    scene::Scene,
};

/// 16-bit colours, planes in 32 bits; depths in 32 bits.
const TOLERANCE: Tolerance = Tolerance { filter: 2e-3, depth: 1e-5, undecided: 0.1 };

pub(super) fn kinds() -> [LightKind; 3] {
    let position = Vec3::new(3.0, 4.0, 2.5);
    [
        LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() },
        LightKind::Spot { position, direction: -position.normalize(), angle: 0.9 },
        // Among them: every face of the cube sees some, and some cross its seams.
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
