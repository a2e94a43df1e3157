//! Gaussians of every transfer and in every path of the kernels.
use super::{
    forms::assert_forms_agree,
    gaussians::{all_maps, assert_agrees, kinds, lit_by, medium, splats},
    parts::{assert_budget_does_not_matter, assert_same},
};
use crate::common::{
    Tier,
    compare::Tolerance,
    gpu, map_frame, map_frame_scattered,
    scenes::{empty, hold_view, light, material, random_discs},
    tiers,
};
use gobo::{
    Casters, Error, Shadows,
    glam::{Quat, Vec3, Vec4},
    model::{Gaussian, LightKind, Material, Particle, Receiver, Transfer},
    view::shadow_views,
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::Scene;

/// Intersecting splats, media and discs, under lights of all kinds.
fn mixture() -> Scene {
    let mut scene = lit_by(
        kinds()[2],
        vec![splats(Transfer::Filter), medium(2.0), material(Transfer::Smoke)],
        60,
    );
    scene.lights.push(light(kinds()[0]));
    for (gaussian, material) in scene.gaussians.iter_mut().zip((0..2).cycle()) {
        gaussian.material = material;
    }
    scene.particles = random_discs(200, 12);
    scene.particles.iter_mut().for_each(|particle| particle.material = 2);
    scene
}

#[test]
fn gaussians_past_the_budget_change_nothing() {
    let mut scene = mixture();
    scene.shadow.size = 96;
    assert_budget_does_not_matter("Gaussians", &scene);
    scene.shadow.receiver = Receiver::Curve;
    assert_budget_does_not_matter("Gaussians", &scene);
}

/// Casters without room for their pairs are scattered: each is rounded to a 65,536th of an optical depth.
#[test]
fn scattered_gaussians_are_the_same_up_to_rounding() {
    let mut scene = mixture();
    scene.shadow.pair_budget = 50;
    for tier in tiers(Tier::Native) {
        let scattered = map_frame_scattered(tier, &scene);
        assert!(scattered.counters.scattered > 0);
        let all = Scene {
            shadow: gobo::ShadowSettings { size: 128, ..empty(vec![]).shadow },
            ..scene.clone()
        };
        for (found, expected) in scattered.maps.iter().zip(&map_frame(tier, &all).maps) {
            assert_eq!(found.nearest, expected.nearest);
            for (found, expected) in found.filter.iter().zip(&expected.filter) {
                let apart = (Vec3::from_array(*found) - Vec3::from_array(*expected)).abs();
                assert!(apart.max_element() <= 2e-3, "{found:?} {expected:?}");
            }
        }
    }
}

#[test]
fn forms_of_gaussians_agree() {
    for receiver in [Receiver::Nearest, Receiver::Curve] {
        let mut scene = mixture();
        scene.shadow.size = 64;
        scene.shadow.receiver = receiver;
        assert_forms_agree("Gaussians", &scene);
    }
}

#[test]
fn gaussians_are_blended_in_order() {
    let over = Material { tint: Vec4::new(0.9, 0.6, 0.5, 0.7), ..splats(Transfer::Over) };
    for kind in kinds() {
        let mut scene = lit_by(kind, vec![over.clone(), splats(Transfer::Filter)], 30);
        for (gaussian, material) in scene.gaussians.iter_mut().zip((0..2).cycle()) {
            gaussian.material = material;
        }
        assert_agrees(&scene, Tolerance { filter: 3e-3, depth: 1e-5, undecided: 0.1 });
    }
}

/// A splat that blocks where its alpha is at least the cutoff: an ellipse.
#[test]
fn cut_out_gaussians_block_an_ellipse() {
    let cutout = Material { cutoff: 0.4, ..splats(Transfer::Cutout) };
    let mut scene = empty(vec![cutout, material(Transfer::Opaque)]);
    let mut axis = light(LightKind::Directional { direction: Vec3::NEG_Z });
    axis.size = Some(128);
    scene.lights.push(axis);
    hold_view(&mut scene, 1);
    let (long, short, turn) = (3.0_f32, 0.8_f32, 0.5_f32);
    scene.gaussians.push(Gaussian {
        sigma: Vec3::new(long, short, 0.2),
        rotation: Quat::from_rotation_z(turn),
        opacity: 0.9,
        ..Gaussian::default()
    });
    let reach = 2.0 * (0.9_f32 / 0.4).ln();
    for maps in all_maps(&scene) {
        let view = &maps[0].view;
        let half = 0.5 * view.size.x as f32;
        for (i, &opaque) in maps[0].opaque.iter().enumerate() {
            let texel = (i as u32 % view.size.x, i as u32 / view.size.x);
            let at = view.view_from_world.inverse().transform_point3(Vec3::new(
                (texel.0 as f32 + 0.5 - half) / view.scale,
                (half - texel.1 as f32 - 0.5) / view.scale,
                0.0,
            ));
            let own = Quat::from_rotation_z(-turn) * at.with_z(0.0);
            let q = (own.x / long).powi(2) + (own.y / short).powi(2);
            if (q - reach).abs() > 0.01 {
                assert_eq!(opaque < 1.0, q < reach, "{texel:?}: {opaque} at {q} of {reach}");
            }
        }
    }
}

/// Far beyond the contents of files: nothing is NaN, every tile gets its Gaussians, and both sides agree.
#[test]
fn extreme_gaussians_agree() {
    for kind in kinds() {
        let mut scene = lit_by(kind, vec![splats(Transfer::Filter), medium(0.5)], 20);
        let shapes = [
            (Vec3::new(40.0, 0.1, 30.0), 0.3),
            (Vec3::splat(30.0), 0.2),
            (Vec3::new(2.0, 1e-6, 2.0), 0.9),
            (Vec3::new(1.0, 1e-5, 1e-5), 1.0),
            (Vec3::splat(1e-7), 1.0),
            (Vec3::splat(1e-30), 1.0),
            (Vec3::new(1e6, 0.3, 1e6), 0.4),
        ];
        for (id, (sigma, opacity)) in shapes.into_iter().enumerate() {
            for material in 0..2 {
                let rotation = Quat::from_rotation_x(0.3 * id as f32);
                let center = Vec3::new(0.1, 0.2, -0.1) * (1.0 + material as f32);
                let color = Vec3::new(0.5, 0.2, 0.9);
                let id = id as u32;
                scene.gaussians.push(Gaussian {
                    center,
                    rotation,
                    sigma,
                    color,
                    opacity,
                    material,
                    id,
                });
            }
        }
        let all = all_maps(&scene);
        for maps in &all[1..] {
            for (found, expected) in maps.iter().zip(&all[0]) {
                let mut apart = 0;
                for (found, expected) in found.filter.iter().zip(&expected.filter) {
                    let (found, expected) = (Vec3::from_array(*found), Vec3::from_array(*expected));
                    assert!(found.is_finite() && found.min_element() >= 0.0);
                    assert!(found.max_element() <= 1.0);
                    apart += u32::from((found - expected).abs().max_element() > 4e-3);
                }
                // Rounding decides for flat ones seen edge-on.
                assert!(f64::from(apart) <= 0.01 * found.filter.len() as f64, "{kind:?}: {apart}");
            }
        }
    }
}

#[test]
fn changed_gaussians_are_uploaded() {
    for tier in tiers(Tier::Native) {
        let options = RenderOptions { maps: true, maps_only: true, ..RenderOptions::default() };
        let mut renderer = Renderer::on(gpu(tier)).unwrap();
        let mut scene = mixture();
        renderer.render(&scene, &options).unwrap();
        for gaussian in scene.gaussians.iter_mut().step_by(7) {
            gaussian.rotation *= Quat::from_rotation_z(0.4);
        }
        scene.gaussians[3].color = Vec3::X;
        let updated = renderer.render(&scene, &options).unwrap();
        let fresh = Renderer::on(gpu(tier)).unwrap().render(&scene, &options).unwrap();
        assert_same(&updated.maps, &fresh.maps, "after an update");
        assert!(shadow_views(&scene).len() == updated.maps.len());
    }
}

#[test]
fn invalid_gaussians_are_errors_that_name_them() {
    let gpu = gpu(Tier::Core);
    let mut shadows = crate::common::shadows(&gpu);
    let materials = [splats(Transfer::Filter), material(Transfer::Filter)];
    let valid = Gaussian::default();
    let wrong = [
        Gaussian { sigma: Vec3::new(1.0, 0.0, 1.0), ..valid },
        Gaussian { center: Vec3::NAN, ..valid },
        Gaussian { opacity: 1.5, ..valid },
        Gaussian { color: Vec3::splat(2.0), ..valid },
        Gaussian { rotation: Quat::from_xyzw(0.0, 0.0, 0.0, 2.0), ..valid },
        Gaussian { center: Vec3::splat(2e7), ..valid },
        Gaussian { material: 1, ..valid },
        Gaussian { material: 9, ..valid },
    ];
    let mut prepare = |gaussians: &[Gaussian], particles: &[Particle]| {
        let casters = Casters { gaussians, particles, materials: &materials, ..Casters::default() };
        let scene = lit_by(kinds()[0], materials.to_vec(), 1);
        let settings = scene.shadow;
        Shadows::prepare(&mut shadows, &casters, &shadow_views(&scene), &settings).map(|_| ())
    };
    assert!(prepare(&[valid], &[]).is_ok());
    for gaussian in wrong {
        let error = prepare(&[valid, gaussian], &[]).unwrap_err();
        assert!(matches!(error, Error::Invalid { index: 1, .. }), "{gaussian:?}: {error}");
    }
    let error = prepare(&[], &[Particle::default()]).unwrap_err();
    assert!(error.to_string().contains("Gaussian"), "{error}");
}
