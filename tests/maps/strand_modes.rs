//! Strands of every transfer, in depth, and in every path of the kernels.
use super::{
    forms::assert_forms_agree,
    gaussian_curves::ray,
    parts::{assert_budget_does_not_matter, assert_same},
    strands::{all_maps, assert_agrees, hair, kinds, lit_by},
};
use crate::common::{
    Tier,
    compare::Tolerance,
    gpu,
    scenes::{light, material, random_discs},
    strand_truth::meet,
    tiers,
};
use gobo::{
    Casters, Error, Shadows,
    glam::{DVec3, Vec3, Vec4},
    model::{Material, Projection, Receiver, Strand, Transfer, View},
    records::{ViewMaps, curve::light_at},
    view::shadow_views,
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::Scene;

const DEPTHS: u32 = 24;

/// Light that passes all strands in front of light depth `depth`.
pub(super) fn passed(scene: &Scene, view: &View, texel: [u32; 2], depth: f64) -> DVec3 {
    let (start, way, [near, far]) = ray(view, texel);
    let ends = [near, near + depth * (far - near)];
    let least = |point: DVec3| {
        let along = -view.view_from_world.as_dmat4().transform_point3(point).z;
        let is_parallel = view.projection == Projection::Orthographic;
        let distance = if is_parallel { 1.0 } else { along };
        std::f64::consts::FRAC_1_SQRT_2 * distance / f64::from(view.scale)
    };
    let is_near = |strand: &&Strand| {
        let bounds = strand.bounds();
        let (center, reach) = (bounds.center().as_dvec3(), f64::from(bounds.radius()));
        let apart = (center - start).cross(way).length() / way.length();
        apart <= reach + 2.0 * least(center)
    };
    let strands = scene.strands.iter().filter(is_near);
    let met = strands.flat_map(|strand| {
        let tint = scene.materials[strand.material as usize].tint;
        let met = meet(strand, start, way, ends, least);
        met.into_iter().filter_map(move |met| Some((met.way?, (met.color * tint).as_dvec4())))
    });
    met.fold(DVec3::ONE, |light, (way, color)| {
        let of_diameter = DVec3::ONE - color.w * (DVec3::ONE - color.truncate());
        light * of_diameter.map(|passed| way.passed(passed))
    })
}

fn mean_error(scene: &Scene, maps: &ViewMaps) -> f64 {
    let curve = maps.curve.as_ref().expect("curve mode");
    let nodes = curve.nodes;
    let (mut sum, mut count) = (0.0, 0.0);
    for y in (3..maps.view.size.y).step_by(9) {
        for x in (2..maps.view.size.x).step_by(7) {
            let at = (y * maps.view.size.x + x) as usize;
            let packed = &curve.packed[at * nodes..(at + 1) * nodes];
            for i in 0..DEPTHS {
                let depth = (f64::from(i) + 0.37) / f64::from(DEPTHS);
                let found = light_at(packed, depth as f32, false).as_dvec3();
                let expected = passed(scene, &maps.view, [x, y], depth);
                (sum, count) = (sum + (found - expected).abs().max_element(), count + 1.0);
            }
        }
    }
    sum / count
}

#[test]
fn curves_of_strands_agree_in_the_mean() {
    for kind in kinds() {
        let mut scene = lit_by(kind, vec![hair(Transfer::Filter)], 60);
        scene.shadow.receiver = Receiver::Curve;
        for maps in all_maps(&scene) {
            for maps in &maps {
                let mean = mean_error(&scene, maps);
                assert!(mean <= 4e-3, "{kind:?}: {mean}");
            }
        }
    }
}

/// Intersecting strands and discs, under lights of all kinds.
fn mixture() -> Scene {
    let mut scene = lit_by(kinds()[2], vec![hair(Transfer::Filter), material(Transfer::Smoke)], 60);
    scene.lights.push(light(kinds()[0]));
    scene.particles = random_discs(100, 12);
    scene.particles.iter_mut().for_each(|particle| particle.material = 1);
    scene
}

#[test]
fn strands_past_the_budget_change_nothing() {
    let mut scene = mixture();
    scene.shadow.size = 96;
    assert_budget_does_not_matter("strands", &scene);
    scene.shadow.receiver = Receiver::Curve;
    assert_budget_does_not_matter("strands", &scene);
}

#[test]
fn forms_of_strands_agree() {
    for receiver in [Receiver::Nearest, Receiver::Curve] {
        let mut scene = mixture();
        scene.shadow.size = 64;
        scene.shadow.receiver = receiver;
        assert_forms_agree("strands", &scene);
    }
}

#[test]
fn opaque_strands_block_where_they_are() {
    for kind in kinds() {
        let scene = lit_by(kind, vec![hair(Transfer::Opaque)], 40);
        assert_agrees(&scene, Tolerance { filter: 0.0, depth: 1e-5, undecided: 0.2 });
    }
}

/// Except where rounding decides, both sides dither and cut out alike.
#[test]
fn dithered_and_cut_out_strands_agree() {
    for transfer in [Transfer::Dither, Transfer::Cutout] {
        for kind in kinds() {
            let mut scene = lit_by(kind, vec![Material { cutoff: 0.3, ..hair(transfer) }], 40);
            scene.shadow.size = 64;
            let all = all_maps(&scene);
            for (found, expected) in all[1..].iter().flat_map(|maps| maps.iter().zip(&all[0])) {
                let pairs = found.opaque.iter().zip(&expected.opaque);
                let apart = pairs.filter(|(a, b)| (**a - **b).abs() > 1e-4).count();
                assert!(apart * 200 <= found.opaque.len(), "{transfer:?}: {apart}");
                assert!(expected.opaque.iter().any(|&depth| depth < 1.0));
            }
        }
    }
}

#[test]
fn changed_strands_are_uploaded() {
    for tier in tiers(Tier::Native) {
        let options = RenderOptions { maps: true, maps_only: true, ..RenderOptions::default() };
        let mut renderer = Renderer::on(gpu(tier)).unwrap();
        let mut scene = mixture();
        renderer.render(&scene, &options).unwrap();
        for strand in scene.strands.iter_mut().step_by(7) {
            strand.vertices[1].position.y += 0.1;
            strand.vertices[0].color = Vec4::new(0.1, 0.9, 0.2, 0.8);
        }
        let updated = renderer.render(&scene, &options).unwrap();
        let fresh = Renderer::on(gpu(tier)).unwrap().render(&scene, &options).unwrap();
        assert_same(&updated.maps, &fresh.maps, "after an update");
    }
}

#[test]
fn invalid_strands_are_errors_that_name_them() {
    let gpu = gpu(Tier::Core);
    let mut shadows = crate::common::shadows(&gpu);
    let materials = [hair(Transfer::Filter), material(Transfer::Filter)];
    let valid = lit_by(kinds()[0], materials.to_vec(), 1).strands.remove(0);
    let with = |change: &dyn Fn(&mut Strand)| {
        let mut strand = valid.clone();
        change(&mut strand);
        strand
    };
    let wrong = [
        with(&|strand| strand.vertices.truncate(1)),
        with(&|strand| strand.vertices[0].position = Vec3::NAN),
        with(&|strand| strand.vertices[0].radius = -1.0),
        with(&|strand| strand.vertices[1].color.w = 1.5),
        with(&|strand| strand.vertices[1].position = Vec3::splat(2e7)),
        with(&|strand| strand.material = 1),
        with(&|strand| strand.material = 9),
    ];
    let mut prepare = |strands: &[Strand]| {
        let casters = Casters { strands, materials: &materials, ..Casters::default() };
        let scene = lit_by(kinds()[0], materials.to_vec(), 1);
        let settings = scene.shadow;
        Shadows::prepare(&mut shadows, &casters, &shadow_views(&scene), &settings).map(|_| ())
    };
    assert!(prepare(std::slice::from_ref(&valid)).is_ok());
    for strand in wrong {
        let error = prepare(&[valid.clone(), strand.clone()]).unwrap_err();
        assert!(matches!(error, Error::Invalid { index: 1, .. }), "{strand:?}: {error}");
    }
}
