//! glTF models, written by the tests themselves.
use super::particles::Random;
use crate::common::files::{Folder, TempFile};
use gobo::{
    glam::{Mat4, Quat, Vec2, Vec3, Vec4},
    model::{LightKind, Material, Transfer},
};
use gobo_scene as scene;
use gobo_scene::{Model, SceneError, load_model};

/// A quad's worth of positions, uvs, strip indices and a 2 x 1 image, then the rest of the document.
const DOCUMENT: &str = r#"{
    "asset": {"version": "2.0"},
    "extensionsUsed": ["KHR_lights_punctual"],
    "extensionsRequired": ["KHR_materials_volume"],
    "scene": 0,
    "scenes": [{"nodes": [0, 2, 3, 4, 5, 6]}],
    "nodes": [
        {"children": [1], "translation": [10, 0, 0]},
        {"mesh": 0, "scale": [2, 1, -1]},
        {"mesh": 1},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}, "rotation": [-0.70710678, 0, 0, 0.70710678]},
        {"extensions": {"KHR_lights_punctual": {"light": 1}}, "translation": [1, 2, 3]},
        {"camera": 0, "translation": [0, 0, 5]},
        {"extensions": {"KHR_lights_punctual": {"light": 2}}}
    ],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1, "aspectRatio": 2}}],
    "extensions": {"KHR_lights_punctual": {"lights": [
        {"type": "directional", "intensity": 3, "name": "sun"},
        {"type": "spot", "intensity": 6830, "spot": {"outerConeAngle": 0.4}, "color": [1, 0.5, 0]},
        {"type": "point", "intensity": 6830}
    ]}},
    "meshes": [
        {"primitives": [
            {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0},
            {"attributes": {"POSITION": 0}, "indices": 2, "mode": 5, "material": 1}
        ]},
        {"primitives": [
            {"attributes": {"POSITION": 0}, "indices": 2, "mode": 6, "material": 2},
            {"attributes": {"POSITION": 0}, "material": 3},
            {"attributes": {"POSITION": 0}, "material": 4},
            {"attributes": {"POSITION": 0}, "mode": 0},
            {"attributes": {"POSITION": 0}}
        ]}
    ],
    "materials": [
        {"name": "pane", "alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.25, 0.4],
            "baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0.5, 0], "scale": [2, 2]}}}}},
        {"name": "glass", "pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.25, 0.3], "metallicFactor": 0, "roughnessFactor": 0.1},
            "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.5}}},
        {"name": "leaf", "alphaMode": "MASK", "alphaCutoff": 0.25, "emissiveFactor": [0, 1, 0],
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 3}}},
        {"name": "body", "pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_volume": {"thicknessFactor": 2, "attenuationDistance": 4, "attenuationColor": [0.0625, 1, 0.5]}}},
        {"name": "film", "pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1, "transmissionTexture": {"index": 0}}}}
    ],
    "textures": [{"source": 0}],
    "images": [{"bufferView": 3, "mimeType": "image/png", "name": "dots"}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
        {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
        {"bufferView": 2, "componentType": 5123, "count": 5, "type": "SCALAR"}
    ],
    "bufferViews": [
        {"buffer": 0, "byteLength": 36},
        {"buffer": 0, "byteOffset": 36, "byteLength": 24},
        {"buffer": 0, "byteOffset": 60, "byteLength": 10},
        {"buffer": 0, "byteOffset": 72, "byteLength": PNG_LENGTH}
    ],
    "buffers": [{"byteLength": BUFFER_LENGTHURI}]
}"#;

fn buffer() -> Vec<u8> {
    let floats: [f32; 15] = [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 1.];
    let mut bytes: Vec<u8> = floats.iter().flat_map(|f| f.to_le_bytes()).collect();
    bytes.extend([0u16, 1, 2, 1, 0, 0].iter().flat_map(|i| i.to_le_bytes()));
    let mut png = std::io::Cursor::new(Vec::new());
    let image = image::GrayAlphaImage::from_raw(2, 1, vec![255, 255, 188, 51]).unwrap();
    image.write_to(&mut png, image::ImageFormat::Png).unwrap();
    bytes.extend(png.into_inner());
    bytes
}

fn document(uri: &str) -> String {
    let length = buffer().len();
    DOCUMENT
        .replace("PNG_LENGTH", &(length - 72).to_string())
        .replace("BUFFER_LENGTH", &length.to_string())
        .replace("URI", uri)
}

