//! Transmittance of glTF materials, as their extensions define it.
use crate::common::{files::Folder, model::Glb};
use gobo::{
    glam::Vec3,
    model::{Fresnel, ReceiverPoint},
};
use gobo_picture::Renderer;
use gobo_scene as scene;
use gobo_scene::Scene;
use serde_json::{Value, json};

const SUN: &str = "[[light]]\nkind = 'directional'\ndirection = [0, -1, 0]\n[[material]]\nname = 'ground'\n\
    transfer = 'opaque'\n[[shape]]\nkind = 'plane'\nmaterial = 'ground'\nscale = [9, 1, 9]\n\
    translation = [0, -1, 0]\n[shadow]\nsize = 512\n";

fn scene(folder: &Folder, model: &Glb, keys: &str) -> Scene {
    folder.write("model.glb", model.bytes());
    let toml = format!("{SUN}[[mesh]]\nfile = 'model.glb'\n{keys}");
    scene::load(&folder.write("scene.toml", toml)).unwrap()
}

/// Light of the sun half a metre below a point.
fn below(scene: &Scene, places: &[[f32; 2]]) -> Vec<[f32; 3]> {
    let point =
        |&[x, z]: &[f32; 2]| ReceiverPoint { position: Vec3::new(x, -0.5, z), normal: Vec3::ZERO };
    let points: Vec<_> = places.iter().map(point).collect();
    Renderer::on_cpu().light_points(scene, &points).unwrap()
}

#[track_caller]
fn assert_light(found: [f32; 3], wanted: [f32; 3]) {
    let apart = found.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(apart < 3e-3, "{found:?}, not {wanted:?}");
}

fn plain(rgba: [f32; 4]) -> Value {
    json!({ "baseColorFactor": rgba, "metallicFactor": 0 })
}

fn glass(mut material: Value) -> Value {
    material["extensions"]["KHR_materials_transmission"] = json!({ "transmissionFactor": 1 });
    material
}

fn volume(thickness: f32) -> Value {
    json!({ "thicknessFactor": thickness, "attenuationDistance": 1, "attenuationColor": [0.81, 0.49, 1] })
}

/// A closed cube, a metre wide.
fn cube(model: &mut Glb, material: Value) -> Value {
    let mut cube = model.square(material);
    let corner = |i: usize| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32 - 0.5);
    let corners: Vec<f32> = (0..8).flat_map(corner).collect();
    let faces: [u16; 36] = [
        0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6,
        1, 3, 5, 3, 7, 5,
    ];
    let faces: Vec<u8> = faces.iter().flat_map(|i| i.to_le_bytes()).collect();
    cube["attributes"] = json!({ "POSITION": model.floats("VEC3", &corners) });
    cube["attributes"]["TEXCOORD_0"] = model.floats("VEC2", &[0.5; 16]).into();
    cube["indices"] =
        model.items((crate::common::model::USHORT, "SCALAR", 36), &faces, json!({})).into();
    cube
}

