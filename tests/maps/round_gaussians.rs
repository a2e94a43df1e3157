//! Gaussians at round positions: lamps in their middles and planes, and beside flat ones.
use super::{
    gaussians::{all_maps, assert_agrees, medium, splats},
    round::Round,
};
use crate::common::{
    compare::Tolerance,
    scenes::{empty, light},
};
use gobo::{
    glam::{Quat, Vec3},
    model::{Gaussian, Light, LightKind, Material, Transfer},
    view::shadow_views,
};
use gobo_reference::render_maps;
use gobo_scene::Scene;

/// Cut-off of each at its last 8192th, 16-bit colours and thicknesses; depths in 32 bits.
const TOLERANCE: Tolerance = Tolerance { filter: 2e-3, depth: 1e-5, undecided: 0.1 };

fn spot(direction: Vec3, degrees: f32, [near, far]: [f32; 2]) -> Light {
    let position = Vec3::ZERO;
    let kind = LightKind::Spot { position, direction, angle: degrees.to_radians() };
    Light { near: Some(near), far: Some(far), size: Some(64), ..light(kind) }
}

fn lit_by(light: Light, gaussian: Gaussian, material: Material) -> Scene {
    let gaussian = Gaussian { color: Vec3::ZERO, material: 0, ..gaussian };
    Scene { lights: vec![light], gaussians: vec![gaussian], ..empty(vec![material]) }
}

/// 40 cm wide and 2 mm thick, 1 cm beside a lamp: its middle is thinner than a texel, and it spans half of
/// the map.
#[test]
fn a_flat_splat_beside_a_lamp_keeps_its_light() {
    let gaussian = Gaussian {
        center: Vec3::new(0.8, 0.01, 0.0),
        sigma: Vec3::new(0.4, 0.002, 0.4),
        opacity: 0.9,
        ..Gaussian::default()
    };
    let scene = lit_by(spot(Vec3::X, 90.0, [0.01, 6.0]), gaussian, splats(Transfer::Filter));
    assert_agrees(&scene, TOLERANCE);
    for maps in all_maps(&scene) {
        let taken: f64 = maps[0].filter.iter().map(|filter| 1.0 - f64::from(filter[0])).sum();
        let mean = taken / maps[0].filter.len() as f64;
        assert!((mean - 0.08).abs() < 1e-3, "{mean}");
    }
}

/// As a lamp comes closer, the light that a flat splat absorbs grows without a step.
#[test]
fn a_lamp_that_comes_nearer_changes_light_without_a_step() {
    let mut shadows = Vec::new();
    for i in 0..=40 {
        let gaussian = Gaussian {
            center: Vec3::new(1.6 - 0.02 * i as f32, 0.01, 0.0),
            sigma: Vec3::new(0.4, 0.002, 0.4),
            opacity: 0.9,
            ..Gaussian::default()
        };
        let scene = lit_by(spot(Vec3::X, 90.0, [0.01, 6.0]), gaussian, splats(Transfer::Filter));
        let (maps, _) = render_maps(&scene, &shadow_views(&scene));
        let taken: f64 = maps[0].filter.iter().map(|filter| 1.0 - f64::from(filter[0])).sum();
        shadows.push(taken / maps[0].filter.len() as f64);
    }
    let steps: Vec<_> = shadows.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(steps.iter().all(|&step| step > 0.0), "{shadows:?}");
    assert!(steps.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 4e-3), "{shadows:?}");
}

#[test]
fn a_medium_in_the_plane_through_a_lamp_is_whole() {
    let gaussian = Gaussian {
        center: Vec3::X,
        rotation: Quat::from_xyzw(0.2, -0.3, 0.1, 0.9).normalize(),
        sigma: Vec3::splat(0.3),
        opacity: 0.9,
        ..Gaussian::default()
    };
    let scene = lit_by(spot(Vec3::NEG_Z, 120.0, [0.0005, 9.0]), gaussian, medium(4.0));
    assert_agrees(&scene, TOLERANCE);
    let expected = [0.975, 0.954, 0.918, 0.867, 0.800, 0.724, 0.645, 0.569];
    for maps in all_maps(&scene) {
        for (i, expected) in expected.into_iter().enumerate() {
            let found = maps[0].filter[32 * 64 + 40 + 3 * i][0];
            assert!((found - expected).abs() < 2e-3, "{i}: {found} instead of {expected}");
        }
    }
}

/// `tau = density opacity sigma sqrt(pi / 2)` along an axis, from the middle on.
#[test]
fn a_lamp_in_the_middle_of_a_medium_is_filtered() {
    let sigma = Vec3::new(0.2, 0.1, 0.3);
    let gaussian = Gaussian { center: Vec3::ZERO, sigma, opacity: 0.5, ..Gaussian::default() };
    let kind = LightKind::Point { position: Vec3::ZERO };
    let lamp = Light { near: Some(1e-4), far: Some(4.0), size: Some(33), ..light(kind) };
    let scene = lit_by(lamp, gaussian, medium(2.0));
    assert_agrees(&scene, TOLERANCE);
    for maps in all_maps(&scene).iter().flatten() {
        let axis = maps.view.direction().abs().round();
        let expected = (-sigma.dot(axis) * std::f32::consts::FRAC_PI_2.sqrt()).exp();
        let found = maps.filter[16 * 33 + 16][0];
        assert!((found - expected).abs() < 1e-3, "{axis}: {found} instead of {expected}");
    }
}

pub(super) fn quarter_turn(round: &mut Round) -> Quat {
    Quat::from_axis_angle(round.one_of(&Vec3::AXES), round.turn())
}

/// Balls, pancakes and needles, of material 0 or 1.
pub(super) fn round_gaussian(round: &mut Round, id: u32) -> Gaussian {
    Gaussian {
        center: round.place(1.5),
        rotation: quarter_turn(round),
        sigma: [0; 3].map(|_| round.one_of(&[0.5, 0.25, 0.125])).into(),
        color: round.color().truncate(),
        opacity: round.one_of(&[0.5, 1.0]),
        material: round.one_of(&[0, 1]),
        id,
    }
}

/// Its middle, or a point one, two or three deviations off.
pub(super) fn around(round: &mut Round, gaussian: &Gaussian) -> Vec3 {
    let axes = gaussian.axes();
    gaussian.center + axes.col(round.one_of(&[0, 1, 2])) * round.half(0.0, 3.0).floor()
}

#[test]
fn gaussians_at_round_places() {
    for seed in 0..4 {
        let mut round = Round::new(seed);
        let mut scene = empty(vec![splats(Transfer::Filter), medium(2.0)]);
        scene.gaussians = (0..5).map(|id| round_gaussian(&mut round, id)).collect();
        let gaussians = scene.gaussians.clone();
        let places: Vec<_> = gaussians.iter().map(|g| around(&mut round, g)).collect();
        let size = round.one_of(&[32, 33]);
        scene.lights = round.lights(&places, size).into();
        assert_agrees(&scene, TOLERANCE);
    }
}
