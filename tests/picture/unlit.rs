//! Materials that show their colour in any light (glTF's `KHR_materials_unlit`).
use crate::common::{Tier, files::Folder, model::Glb, reference_picture, render, tiers};
use gobo::{glam::Vec3, model::ReceiverPoint};
use gobo_picture::Renderer;
use gobo_scene as scene;
use gobo_scene::Scene;
use serde_json::json;

const COLOR: Vec3 = Vec3::new(0.2, 0.6, 1.0);
/// Radiance of the background.
const BEHIND: f32 = 0.25;
/// alphaMode, alpha and position along x [m]; metal, unless a file says otherwise.
const SQUARES: [(&str, f32, f32); 4] =
    [("OPAQUE", 1.0, -3.0), ("MASK", 1.0, -1.0), ("BLEND", 0.5, 1.0), ("BLEND", 1.0, 3.0)];

/// Squares of 1 m from above, 10 pixels per metre, in a sun and in ambient light of `light`.
fn stage(folder: &Folder, light: f32) -> Scene {
    let mut model = Glb::new();
    for (mode, alpha, x) in SQUARES {
        let square = model.square(json!({
            "alphaMode": mode,
            "pbrMetallicRoughness": { "baseColorFactor": COLOR.extend(alpha).to_array() },
            "emissiveFactor": [1, 1, 1],
            "extensions": { "KHR_materials_unlit": {} },
        }));
        model.place(square, [x, 0.0, 0.0]);
    }
    folder.write("model.glb", model.bytes());
    let toml = format!(
        "[camera]\neye = [0, 10, 0]\ntarget = [0, 0, 0]\nup = [0, 0, -1]\nfov_y = 11.42119\nsize = [80, 20]\n\
         [environment]\nambient = [{light}, {light}, {light}]\nbackground = [{BEHIND}, {BEHIND}, {BEHIND}]\n\
         [[light]]\nkind = 'directional'\ndirection = [0, -1, 0]\nintensity = {light}\n\
         [[mesh]]\nfile = 'model.glb'\n"
    );
    scene::load(&folder.write("scene.toml", toml)).unwrap()
}

/// Transmittance of `smoke`: (1 - a)(1 - a(1 - c)).
fn passed(alpha: f32) -> Vec3 {
    (1.0 - alpha) * (1.0 - alpha * (1.0 - COLOR))
}

#[test]
fn what_is_unlit_shows_its_colour() {
    let folder = Folder::new();
    for light in [0.0, 5.0] {
        let scene = stage(&folder, light);
        let mut pictures = vec![reference_picture(&scene)];
        pictures.extend(tiers(Tier::Native).into_iter().map(|tier| render(tier, &scene).picture));
        for picture in pictures {
            for (mode, alpha, x) in SQUARES {
                let found = Vec3::from(picture.light[10 * 80 + (40.0 + 10.0 * x) as usize]);
                let expected = alpha * COLOR + BEHIND * passed(alpha);
                let apart = (found - expected).abs().max_element();
                assert!(apart < 2e-3, "{mode} {alpha} in {light}: {found}, not {expected}");
            }
        }
    }
}

#[test]
fn what_is_unlit_casts_its_shadow() {
    let scene = stage(&Folder::new(), 1.0);
    let below = |x| ReceiverPoint { position: Vec3::new(x, -0.5, 0.0), normal: Vec3::ZERO };
    let points = SQUARES.map(|(_, _, x)| below(x));
    let light = Renderer::on_cpu().light_points(&scene, &points).unwrap();
    for ((mode, alpha, _), found) in SQUARES.into_iter().zip(light) {
        let expected = passed(alpha);
        let apart = (Vec3::from(found) - expected).abs().max_element();
        assert!(apart < 3e-3, "{mode} {alpha}: {found:?}, not {expected}");
    }
}
