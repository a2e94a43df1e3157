//! glTF models in pictures: unlit materials, coverage, and the falloff of lamps.
use crate::common::{TIERS, files::Folder, model::Glb, reference_picture, render};
use gobo::records::Picture;
use gobo_scene as scene;
use gobo_scene::Scene;
use serde_json::{Value, json};

/// Seen from 8 m above, a pixel in the middle is an eighth of a metre wide.
const VIEW: &str = "[camera]\neye = [0, 8, 0]\ntarget = [0, 0, 0]\nup = [0, 0, -1]\nfov_y = 53.13010235\n\
    size = [64, 64]\nsamples = 1\nocclusion = false\n[shadow]\nsize = 64\ndetail = false\n\
    [[mesh]]\nfile = 'model.glb'\n";

fn scene(model: &Glb, keys: &str) -> Scene {
    let folder = Folder::new();
    folder.write("model.glb", model.bytes());
    scene::load(&folder.write("scene.toml", format!("{VIEW}{keys}"))).unwrap()
}

/// Linear light of the picture by the CPU reference and on each tier.
fn pictures(scene: &Scene) -> Vec<Picture> {
    let of_tiers = TIERS.map(|tier| render(tier, scene).picture);
    [reference_picture(scene)].into_iter().chain(of_tiers).collect()
}

/// Light at a point of the ground.
fn at(picture: &Picture, x: f32, z: f32) -> [f32; 3] {
    let pixel = |metres: f32| (32.0 + metres * 8.0) as usize;
    picture.light[pixel(z) * 64 + pixel(x)]
}

#[track_caller]
fn assert_light(found: [f32; 3], wanted: [f32; 3], apart: f32) {
    let off = found.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(off < apart, "{found:?}, not {wanted:?}");
}

fn lamps(model: &mut Glb, lights: Value) {
    let count = lights.as_array().unwrap().len();
    model.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    model.json["extensions"]["KHR_lights_punctual"]["lights"] = lights;
    for light in 0..count {
        let turned = [-std::f32::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2];
        let lamp = json!({ "KHR_lights_punctual": { "light": light } });
        model.node(json!({ "translation": [0, 2, 0], "rotation": turned, "extensions": lamp }));
    }
}

/// A floor that scatters all light evenly.
fn floor(model: &mut Glb) {
    let surface = json!({ "metallicFactor": 0, "roughnessFactor": 1 });
    let square = model.square(json!({ "pbrMetallicRoughness": surface }));
    let node = model.place(square, [0.0; 3]);
    model.json["nodes"][node]["scale"] = json!([8, 1, 8]);
}

/// `KHR_materials_unlit`: the base colour times the texture's and the corners', blended by its alpha, in any
/// light.
#[test]
fn what_is_unlit_shows_its_colour() {
    let mut model = Glb::new();
    let texture = model.texture(1, 1, &[188, 255, 255, 255]);
    let linear = ((188.0 / 255.0 + 0.055) / 1.055f32).powf(2.4);
    for (x, blend) in [(-2.0, "OPAQUE"), (0.0, "BLEND"), (2.0, "MASK")] {
        let mut square = model.square(json!({
            "alphaMode": blend,
            "extensions": { "KHR_materials_unlit": {} },
            "emissiveFactor": [1, 1, 1],
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.4, 0.6, 0.75],
                "baseColorTexture": { "index": texture }
            },
        }));
        let corners = model.floats("VEC4", &[1.0, 0.25, 1.0, 1.0].repeat(4));
        square["attributes"]["COLOR_0"] = corners.into();
        model.place(square, [x, 0.0, 0.0]);
    }
    let color = [0.5 * linear, 0.1, 0.6];
    for ambient in ["[0, 0, 0]", "[1, 1, 1]"] {
        let dark = format!(
            "[environment]\nambient = {ambient}\nbackground = [0, 0, 0]\n[[light]]\n\
             kind = 'directional'\ndirection = [0, -1, 0]\n"
        );
        for picture in pictures(&scene(&model, &dark)) {
            assert_light(at(&picture, -2.0, 0.0), color, 2e-3);
            assert_light(at(&picture, 0.0, 0.0), color.map(|c| 0.75 * c), 2e-3);
            assert_light(at(&picture, 2.0, 0.0), color, 2e-3);
        }
    }
}

