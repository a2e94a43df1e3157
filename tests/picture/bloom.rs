//! `camera.bloom` and `camera.tone`: spread light, and tone curves.
use crate::common::{TIERS, files::read, reference_picture, render};
use gobo::{
    Camera, Material, Transfer,
    glam::{UVec2, Vec3},
    model::Tone,
};
use gobo_scene::Scene;

const SIZE: u32 = 96;

/// A lamp that shines in the middle of a dark picture.
fn lamp(bloom: f32) -> Scene {
    let emission = Vec3::new(40.0, 10.0, 2.0);
    let mut scene = crate::common::scenes::empty(vec![Material {
        emission,
        ..crate::common::scenes::material(Transfer::Opaque)
    }]);
    scene.camera = Camera {
        eye: Vec3::Z * 5.0,
        target: Vec3::ZERO,
        up: Vec3::Y,
        fov_y: 0.4,
        size: UVec2::splat(SIZE),
    };
    let corners = [Vec3::new(-0.06, -0.06, 0.0), Vec3::new(0.06, -0.06, 0.0), Vec3::Y * 0.06];
    scene.triangles = vec![crate::common::scenes::triangle(corners, 0)];
    scene.bloom = bloom;
    scene
}

/// Sums of red over the pixels, and over those farther than some pixels from the middle.
fn sums(light: &[[f32; 3]]) -> [f64; 4] {
    let mut sums = [0.0; 4];
    for (i, texel) in light.iter().enumerate() {
        let at = [i as u32 % SIZE, i as u32 / SIZE].map(|v| (f64::from(v) + 0.5) - 48.0);
        let apart = at[0].hypot(at[1]);
        for (sum, least) in sums.iter_mut().zip([0.0, 6.0, 12.0, 24.0]) {
            *sum += if apart >= least { f64::from(texel[0]) } else { 0.0 };
        }
    }
    sums
}

#[test]
fn no_light_is_lost_or_added() {
    // Half floats of levels round by 2^-11; at the picture's border, where little light arrives, texels
    // repeat.
    const LOST: f64 = 0.02;
    let share = 0.25;
    let [whole, ..] = sums(&render(TIERS[0], &lamp(0.0)).picture.light);
    for tier in TIERS {
        let scene = lamp(share);
        let picture = render(tier, &scene).picture;
        let found = sums(&picture.light);
        assert!((found[0] / whole - 1.0).abs() < LOST, "{} of {whole}", found[0]);
        // Least share of the spread light at these distances.
        for (far, least) in found[1..].iter().zip([0.35, 0.15, 0.02]) {
            let part = far / (whole * f64::from(share));
            assert!(part > least && part < 1.0, "{found:?} of {whole}: {part}");
        }
        let expected = reference_picture(&scene);
        for (a, b) in picture.light.iter().flatten().zip(expected.light.iter().flatten()) {
            assert!((a - b).abs() <= 1e-3 + 2e-3 * b, "{a} {b}");
        }
        let apart = |(a, b): (&u8, &u8)| a.abs_diff(*b) > 1;
        let shown = picture.rgb.iter().flatten().zip(expected.rgb.iter().flatten());
        assert_eq!(shown.filter(|&it| apart(it)).count(), 0);
    }
}

/// Curves of one pixel's light, from their definitions in 64 bits.
#[test]
fn curves_are_those_of_their_papers() {
    let srgb = |v: f64| {
        let v = v.clamp(0.0, 1.0);
        255.0 * if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
    };
    let filmic = |v: f64| {
        let x = 0.6 * v;
        x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
    };
    for light in [0.0, 0.02, 0.18, 0.5, 0.9, 3.0, 1e30] {
        for tone in [Tone::Linear, Tone::Filmic] {
            let mut scene = crate::common::scenes::empty(Vec::new());
            // At the horizon: the sky above is brighter.
            scene.background = Vec3::splat(light);
            scene.camera = Camera {
                eye: Vec3::ZERO,
                target: Vec3::Z,
                up: Vec3::Y,
                fov_y: 0.01,
                size: UVec2::splat(1),
            };
            scene.tone = tone;
            let truth = srgb(match tone {
                Tone::Filmic if light > 1e6 => 1.0,
                Tone::Filmic => filmic(f64::from(light)),
                _ => f64::from(light),
            });
            for picture in [render(TIERS[0], &scene).picture, reference_picture(&scene)] {
                let found = f64::from(picture.rgb[0][1]);
                assert!((found - truth).abs() <= 0.6, "{tone:?} of {light}: {found}, not {truth}");
            }
        }
    }
}

#[test]
fn bloom_is_a_share_and_a_tone_has_a_name() {
    let of = |keys: &str| read(&format!("[camera]\n{keys}\n"));
    let scene = of("bloom = 0.2\ntone = \"filmic\"").unwrap();
    assert_eq!((scene.bloom, scene.tone), (0.2, Tone::Filmic));
    let scene = of("").unwrap();
    assert_eq!((scene.bloom, scene.tone), (0.0, Tone::Neutral));
    assert_eq!(of("tone = \"linear\"").unwrap().tone, Tone::Linear);
    for wrong in ["bloom = 1.5", "bloom = -0.1", "bloom = nan", "tone = \"film\"", "tone = 2"] {
        let error = of(wrong).unwrap_err().to_string();
        let (key, value) = wrong.split_once(" = ").unwrap();
        let names = error.contains(key) || error.contains(value.trim_matches('"'));
        assert!(names, "{wrong}: {error}");
    }
}
