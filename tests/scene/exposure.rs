//! Exposure of models with lights of their own.
use crate::common::{files::Folder, model::Glb};
use gobo::glam::Vec3;
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::{LoadOptions, Scene, load_as, load_text};
use serde_json::{Value, json};

/// Three white boards on a grey floor, under the given lights.
fn model(lights: &[(Value, [f32; 3])]) -> Glb {
    let mut model = Glb::new();
    let grey = json!({ "pbrMetallicRoughness": { "baseColorFactor": [0.4, 0.4, 0.4, 1] } });
    let white = json!({ "pbrMetallicRoughness": { "baseColorFactor": [0.9, 0.9, 0.9, 1] } });
    for (material, scale, at) in [
        (&grey, 6.0, [0.0, 0.0, 0.0]),
        (&white, 1.5, [-1.6, 0.4, 0.0]),
        (&white, 1.5, [0.0, 0.6, 0.5]),
        (&white, 1.5, [1.6, 0.8, 0.0]),
    ] {
        let mut material = material.clone();
        material["pbrMetallicRoughness"]["metallicFactor"] = json!(0);
        let square = model.square(material);
        let node = model.place(square, at);
        model.json["nodes"][node]["scale"] = json!([scale, 1, scale]);
    }
    let listed: Vec<&Value> = lights.iter().map(|(light, _)| light).collect();
    model.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    model.json["extensions"]["KHR_lights_punctual"]["lights"] = json!(listed);
    for (index, (_, at)) in lights.iter().enumerate() {
        // Straight down, for those that have a direction.
        model.node(json!({
            "translation": at, "rotation": [-0.707_106_77, 0, 0, 0.707_106_77],
            "extensions": { "KHR_lights_punctual": { "light": index } }
        }));
    }
    model
}

fn load(model: &Glb, set: &[(&str, &str)]) -> Scene {
    let mut options = LoadOptions::default();
    let small = [("camera.size", "[64, 36]"), ("shadow.size", "64"), ("camera.samples", "1")];
    options.set = small.iter().chain(set).map(|(k, v)| (k.to_string(), v.to_string())).collect();
    load_as(&Folder::new().write("model.glb", model.bytes()), &options).unwrap()
}

/// Share of the picture that would be brighter than white, before the tone curve.
fn burnt(scene: &Scene) -> f32 {
    let picture = Renderer::on_cpu().render(scene, &RenderOptions::default()).unwrap().picture;
    let shown = |light: &[f32; 3]| light[1] * scene.exposure.exp2();
    let burnt = picture.light.iter().filter(|light| shown(light) > 1.1);
    burnt.count() as f32 / picture.light.len() as f32
}

#[test]
fn lights_of_a_model_do_not_burn_its_picture() {
    let point = |candela: f32| json!({ "type": "point", "intensity": candela });
    let sun = |lux: f32| json!({ "type": "directional", "intensity": lux });
    let spot = json!({ "type": "spot", "intensity": 90, "spot": {} });
    let above = [0.3, 2.5, 0.4];
    for lights in [
        vec![(point(64.0), above)],
        vec![(point(54_351.0), above)],
        vec![(sun(10.0), above)],
        vec![(sun(80.0), above)],
        vec![(spot, [0.0, 3.0, 0.0])],
        vec![(point(50.0), [-1.5, 2.0, 0.0]), (point(50.0), [1.5, 2.0, 0.0])],
    ] {
        let model = model(&lights);
        let scene = load(&model, &[]);
        let kept = load(&model, &[("camera.exposure", "0")]);
        assert_eq!(kept.exposure, 0.0);
        let (found, before) = (burnt(&scene), burnt(&kept));
        println!("{} stops: {found} burnt, {before} before", scene.exposure);
        assert!(scene.exposure < -0.3 && found <= 0.12 && before > found, "{found}, {before}");
    }
}

