//! Views from an engine's own matrices.
use super::{materials, particles, shadows, submit, views};
use crate::common::{Tier, gpu, tiers};
use gobo::{
    Casters, Light, ShadowSettings, View,
    glam::{Mat4, UVec2, Vec3, Vec4},
    light_views,
    model::Projection,
};
use half::f16;
use std::f32::consts::FRAC_PI_2;

/// Clip space with reversed z.
fn reversed(clip_from_world: Mat4) -> Mat4 {
    let flip = Mat4::from_cols(Vec4::X, Vec4::Y, Vec4::NEG_Z, Vec4::new(0.0, 0.0, 1.0, 1.0));
    flip * clip_from_world
}

/// The view turned about its axis [radians].
fn rolled(view: &View, angle: f32) -> View {
    let view_from_world = Mat4::from_rotation_z(angle) * view.view_from_world;
    View { view_from_world, ..view.clone() }
}

#[test]
fn matrices_of_rolled_cameras_become_views() {
    for (number, view) in views().iter().enumerate() {
        let view = rolled(view, 0.7 * number as f32);
        let clip = view.clip_from_world();
        for (matrix, what) in
            [(clip, "usual"), (reversed(clip), "reversed"), (clip * 3.0, "scaled")]
        {
            let found = View::from_clip(&matrix, view.size).unwrap();
            assert_eq!(found.projection, view.projection);
            // In 32 bits a far plane 10,000 times as far as the near one has an error of 1e-3.
            let span = view.far - view.near;
            let [near, far] = match view.projection {
                Projection::Perspective => [found.near - view.near, found.far - view.far],
                Projection::Orthographic => [(found.far - found.near) - span, 0.0],
            };
            assert!(near.abs().max(far.abs()) < 2e-3 * span, "{what} {number}: {near} {far}");
            let apart = found.clip_from_world() - clip;
            let columns = [apart.x_axis, apart.y_axis, apart.z_axis, apart.w_axis];
            let most = columns.map(|c| Vec4::new(c.x, c.y, 0.0, c.w).abs().max_element());
            assert!(most.into_iter().all(|apart| apart < 1e-4), "{what} {number}: {apart:?}");
            let depth = found.clip_from_world().project_point3(Vec3::splat(0.1)).z
                - clip.project_point3(Vec3::splat(0.1)).z;
            assert!(depth.abs() < 2e-3, "{what} {number}: {depth}");
        }
    }
}

/// A camera rolled by a right angle has the same map, rotated.
#[test]
fn maps_of_a_rolled_camera_are_turned() {
    const SIZE: usize = 64;
    for tier in tiers(Tier::Native) {
        let gpu = gpu(tier);
        let spot = Light::spot(Vec3::new(3.0, 4.0, 2.5), Vec3::new(-3.0, -4.0, -2.5), 0.8);
        let bounds = gobo::Bounds { min: Vec3::splat(-2.5), max: Vec3::splat(2.5) };
        let view = light_views(0, &spot, SIZE as u32, None, &bounds).unwrap().remove(0);
        let turned = rolled(&view, FRAC_PI_2).clip_from_world();
        let turned = View { light: Some(0), ..View::from_clip(&turned, view.size).unwrap() };
        let (materials, particles) = (materials(), particles(3000, 5));
        let casters =
            Casters { particles: &particles, materials: &materials, ..Casters::default() };
        let filters = [view, turned].map(|view| {
            let mut shadows = shadows(&gpu);
            let settings = ShadowSettings::default();
            let bits = submit(&gpu, &shadows.prepare(&casters, &[view], &settings).unwrap());
            bits.filters
                .iter()
                .map(|texel| texel.map(|bits| f16::from_bits(bits).to_f32()))
                .collect::<Vec<_>>()
        });
        let width = filters[0].len().isqrt();
        let (mut far, mut dark) = (0, 0);
        for row in 0..SIZE {
            for column in 0..SIZE {
                let before = filters[0][column * width + SIZE - 1 - row];
                let after = filters[1][row * width + column];
                far += usize::from((0..3).any(|c| (before[c] - after[c]).abs() > 0.01));
                dark += usize::from(before[0] < 0.9);
            }
        }
        // Rounding decides whether texels on the rim of a flat quad are hit.
        assert!(dark > SIZE * SIZE / 10 && far < SIZE * SIZE / 100, "{tier}: {dark} {far}");
    }
}

#[test]
fn matrices_of_no_shadow_camera_are_refused() {
    let size = UVec2::splat(64);
    let spot = Light::spot(Vec3::new(1.0, 2.0, 3.0), Vec3::new(-1.0, -2.0, -3.0), 1.0);
    let bounds = gobo::Bounds { min: Vec3::splat(-2.5), max: Vec3::splat(2.5) };
    let good = light_views(0, &spot, 64, None, &bounds).unwrap()[0].clip_from_world();
    let [x, y, w] = [0, 1, 3].map(|row| good.row(row));
    let infinite = Mat4::from_cols(x, y, w - 0.1 * Vec4::W, w).transpose();
    let infinite_reversed = Mat4::from_cols(x, y, 0.1 * Vec4::W, w).transpose();
    assert!(View::from_clip(&good, size).is_ok());
    let aside = Mat4::from_translation(Vec3::X * 0.3);
    let left = Mat4::from_scale(Vec3::new(1.0, -1.0, 1.0));
    let skewed = Mat4::from_cols(Vec4::X, Vec4::new(0.5, 1.0, 0.0, 0.0), Vec4::Z, Vec4::W);
    for (matrix, size, problem) in [
        (Mat4::NAN, size, "finite"),
        (Mat4::ZERO, size, "zero"),
        (infinite, size, "infinite"),
        (infinite_reversed, size, "infinite"),
        (aside * good, size, "not symmetric"),
        (left * good, size, "left-handed"),
        (skewed * good, size, "orthogonal"),
        (good, UVec2::new(64, 32), "square"),
        (good, UVec2::ZERO, "square"),
    ] {
        let error = View::from_clip(&matrix, size).unwrap_err().to_string();
        assert!(error.contains(problem), "{error}, not {problem}");
    }
}