/// Full coverage looks opaque, from the side of its light and from the other.
#[test]
fn whole_cover_is_opaque() {
    let with = |blend: &str, direction: &str| {
        let mut model = Glb::new();
        let surface = json!({
            "baseColorFactor": [0.2, 0.5, 0.8, 1], "metallicFactor": 0, "roughnessFactor": 0.7
        });
        let square = model.square(json!({ "alphaMode": blend, "pbrMetallicRoughness": surface }));
        model.place(square, [0.0, 1.0, 0.0]);
        floor(&mut model);
        let sun = format!(
            "[environment]\nambient = [0.3, 0.2, 0.1]\nbackground = [0, 0, 0]\n[[light]]\n\
             kind = 'directional'\ndirection = {direction}\n"
        );
        pictures(&scene(&model, &sun)).into_iter().map(|picture| at(&picture, 0.25, 0.25))
    };
    for direction in ["[0.5, -1, 0.25]", "[0.5, 1, 0.25]"] {
        for (solid, covering) in with("OPAQUE", direction).zip(with("BLEND", direction)) {
            // The pane mirrors the background, which is black, where the solid scatters ambient light.
            let ambient = [0.2 * 0.3, 0.5 * 0.2, 0.8 * 0.1];
            let expected = std::array::from_fn(|i| solid[i] - 0.04 * ambient[i]);
            assert_light(covering, expected, 0.003 * solid[2] + 1e-3);
        }
    }
}

/// Between its cones a spot falls off by the square of the share of the cosines, and every lamp by a window
/// towards its range (`KHR_lights_punctual`, the recommended formulas).
#[test]
fn lamps_fall_off_as_gltf_says() {
    let whole = std::f64::consts::FRAC_PI_4;
    for (kind, inner, range) in [
        ("spot", 0.0, None),
        ("spot", 0.78, None),
        ("spot", 0.4, Some(2.5)),
        ("point", 0.0, Some(3.0)),
    ] {
        let mut model = Glb::new();
        floor(&mut model);
        let mut lamp = json!({ "type": kind, "intensity": 80 });
        if kind == "spot" {
            lamp["spot"] = json!({ "innerConeAngle": inner, "outerConeAngle": whole });
        }
        if let Some(range) = range {
            lamp["range"] = range.into();
        }
        lamps(&mut model, json!([lamp]));
        let black = "[environment]\nambient = [0, 0, 0]\nbackground = [0, 0, 0]\n";
        for picture in pictures(&scene(&model, black)) {
            for step in 0..20 {
                // The middle of a pixel.
                let x = f64::from(step) / 8.0 + 0.0625;
                let square = x * x + 0.0625 * 0.0625 + 4.0;
                let cosine = 2.0 / square.sqrt();
                let by_cone = (cosine - whole.cos()) / (f64::cos(inner) - whole.cos()).max(1e-3);
                let cone = if kind == "spot" { by_cone.clamp(0.0, 1.0).powi(2) } else { 1.0 };
                let window =
                    range.map_or(1.0, |end: f64| (1.0 - (square / (end * end)).powi(2)).max(0.0));
                let light = 80.0 / square * cosine * cone * window / std::f64::consts::PI;
                let found = f64::from(at(&picture, x as f32, 0.0)[0]);
                // The floor mirrors the rest.
                assert!(
                    (found - light).abs() < 0.05 * light + 0.02,
                    "{kind} {inner} {range:?} at {x}: {found}, not {light}"
                );
            }
        }
    }
}