fn glb_of(document: &str) -> Vec<u8> {
    let mut chunks = Vec::new();
    for (kind, mut bytes, fill) in
        [(b"JSON", document.as_bytes().to_vec(), b' '), (b"BIN\0", buffer(), 0)]
    {
        bytes.resize(bytes.len().next_multiple_of(4), fill);
        chunks.extend((bytes.len() as u32).to_le_bytes());
        chunks.extend(kind);
        chunks.extend(bytes);
    }
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((chunks.len() as u32 + 12).to_le_bytes());
    glb.extend(chunks);
    glb
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for chunk in bytes.chunks(3) {
        let bits = chunk.iter().enumerate().fold(0, |b, (i, c)| b | u32::from(*c) << (16 - 8 * i));
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i)) as usize & 63];
            text.push(if i <= chunk.len() { char::from(digit) } else { '=' });
        }
    }
    text
}

fn load(name: &str, bytes: impl AsRef<[u8]>) -> Result<Model, SceneError> {
    load_model(&TempFile::new(name, bytes).0, Mat4::IDENTITY)
}

fn material<'a>(model: &'a Model, name: &str) -> &'a Material {
    model.materials.iter().find(|material| material.name == name).unwrap()
}

#[test]
fn triangles_are_in_world_space() {
    let file = TempFile::new("model.glb", glb_of(&document("")));
    let turn =
        Mat4::from_rotation_translation(Quat::from_rotation_y(0.5), Vec3::new(0.0, 1.0, 0.0));
    let model = load_model(&file.0, turn).unwrap();
    // A list of 1, a strip of 3 of which one is flat, a fan of 3 of which one is flat, 3 lists.
    assert_eq!(model.skipped["triangle without area"], 2);
    assert_eq!(model.skipped["points and lines ignored"], 1);
    assert_eq!(model.triangles.len(), 1 + 2 + 2 + 3);
    let first = model.triangles[0];
    let world = turn * Mat4::from_translation(Vec3::X * 10.0);
    let corners = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y];
    for (got, want) in first.positions.into_iter().zip(corners) {
        assert!(got.abs_diff_eq(world.transform_point3(want), 1e-5), "{got} {want}");
    }
    let normal = turn.transform_vector3(Vec3::Z);
    assert!(first.normals.iter().all(|n| n.abs_diff_eq(normal, 1e-5)), "{:?}", first.normals);
    assert_eq!(first.uvs, [Vec2::new(0.5, 0.0), Vec2::new(2.5, 0.0), Vec2::new(0.5, 2.0)]);
}

#[test]
fn materials_become_casters() {
    let model = load("materials.glb", glb_of(&document(""))).unwrap();
    let pane = material(&model, "pane");
    assert_eq!((pane.transfer, pane.transmission), (Transfer::Smoke, 0.0));
    assert_eq!(pane.tint, Vec4::new(1.0, 0.5, 0.25, 0.4));
    let dots = &model.textures[pane.texture.unwrap() as usize];
    assert_eq!((dots.width, dots.height, dots.name.as_str()), (2, 1, "dots"));
    assert_eq!(dots.rgba, [255, 255, 255, 255, 188, 188, 188, 51]);
    let glass = material(&model, "glass");
    assert_eq!((glass.transfer, glass.transmission, glass.roughness), (Transfer::Filter, 0.5, 0.1));
    assert_eq!(glass.tint, Vec4::new(0.5, 0.25, 0.125, 1.0));
    let leaf = material(&model, "leaf");
    assert_eq!((leaf.transfer, leaf.cutoff), (Transfer::Cutout, 0.25));
    assert_eq!(leaf.emission, Vec3::new(0.0, 3.0, 0.0));
    let body = material(&model, "body");
    let absorbs = (body.attenuation_color, body.attenuation_distance);
    assert_eq!(absorbs, (Vec3::new(0.0625, 1.0, 0.5), 4.0));
    assert_eq!(body.tint, Vec4::ONE);
    // A triangle has no inside, and is crossed once: attenuation colour^(2 / 4).
    let body = material(&model, "body (sheet)");
    assert!(!body.is_volume());
    let whole = body.tint.truncate();
    assert!(whole.abs_diff_eq(Vec3::new(0.25, 1.0, 0.5f32.sqrt()), 1e-6), "{whole}");
    let film = material(&model, "film");
    let grey = &model.textures[film.texture.unwrap() as usize].rgba;
    // The linear red 188 / 255 as sRGB; alpha does not count where alphaMode is OPAQUE.
    assert_eq!(grey, &[255, 255, 255, 255, 223, 223, 223, 255]);
    assert_eq!(model.materials.last().unwrap().transfer, Transfer::Opaque);
}