/// A board under light from straight above: Lambert's law, and the sky.
#[test]
fn the_exposure_is_that_of_what_is_bright() {
    for lux in [10.0, 50.0] {
        let mut model = Glb::new();
        let square = model.square(json!({ "pbrMetallicRoughness": {
            "baseColorFactor": [0.3, 0.3, 0.3, 1], "metallicFactor": 0
        } }));
        model.place(square, [0.0; 3]);
        model.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        let sun = json!([{ "type": "directional", "intensity": lux }]);
        model.json["extensions"]["KHR_lights_punctual"]["lights"] = sun;
        model.node(json!({
            "rotation": [-0.707_106_77, 0, 0, 0.707_106_77],
            "extensions": { "KHR_lights_punctual": { "light": 0 } }
        }));
        let scene = load(&model, &[]);
        let sky = scene.mean_ambient().dot(Vec3::new(0.2126, 0.7152, 0.0722));
        let wanted = -(lux / std::f32::consts::PI + sky).log2();
        assert!((scene.exposure - wanted).abs() < 0.02, "{} stops, not {wanted}", scene.exposure);
    }
}

/// Shadows are lit by the sky as under the default sun, however bright the file's own sun is.
#[test]
fn shadows_of_bright_lights_are_not_black() {
    let sun = |lux: f32| model(&[(json!({ "type": "directional", "intensity": lux }), [0.0; 3])]);
    let shown = |scene: &Scene| scene.mean_ambient() * scene.exposure.exp2();
    let usual = shown(&load(&model(&[]), &[]));
    for lux in [50.0, 100_000.0] {
        let scene = load(&sun(lux), &[]);
        assert!(scene.exposure < -2.0 && shown(&scene).distance(usual) < 1e-3, "{}", shown(&scene));
        // Skies and exposures that are stated stay.
        let ambient = load(&sun(lux), &[("environment.ambient", "[0.2, 0.2, 0.2]")]).mean_ambient();
        assert!(ambient.distance(Vec3::splat(0.2)) < 1e-3, "{ambient}");
        let kept = load(&sun(lux), &[("camera.exposure", "-1")]).mean_ambient();
        assert!(kept.distance(usual) < 1e-3, "{kept}");
    }
}

/// Lamps that the sky would outshine are seen, by as many candelas as their file states.
#[test]
fn faint_lamps_are_seen_beside_the_sky() {
    let usual = load(&model(&[]), &[]).mean_ambient();
    let mut exposures = Vec::new();
    for candela in [150.0, 300.0, 600.0] {
        let lamp = json!({ "type": "point", "intensity": candela });
        let lit = model(&[(lamp, [0.3, 2.5, 0.4])]);
        let scene = load(&lit, &[]);
        let shown = scene.mean_ambient() * scene.exposure.exp2();
        assert!(shown.distance(usual) < 1e-3, "{shown}");
        exposures.push(scene.exposure);
        let mut glowing = lit;
        glowing.json["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
        assert_eq!(load(&glowing, &[]).exposure, 0.0);
    }
    // Twice the light, a stop less.
    let steps = exposures.windows(2).map(|pair| pair[0] - pair[1]);
    assert!(
        exposures[2] > 0.5 && steps.clone().all(|step| (step - 1.0).abs() < 0.01),
        "{exposures:?}"
    );
    let candle = json!({ "type": "point", "intensity": 1e-4 });
    assert_eq!(load(&model(&[(candle, [0.3, 2.5, 0.4])]), &[]).exposure, 5.0);
}

#[test]
fn other_pictures_keep_their_exposure() {
    let sun = json!({ "type": "directional", "intensity": 2 });
    let model = model(&[(sun, [0.0; 3])]);
    assert_eq!(load(&model, &[]).exposure, 0.0);
    assert_eq!(load(&model, &[("camera.exposure", "1.5")]).exposure, 1.5);
    // The default sun, however bright it was made.
    let bare = self::model(&[]);
    assert_eq!(load(&bare, &[("light.sun.intensity", "90")]).exposure, 0.0);
    // A model that a scene names.
    let folder = Folder::new();
    let point = json!({ "type": "point", "intensity": 64 });
    folder.write("model.glb", self::model(&[(point, [0.0, 2.0, 0.0])]).bytes());
    let path = folder.write("scene.toml", "[[mesh]]\nfile = 'model.glb'\n");
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(load_text(&text, &path, &LoadOptions::default()).unwrap().exposure, 0.0);
}
