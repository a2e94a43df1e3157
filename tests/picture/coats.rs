//! Clear coats (`KHR_materials_clearcoat`): pictures of a square beside the extension's formula, texel by
//! texel.
use super::details::{EYE, image, light, places, seen_from_above, worst};
use crate::common::{model::Glb, reference_picture};
use gobo::glam::{DVec3, Vec3};
use gobo_scene::Scene;
use serde_json::{Value, json};
use std::f64::consts::PI;

/// Direction in which the light travels.
const ALONG: Vec3 = Vec3::new(-0.08, -1.0, 0.06);
const COLOR: [f64; 3] = [0.05, 0.02, 0.1];
/// Roughness of the surface, and bytes of its normals.
const ROUGHNESS: f64 = 0.7;
const NORMALS: [u8; 3] = [150, 128, 250];
/// Bytes of the coat's share to the left and to the right, and of its roughness behind and in front.
const SHARES: [u8; 2] = [90, 255];
const ROUGH: [u8; 2] = [170, 110];
/// Factors of the two.
const FACTORS: [f64; 2] = [0.9, 0.8];
/// Bytes of a coat's normals, and their scale.
const TILT: [u8; 3] = [128, 138, 254];
const SCALE: f64 = 0.9;

/// A coated square; `tilts`: whether its coat has normals of its own.
fn scene(alpha_mode: &str, tilts: bool) -> Scene {
    let mut model = Glb::new();
    let share = image(|right, _| [SHARES[usize::from(right)], 9, 200]);
    let rough = image(|_, front| [3, ROUGH[usize::from(front)], 70]);
    let [normals, tilt] = [NORMALS, TILT].map(|rgb| image(|_, _| rgb));
    let [share, rough, normals, tilt] =
        [share, rough, normals, tilt].map(|rgba| model.texture(16, 16, &rgba));
    let mut coat = json!({
        "clearcoatFactor": FACTORS[0],
        "clearcoatTexture": { "index": share },
        "clearcoatRoughnessFactor": FACTORS[1],
        "clearcoatRoughnessTexture": { "index": rough },
    });
    if tilts {
        coat["clearcoatNormalTexture"] = json!({ "index": tilt, "scale": SCALE });
    }
    let square = model.square(json!({
        "alphaMode": alpha_mode,
        "pbrMetallicRoughness": {
            "baseColorFactor": [COLOR[0], COLOR[1], COLOR[2], 1],
            "metallicFactor": 0, "roughnessFactor": ROUGHNESS,
        },
        "normalTexture": { "index": normals },
        "extensions": { "KHR_materials_clearcoat": coat },
    }));
    seen_from_above(model, square, ALONG)
}

/// A normal of the square, by the channels of its image.
fn normal(rgb: [u8; 3], scale: f64) -> DVec3 {
    let [x, y, z] = rgb.map(|byte| f64::from(byte) / 127.5 - 1.0);
    DVec3::new(scale * x, z, -scale * y).normalize()
}

/// Blinn's highlight per unit of reflectance, times the cosine.
fn shine(normal: DVec3, roughness: f64, to_light: DVec3, to_eye: DVec3) -> f64 {
    let middle = (to_light + to_eye).normalize();
    let width = (roughness * roughness).max(0.04);
    let exponent = 2.0 / (width * width) - 1.0;
    let lobe = (exponent + 6.0) / (8.0 * PI) * normal.dot(middle).max(0.0).powf(exponent);
    lobe * normal.dot(to_light).max(0.0)
}

/// `mix(base, coat, share * fresnel)` of the extension, for light of irradiance 3.
fn closed_form(place: DVec3, [right, front]: [bool; 2], tilts: bool) -> [f64; 3] {
    let (to_light, to_eye) = (-ALONG.as_dvec3().normalize(), (EYE - place).normalize());
    let below = normal(NORMALS, 1.0);
    let over = if tilts { normal(TILT, SCALE) } else { DVec3::Y };
    let fresnel = |cosine: f64| 0.04 + 0.96 * (1.0 - cosine).powi(5);
    let share = FACTORS[0] * f64::from(SHARES[usize::from(right)]) / 255.0;
    let roughness = FACTORS[1] * f64::from(ROUGH[usize::from(front)]) / 255.0;
    let mirrored = share * fresnel(over.dot(to_eye));
    let middle = (to_light + to_eye).normalize();
    let gloss = shine(below, ROUGHNESS, to_light, to_eye) * fresnel(to_eye.dot(middle));
    let coat = shine(over, roughness, to_light, to_eye);
    COLOR.map(|color| {
        let scattered = color * (1.0 - 0.04) / PI * below.dot(to_light).max(0.0);
        3.0 * ((1.0 - mirrored) * (scattered + gloss) + mirrored * coat)
    })
}

/// The scene without coats.
fn bare(mut scene: Scene) -> Scene {
    let coated = scene.materials.iter().filter_map(|material| material.details);
    for details in coated.collect::<Vec<_>>() {
        scene.materials[details as usize].details = None;
    }
    scene
}

#[test]
fn coats_have_highlights_of_their_own() {
    for tilts in [false, true] {
        let mut scene = scene("OPAQUE", tilts);
        scene.lights[0].intensity = 3.0;
        let wanted = |place, right, front| closed_form(place, [right, front], tilts);
        let found = worst(&light(&scene), wanted);
        let other = |place, right, front| closed_form(place, [right, front], !tilts);
        let others = worst(&light(&scene), other);
        let without = worst(&reference_picture(&bare(scene)).light, wanted);
        println!("{found:.4}, without {without:.4}, by other normals {others:.4}");
        assert!(found < 0.04 && without > 0.3 && others > 0.1, "{found}, {without}, {others}");
    }
}

#[test]
fn coats_mirror_the_surroundings() {
    let coat = |coat: Value| {
        let mut model = Glb::new();
        let square = model.square(json!({
            "pbrMetallicRoughness": { "baseColorFactor": [0.02, 0.02, 0.02, 1], "metallicFactor": 0 },
            "extensions": { "KHR_materials_clearcoat": coat },
        }));
        let mut scene = seen_from_above(model, square, ALONG);
        scene.lights.clear();
        (scene.ambient, scene.background) = (Vec3::splat(0.5), Vec3::new(0.9, 0.6, 0.3));
        scene
    };
    let scene = coat(json!({ "clearcoatFactor": 0.7, "clearcoatRoughnessFactor": 0.1 }));
    let lit = light(&scene);
    for (at, ..) in places() {
        for (found, background) in lit[at].iter().zip([0.9, 0.6, 0.3]) {
            let mirrored = 0.7 * 0.04;
            let wanted = mirrored * background + (1.0 - mirrored) * 0.02 * 0.5;
            assert!((found - wanted).abs() < 5e-4, "{at}: {found}, not {wanted}");
        }
    }
    // The usual factor is 0.
    let none = coat(json!({ "clearcoatRoughnessFactor": 0.1 }));
    assert!(none.materials.iter().all(|material| material.details.is_none()));
}

#[test]
fn coats_that_are_not_shown_are_named() {
    let names = |scene: &Scene| {
        let named = scene.skipped.keys().filter(|key| key.contains("clear coats"));
        named.count()
    };
    assert_eq!(names(&scene("OPAQUE", true)), 0);
    assert_eq!(names(&scene("MASK", true)), 0);
    assert_eq!(names(&scene("BLEND", true)), 1);
}