/// Alpha of BLEND is coverage: behind white cloth of alpha 1 no light is left.
#[test]
fn what_blends_covers() {
    let mut model = Glb::new();
    let colors =
        [[1.0, 1.0, 1.0, 1.0], [0.1, 0.6, 0.1, 1.0], [1.0, 1.0, 1.0, 0.5], [0.2, 0.6, 1.0, 0.5]];
    for (color, x) in colors.into_iter().zip([-3.0, -1.0, 1.0, 3.0]) {
        let square =
            model.square(json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": plain(color) }));
        model.place(square, [x, 0.0, 0.0]);
    }
    let places = [-3.0, -1.0, 1.0, 3.0].map(|x| [x, 0.1]);
    let folder = Folder::new();
    let light = below(&scene(&folder, &model, ""), &places);
    // (1 - a)(1 - a(1 - c)).
    let covered = [[0.0; 3], [0.0; 3], [0.5; 3], [0.3, 0.4, 0.5]];
    light.into_iter().zip(covered).for_each(|(found, wanted)| assert_light(found, wanted));
    // 1 - a(1 - c), the gel.
    let light = below(&scene(&folder, &model, "transfer = 'filter'\n"), &places);
    let filtered = [[1.0; 3], [0.1, 0.6, 0.1], [1.0; 3], [0.6, 0.8, 1.0]];
    light.into_iter().zip(filtered).for_each(|(found, wanted)| assert_light(found, wanted));
}

#[test]
fn metal_transmits_nothing() {
    let mut model = Glb::new();
    let left = [[0, 0, 255, 255].repeat(8), [0, 0, 0, 255].repeat(8)].concat();
    let lead = model.texture(16, 1, &left);
    let by_texture = |factor: f32| {
        json!({
            "metallicFactor": factor, "metallicRoughnessTexture": { "index": lead }
        })
    };
    let materials = [
        (json!({}), [0.0; 3], [0.0; 3]),
        (
            json!({ "metallicFactor": 0.25, "baseColorFactor": [1, 0.8, 0.4, 1] }),
            [0.75, 0.6, 0.3],
            [0.75, 0.6, 0.3],
        ),
        (json!({ "metallicFactor": 0 }), [1.0; 3], [1.0; 3]),
        (by_texture(1.0), [0.0; 3], [1.0; 3]),
        (by_texture(0.5), [0.5; 3], [1.0; 3]),
    ];
    let mut places = Vec::new();
    for (i, (surface, ..)) in materials.iter().enumerate() {
        let x = 1.5 * i as f32 - 3.0;
        let square = model.square(glass(json!({ "pbrMetallicRoughness": surface })));
        model.place(square, [x, 0.0, 0.0]);
        places.extend([[x - 0.25, 0.1], [x + 0.25, 0.1]]);
    }
    let light = below(&scene(&Folder::new(), &model, ""), &places);
    for (pair, (_, left, right)) in light.chunks(2).zip(materials) {
        assert_light(pair[0], left);
        assert_light(pair[1], right);
    }
}

/// A sheet is crossed once, so it takes the whole of its tint and thickness; a body's two faces take it
/// together, with or without attenuation.
#[test]
fn sheets_and_bodies_take_their_tint_once() {
    let mut model = Glb::new();
    let texture = model.texture(1, 1, &[188, 255, 137, 255]);
    let surface = json!({
        "metallicFactor": 0,
        "baseColorFactor": [0.04, 0.25, 1, 1],
        "baseColorTexture": { "index": texture }
    });
    let material = |volume: Value| {
        let material = glass(json!({ "pbrMetallicRoughness": surface.clone() }));
        let mut material = material;
        material["extensions"]["KHR_materials_volume"] = volume;
        material
    };
    let linear = |byte: f32| ((byte / 255.0 + 0.055) / 1.055).powf(2.4);
    let tint = [0.04 * linear(188.0), 0.25, linear(137.0)];
    let square = model.square(material(volume(0.5)));
    model.place(square, [-2.0, 0.0, 0.0]);
    for (x, volume) in [(0.0, volume(0.5)), (2.0, json!({ "thicknessFactor": 0.5 }))] {
        let cube = cube(&mut model, material(volume));
        model.place(cube, [x, 0.0, 0.0]);
    }
    let light = below(
        &scene(&Folder::new(), &model, "translation = [0, 0.5, 0]\n"),
        &[[-2.0, 0.1], [0.0, 0.1], [2.0, 0.1]],
    );
    // The sheet is half a metre thick, the cube a metre.
    let by = |rgb: [f32; 3]| std::array::from_fn(|i| tint[i] * rgb[i]);
    assert_light(light[0], by([0.9, 0.7, 1.0]));
    assert_light(light[1], by([0.81, 0.49, 1.0]));
    assert_light(light[2], tint);
}

/// Dispersion of bodies; of a thin wall, which does not refract, it is ignored. A file that leaves the index
/// out, as three.js does where it is 1.5, states it by its dispersion.
#[test]
fn bodies_disperse_light() {
    let of = |dispersion: f32, thickness: f32| {
        let mut material = glass(json!({ "pbrMetallicRoughness": plain([1.0; 4]) }));
        material["extensions"]["KHR_materials_ior"] = json!({ "ior": 1.5 });
        material["extensions"]["KHR_materials_dispersion"] = json!({ "dispersion": dispersion });
        material["extensions"]["KHR_materials_volume"] = json!({ "thicknessFactor": thickness });
        material
    };
    let mut model = Glb::new();
    let mut usual = of(0.25, 1.0);
    usual["extensions"].as_object_mut().unwrap().remove("KHR_materials_ior");
    for (i, material) in
        [of(0.5, 1.0), of(0.0, 1.0), of(0.5, 0.0), of(99.0, 1.0), usual].iter().enumerate()
    {
        let cube = cube(&mut model, material.clone());
        model.place(cube, [2.0 * i as f32, 0.0, 0.0]);
    }
    let scene = scene(&Folder::new(), &model, "");
    let of_glass = scene.materials.iter().filter(|material| material.transmission > 0.0);
    let found: Vec<_> = of_glass.map(|material| (material.dispersion, material.fresnel)).collect();
    let (face, pane) = (Fresnel::Face { ior: 1.5 }, Fresnel::Pane { ior: 1.5 });
    assert_eq!(found, [(0.5, face), (0.0, face), (0.0, pane), (20.0, face), (0.25, face)]);
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
}

/// With `KHR_materials_ior` thin walls reflect on both their faces, and bodies on each of the two crossed
/// faces; without it nothing is lost, whatever the extension's default.
#[test]
fn glass_with_an_index_reflects() {
    let clear = || glass(json!({ "pbrMetallicRoughness": plain([1.0; 4]) }));
    let dense = |mut material: Value, ior: f32| {
        material["extensions"]["KHR_materials_ior"] = json!({ "ior": ior });
        material
    };
    let body = || {
        let mut material = clear();
        material["extensions"]["KHR_materials_volume"] = json!({ "thicknessFactor": 0.5 });
        material
    };
    let face = |ior: f32| 1.0 - ((ior - 1.0) / (ior + 1.0)).powi(2);
    let pane = |ior: f32| face(ior) / (2.0 - face(ior));
    let mut model = Glb::new();
    let (mut places, mut wanted) = (Vec::new(), Vec::new());
    let squares =
        [(clear(), 1.0), (dense(clear(), 1.5), pane(1.5)), (dense(clear(), 1.0), 1.0)].into_iter();
    // A sheet has one face, and is a pane.
    let sheets = [(body(), 1.0), (dense(body(), 1.5), pane(1.5))];
    for (i, (material, light)) in squares.chain(sheets).enumerate() {
        let x = 1.5 * i as f32 - 4.0;
        let square = model.square(material);
        model.place(square, [x, 0.0, 0.0]);
        places.push([x + 0.1, 0.1]);
        wanted.push(light);
    }
    for (i, (material, light)) in
        [(body(), 1.0), (dense(body(), 2.0), face(2.0).powi(2))].into_iter().enumerate()
    {
        let x = 1.5 * i as f32 - 4.0;
        let cube = cube(&mut model, material);
        model.place(cube, [x, 0.0, 3.0]);
        places.push([x + 0.1, 3.1]);
        wanted.push(light);
    }
    let light = below(&scene(&Folder::new(), &model, "translation = [0, 0.5, 0]\n"), &places);
    for (found, wanted) in light.into_iter().zip(wanted) {
        assert_light(found, [wanted; 3]);
    }
}

/// `KHR_materials_diffuse_transmission`: the share and the colour, each times its texture; where alpha cuts,
/// there is no leaf.
#[test]
fn leaves_pass_light_diffusely() {
    let mut model = Glb::new();
    // Alphas 128 and 255; linear colours of 0.2140 (sRGB 128) and 1.
    let share = model.texture(1, 1, &[0, 0, 0, 128]);
    let tint = model.texture(1, 1, &[128, 255, 255, 0]);
    let solid = model.texture(1, 1, &[255, 0, 0, 153]);
    let clear = model.texture(1, 1, &[255, 0, 0, 102]);
    let leaf = |extension: Value, more: Value| {
        let mut material = json!({ "pbrMetallicRoughness": plain([0.2, 0.9, 0.1, 1.0]),
            "extensions": { "KHR_materials_diffuse_transmission": extension } });
        let more = more.as_object().unwrap().clone();
        material.as_object_mut().unwrap().extend(more);
        material
    };
    let plainly = json!({
        "diffuseTransmissionFactor": 0.5, "diffuseTransmissionColorFactor": [0.4, 0.8, 1]
    });
    let textured = json!({ "diffuseTransmissionFactor": 0.5, "diffuseTransmissionColorFactor": [1, 0.8, 1],
        "diffuseTransmissionTexture": { "index": share },
        "diffuseTransmissionColorTexture": { "index": tint } });
    let cut = |texture: usize| {
        json!({ "alphaMode": "MASK", "pbrMetallicRoughness":
            { "metallicFactor": 0, "baseColorTexture": { "index": texture } } })
    };
    let half = json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": plain([1.0, 1.0, 1.0, 0.5]) });
    let metal = json!({ "pbrMetallicRoughness": { "metallicFactor": 1 } });
    let materials = [
        (leaf(json!({}), json!({})), [0.0; 3]),
        (leaf(plainly.clone(), json!({})), [0.2, 0.4, 0.5]),
        (leaf(textured, json!({})), [0.251 * 0.2159, 0.251 * 0.8, 0.251]),
        (leaf(plainly.clone(), cut(solid)), [0.2, 0.4, 0.5]),
        (leaf(plainly.clone(), cut(clear)), [1.0; 3]),
        (leaf(plainly.clone(), half), [0.6, 0.7, 0.75]),
        (leaf(plainly, metal), [0.0; 3]),
    ];
    let places: Vec<_> = (0..7).map(|i| [1.5 * i as f32 - 4.4, 0.1]).collect();
    let mut wanted = Vec::new();
    for ((material, light), [x, _]) in materials.into_iter().zip(&places) {
        let square = model.square(material);
        model.place(square, [x - 0.1, 0.0, 0.0]);
        wanted.push(light);
    }
    let scene = scene(&Folder::new(), &model, "translation = [0, 0.5, 0]\n");
    assert!(!scene.notes.iter().any(|note| note.contains("not read")), "{:?}", scene.notes);
    for (found, wanted) in below(&scene, &places).into_iter().zip(wanted) {
        assert_light(found, wanted);
    }
    // The rest of the light stays, by the texture if there is one.
    let shares = scene.materials.iter().filter(|m| m.name.ends_with("(far side)"));
    let shares: Vec<_> = shares.map(|material| material.transmission).collect();
    assert_eq!(shares, [0.5, 0.0, 0.5, 0.5, 0.5, 0.5]);
}

/// The colour of transparent texels does not bleed into others.
#[test]
fn clear_texels_have_no_colour() {
    let mut model = Glb::new();
    let mut rgba = [[0, 0, 0, 0]; 64];
    for i in 0..16 {
        rgba[(2 + i / 4) * 8 + 2 + i % 4] = [255, 0, 0, 255];
    }
    let texture = model.texture(8, 8, rgba.as_flattened());
    let surface = json!({ "metallicFactor": 0, "baseColorTexture": { "index": texture } });
    let square = model.square(json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": surface }));
    model.place(square, [0.0; 3]);
    let places: Vec<[f32; 2]> = (0..40).map(|i| [i as f32 / 80.0 - 0.25, 0.03]).collect();
    let folder = Folder::new();
    let light = below(&scene(&folder, &model, "transfer = 'filter'\n"), &places);
    for (place, [red, green, _]) in places.iter().zip(light) {
        assert!(red > 0.995, "red glass takes {red} of red at {place:?}");
        // Between the middles of the texels alpha is even.
        let inside = ((0.25 - place[0].abs()) * 8.0 + 0.5).clamp(0.0, 1.0);
        assert!((green - (1.0 - inside)).abs() < 0.06, "{green} at {place:?}");
    }
}