#[test]
fn emissive_textures_are_read() {
    let shining = r#""emissiveFactor": [0, 1, 0], "emissiveTexture": {"index": 0},"#;
    let with = document("").replace(r#""emissiveFactor": [0, 1, 0],"#, shining);
    assert_ne!(with, document(""));
    let model = load("shining.glb", glb_of(&with)).unwrap();
    let leaf = material(&model, "leaf");
    let image = &model.textures[leaf.emissive_texture.unwrap() as usize];
    // Its alpha is ignored.
    assert_eq!(image.rgba, [255, 255, 255, 255, 188, 188, 188, 255]);
    assert_eq!((leaf.texture, leaf.emission), (None, Vec3::new(0.0, 3.0, 0.0)));
    assert!(!model.skipped.keys().any(|reason| reason.contains("emissive")), "{:?}", model.skipped);
    // An emission factor of 0 needs no image.
    let dark = with.replace("\"emissiveFactor\": [0, 1, 0],", "");
    let model = load("dark.glb", glb_of(&dark)).unwrap();
    assert_eq!(material(&model, "leaf").emissive_texture, None);
}

#[test]
fn glass_bends_and_blurs_by_ior_and_roughness() {
    let dense = "\"extensions\": {\"KHR_materials_ior\": {\"ior\": 1.25},";
    let text = document("").replacen(
        "\"extensions\": {\n            \"KHR_materials_transmission\": \
         {\"transmissionFactor\": 1},\n            \"KHR_materials_volume\"",
        &format!(
            "{dense} \"KHR_materials_transmission\": {{\"transmissionFactor\": 1}}, \
            \"KHR_materials_volume\""
        ),
        1,
    );
    for (text, ior, frost) in [(document(""), 1.5, 1.0), (text, 1.25, 0.5)] {
        let model = load("glass.glb", glb_of(&text)).unwrap();
        assert!(model.notes.is_empty(), "{:?}", model.notes);
        let of = |name| (material(&model, name).ior, material(&model, name).frost);
        // A thin wall of roughness 0.1, a rough body, and the same for a mesh without an inside.
        assert_eq!(
            (of("glass").0, of("body"), of("body (sheet)")),
            (1.0, (ior, frost), (1.0, frost))
        );
        assert!((of("glass").1 - 0.01).abs() < 1e-6);
        assert_eq!((of("pane"), of("leaf")), ((1.0, 0.0), (1.0, 0.0)));
    }
}

#[test]
fn bodies_grow_with_their_node() {
    let file = TempFile::new("grown.glb", glb_of(&document("")));
    let model = load_model(&file.0, Mat4::from_scale(Vec3::splat(2.0))).unwrap();
    let tint = material(&model, "body (sheet)").tint;
    assert!((tint.x - 0.0625).abs() < 1e-6, "{tint}");
}

#[test]
fn a_mesh_may_be_seen_without_casting() {
    let folder = Folder::new();
    folder.write("model.glb", glb_of(&document("")));
    let mesh = "[[mesh]]\nfile = 'model.glb'\n";
    let path = folder.write("scene.toml", format!("{mesh}{mesh}casts = false\n"));
    let scene = scene::load(&path).unwrap();
    let (first, second) = scene.materials.split_at(scene.materials.len() / 2);
    assert!(!first.is_empty() && first.iter().all(|material| material.casts));
    assert!(second.iter().all(|material| material.visible && !material.casts));
}

#[test]
fn lights_and_camera() {
    let model = load("lights.glb", glb_of(&document(""))).unwrap();
    let [sun, spot, bulb] = &model.lights[..] else { panic!("{:?}", model.lights) };
    let LightKind::Directional { direction } = sun.kind else { panic!("{sun:?}") };
    assert!(direction.abs_diff_eq(Vec3::NEG_Y, 1e-6), "{direction}");
    assert_eq!((sun.name.as_str(), sun.intensity), ("sun", 3.0));
    assert_eq!((spot.intensity, spot.color), (10.0, Vec3::new(1.0, 0.5, 0.0)));
    let (position, direction) = (Vec3::new(1.0, 2.0, 3.0), Vec3::NEG_Z);
    assert_eq!(spot.kind, LightKind::Spot { position, direction, angle: 0.8 });
    assert_eq!(bulb.kind, LightKind::Point { position: Vec3::ZERO });
    let camera = model.camera.unwrap();
    assert_eq!((camera.eye, camera.target), (Vec3::Z * 5.0, Vec3::Z * 4.0));
    assert_eq!((camera.fov_y, camera.size.to_array()), (0.5, [1080, 540]));
}

#[test]
fn half_spaces_of_light_get_a_map() {
    let wide = document("").replace("\"outerConeAngle\": 0.4", "\"outerConeAngle\": 1.5707963");
    assert_ne!(wide, document(""));
    let model = load("wide.glb", glb_of(&wide)).unwrap();
    let LightKind::Spot { angle, .. } = model.lights[1].kind else { panic!("{:?}", model.lights) };
    assert!((angle * 0.5).tan() > 1.0 && angle < std::f32::consts::PI, "{angle}");
}

/// Regression: an angle below 0 ended the program (found by `make fuzz`).
#[test]
fn cones_without_an_angle_are_left_out() {
    let whole = load("whole.glb", glb_of(&document(""))).unwrap();
    for angle in ["0", "-1e-45", "-0.4"] {
        let text = document("")
            .replace("\"outerConeAngle\": 0.4", &format!("\"outerConeAngle\": {angle}"));
        let model = load("cone.glb", glb_of(&text)).unwrap();
        assert_eq!(model.lights.len() + 1, whole.lights.len(), "{angle}");
        let left_out = |model: &Model| model.skipped.values().sum::<u64>();
        assert_eq!(left_out(&model), left_out(&whole) + 1, "{angle}: {:?}", model.skipped);
    }
}

#[test]
fn buffers_from_data_uris_and_files() {
    let embedded = load("embedded.glb", glb_of(&document(""))).unwrap();
    let data = format!(r#","uri":"data:application/octet-stream;base64,{}""#, base64(&buffer()));
    let uri = load("uri.gltf", document(&data)).unwrap();
    assert_eq!(uri.triangles, embedded.triangles);
    assert_eq!(uri.textures, embedded.textures);
    let beside = TempFile::new("be side.bin", buffer());
    let name = beside.0.file_name().unwrap().to_string_lossy().replace(' ', "%20");
    let file = load("file.gltf", document(&format!(r#","uri":"{name}""#))).unwrap();
    assert_eq!(file.triangles, embedded.triangles);
}

#[test]
fn errors_name_what_is_wrong() {
    let error = |from: &str, to: &str| {
        let changed = document("").replace(from, to);
        assert_ne!(changed, document(""), "{from} is not in the document");
        let error = load("wrong.glb", glb_of(&changed)).expect_err(to).to_string();
        assert!(error.contains("wrong.glb"), "{error}");
        error
    };
    let unknown = "EXT_texture_avif";
    assert!(error("KHR_materials_volume\"]", &format!("{unknown}\"]")).contains(unknown));
    assert!(error("\"children\": [1]", "\"children\": [0]").contains("ancestor"));
    assert!(error("\"children\": [1]", "\"children\": [1, 1]").contains("two parents"));
    assert!(error("\"children\": [1]", "\"children\": [99]").contains("nodes[0].children[0]"));
    assert!(error("\"byteLength\": 36", "\"byteLength\": 35").contains("accessor 0"));
    assert!(error("\"byteOffset\": 36", "\"byteOffset\": 3600").contains("bufferView 1"));
    assert!(error("\"count\": 5", "\"count\": 5000000000000000000").contains("accessor 2"));
    assert!(error("\"count\": 5", "\"count\": 0").contains("accessor 2"));
    assert!(error("\"byteOffset\": 60", "\"byteOffset\": 44").contains("index"));
    assert!(error("\"byteOffset\": 72", "\"byteOffset\": 70").contains("image 0"));
    assert!(error("\"bufferView\": 3, ", "").contains("neither a bufferView"));
    assert!(
        error("\"perspective\": {", "\"orthographic\": {\"xmag\":1,\"ymag\":1,\"zfar\":9,")
            .contains("camera 0")
    );
    let uvs = "5126, \"count\": 3, \"type\": \"VEC2\"";
    assert!(error(uvs, &uvs.replace("5126", "5125")).contains("holds no uvs"));
    let missing = document(r#","uri":"%ff%zz.bin""#);
    let error = load("missing.gltf", missing).unwrap_err();
    assert!(matches!(error, SceneError::Invalid { help: Some(_), .. }), "{error}");
    let error = error.to_string();
    assert!(error.contains("missing.gltf") && error.contains("`%ff%zz.bin`"), "{error}");
    let far = document(r#","uri":"https://example.com/a.bin""#);
    assert!(load("far.gltf", far).unwrap_err().to_string().contains("https://example.com"));
}

#[test]
fn damaged_files_never_panic() {
    let glb = glb_of(&document(""));
    for end in (0..glb.len()).step_by(7) {
        assert!(load("cut.glb", &glb[..end]).is_err(), "cut at {end}");
    }
    let mut random = Random(11);
    for round in 0..4000 {
        let mut bytes = glb.clone();
        for _ in 0..1 + random.below(3) {
            let at = random.below(bytes.len());
            // Digits and printable text keep the JSON readable more often than noise does.
            bytes[at] = match round % 3 {
                0 => random.below(256) as u8,
                1 => b'0' + random.below(10) as u8,
                _ => b' ' + random.below(95) as u8,
            };
        }
        if let Ok(model) = load("mutated.glb", &bytes) {
            let numbers =
                model.triangles.iter().flat_map(|t| t.positions.into_iter().chain(t.normals));
            assert!(numbers.into_iter().all(Vec3::is_finite));
            assert!(model.triangles.len() < 100);
        }
    }
}
