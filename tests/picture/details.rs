//! Images of roughness, metal, normals and ambient light: pictures of a square beside closed forms, texel by
//! texel.
use crate::common::{
    TIERS, files::Folder, gpu, model::Glb, reference_picture, scenes::light as lamp,
};
use gobo::{
    Camera,
    glam::{DVec3, UVec2, Vec3},
    model::{LightKind, Skipped},
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::{Scene, load};
use serde_json::{Value, json};
use std::f64::consts::PI;

pub(super) const SIZE: u32 = 48;
pub(super) const FOV: f32 = 0.3;
pub(super) const EYE: DVec3 = DVec3::new(0.0, 3.0, 0.0);
/// Direction in which the light travels.
const ALONG: Vec3 = Vec3::new(-0.42, -1.0, 0.16);
const COLOR: [f64; 3] = [0.8, 0.5, 0.2];
/// Bytes of roughness and metal to the left and to the right.
const SIDES: [[u8; 2]; 2] = [[128, 255], [230, 0]];
/// Bytes of normals behind and in front: flat, and tilted to the right and back.
const NORMALS: [[u8; 3]; 2] = [[128, 128, 255], [176, 148, 240]];
/// Byte of the ambient light in front.
const OPEN: u8 = 90;
const STRENGTH: f64 = 0.8;

/// An image of 16 x 16 texels, by whether they are right and in front.
pub(super) fn image(texel: impl Fn(bool, bool) -> [u8; 3]) -> Vec<u8> {
    let of = |i: u32| {
        let [r, g, b] = texel(i % 16 >= 8, i / 16 >= 8);
        [r, g, b, 255]
    };
    (0..256).flat_map(of).collect()
}

fn scene(alpha_mode: &str) -> Scene {
    let mut model = Glb::new();
    let shares = image(|right, _| {
        let [rough, metal] = SIDES[usize::from(right)];
        [7, rough, metal]
    });
    let open = image(|_, front| [if front { OPEN } else { 255 }, 3, 200]);
    let normals = image(|_, front| NORMALS[usize::from(front)]);
    let [shares, open, normals] = [shares, open, normals].map(|rgba| model.texture(16, 16, &rgba));
    let square = model.square(json!({
        "alphaMode": alpha_mode,
        "pbrMetallicRoughness": {
            "baseColorFactor": [COLOR[0], COLOR[1], COLOR[2], 1],
            "metallicRoughnessTexture": { "index": shares },
        },
        "occlusionTexture": { "index": open, "strength": STRENGTH },
        "normalTexture": { "index": normals, "scale": 0.9 },
    }));
    seen_from_above(model, square, ALONG)
}

/// A square of a metre that looks up, u to the right and v to the front, seen from above; `along`: direction
/// in which the light travels.
pub(super) fn seen_from_above(mut model: Glb, square: Value, along: Vec3) -> Scene {
    model.place(square, [0.0; 3]);
    let folder = Folder::new();
    folder.write("model.glb", model.bytes());
    let mut scene = load(&folder.write("scene.toml", "[[mesh]]\nfile = 'model.glb'\n")).unwrap();
    scene.camera = Camera {
        eye: EYE.as_vec3() - scene.origin,
        target: -scene.origin,
        up: Vec3::NEG_Z,
        fov_y: FOV,
        size: UVec2::splat(SIZE),
    };
    scene.lights = vec![lamp(LightKind::Directional { direction: along })];
    (scene.ambient, scene.background, scene.air) = (Vec3::ZERO, Vec3::ZERO, None);
    scene
}

/// Linear light by the CPU reference, and by the kernels of each tier, which agree.
pub(super) fn light(scene: &Scene) -> Vec<[f32; 3]> {
    let expected = reference_picture(scene).light;
    let options = RenderOptions { light: true, ..RenderOptions::default() };
    for tier in TIERS {
        let picture = Renderer::on(gpu(tier)).unwrap().render(scene, &options).unwrap().picture;
        for (at, (found, wanted)) in picture.light.iter().zip(&expected).enumerate() {
            for (a, b) in found.iter().zip(wanted) {
                // Devices decode sRGB in steps of their own, and highlights have high powers of roughness.
                assert!((a - b).abs() < 4e-3 + 0.03 * b, "{tier:?}, {at}: {found:?}, {wanted:?}");
            }
        }
    }
    expected
}

/// Pixels whose texels and their neighbours are of one quarter, with the place that they show, and whether it
/// is to the right and in front.
pub(super) fn places() -> impl Iterator<Item = (usize, DVec3, bool, bool)> {
    let half = f64::from(SIZE) / 2.0;
    let slope = move |i: u32| (f64::from(i) + 0.5 - half) / half * f64::from(FOV / 2.0).tan();
    let all = (0..SIZE * SIZE).map(move |i| {
        let place = DVec3::new(slope(i % SIZE), 0.0, slope(i / SIZE)) * EYE.y;
        (i as usize, place, place.x > 0.0, place.z > 0.0)
    });
    all.filter(|(_, place, ..)| place.x.abs().min(place.z.abs()) > 0.08)
}

/// Blinn's highlight and what is scattered, of a metal or a plastic (docs/scene.md).
fn closed_form(place: DVec3, right: bool, front: bool) -> [f64; 3] {
    let [roughness, metal] = SIDES[usize::from(right)].map(|byte| f64::from(byte) / 255.0);
    let [x, y, z] = NORMALS[usize::from(front)].map(|byte| f64::from(byte) / 127.5 - 1.0);
    let normal = DVec3::new(0.9 * x, z, -0.9 * y).normalize();
    let to_light = -ALONG.as_dvec3().normalize();
    let to_eye = (EYE - place).normalize();
    let middle = (to_light + to_eye).normalize();
    let cosine = normal.dot(to_light).max(0.0);
    let exponent = 2.0 / roughness.powi(4) - 1.0;
    let lobe = (exponent + 6.0) / (8.0 * PI) * normal.dot(middle).max(0.0).powf(exponent);
    let rest = (1.0 - to_eye.dot(middle)).powi(5);
    COLOR.map(|color| {
        let head_on = 0.04 + (color - 0.04) * metal;
        let mirrored = head_on + (1.0 - head_on) * rest;
        let scattered = color * (1.0 - metal) * (1.0 - 0.04) / PI;
        3.0 * cosine * (scattered + lobe * mirrored)
    })
}

/// Worst error per channel, of what should be there and a tenth.
pub(super) fn worst(light: &[[f32; 3]], wanted: impl Fn(DVec3, bool, bool) -> [f64; 3]) -> f64 {
    let mut worst = 0.0_f64;
    for (at, place, right, front) in places() {
        for (found, wanted) in light[at].iter().zip(wanted(place, right, front)) {
            worst = worst.max((f64::from(*found) - wanted).abs() / (wanted + 0.1));
        }
    }
    worst
}

/// The same scene by the means of its images.
fn by_means(mut scene: Scene) -> Scene {
    scene.materials.iter_mut().for_each(|material| material.details = None);
    scene
}

#[test]
fn highlights_follow_images_of_roughness_metal_and_normals() {
    let mut scene = scene("OPAQUE");
    scene.lights[0].intensity = 3.0;
    let found = worst(&light(&scene), closed_form);
    let means = worst(&reference_picture(&by_means(scene)).light, closed_form);
    println!("{found:.4}, by means {means:.4}");
    assert!(found < 0.03 && means > 0.3, "{found}, {means}");
}

#[test]
fn ambient_light_is_taken_by_images_of_occlusion() {
    let mut scene = scene("OPAQUE");
    scene.lights.clear();
    scene.ambient = Vec3::splat(0.5);
    // Where the surroundings are alike all round, what metal mirrors of them is its colour.
    scene.materials.iter_mut().for_each(|material| material.metallic = 0.0);
    let wanted = |_: DVec3, right: bool, front: bool| {
        let open = if front { 1.0 - STRENGTH * (1.0 - f64::from(OPEN) / 255.0) } else { 1.0 };
        // Only plastic has a closed form that is short.
        COLOR.map(|color| if right { 0.5 * color * open } else { f64::NAN })
    };
    let found = worst(&light(&scene), wanted);
    let means = worst(&reference_picture(&by_means(scene)).light, wanted);
    println!("{found:.4}, without {means:.4}");
    assert!(found < 0.03 && means > 0.3, "{found}, {means}");
}

#[test]
fn what_blends_names_the_images_that_it_does_not_show() {
    let names = |skipped: &Skipped| skipped.keys().filter(|key| key.contains("ignored")).count();
    assert_eq!(names(&scene("OPAQUE").skipped), 0);
    let blended = scene("BLEND");
    assert_eq!(names(&blended.skipped), 2, "{:?}", blended.skipped);
    assert!(blended.materials.iter().all(|material| material.details.is_none()));
}
