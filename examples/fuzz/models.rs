//! glTF seeds: a rig, instances with a sparse accessor, and compressed meshes.
use base64::{Engine as _, prelude::BASE64_STANDARD as STANDARD};
use gobo::glam::{Mat4, Quat, Vec3};
use serde_json::Value;
use std::{fmt::Write as _, io};

/// A glTF document made of accessors.
#[derive(Default)]
struct Document {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Document {
    fn view(&mut self, bytes: impl IntoIterator<Item = u8>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        let length = self.bytes.len() - offset;
        self.views.push(format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length}}}"#));
        self.views.len() - 1
    }

    /// Index of an accessor of floats; `more`: further members.
    fn floats(&mut self, kind: &str, count: usize, values: &[f32], more: &str) -> usize {
        let view = self.view(values.iter().flat_map(|value| value.to_le_bytes()));
        self.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":5126,"count":{count},"type":"{kind}"{more}}}"#
        ));
        self.accessors.len() - 1
    }

    /// The file; `scene`: all but accessors and buffers.
    fn finished(self, scene: &str) -> Vec<u8> {
        let mut text = String::new();
        let (views, accessors) = (self.views.join(",\n"), self.accessors.join(",\n"));
        let (length, data) = (self.bytes.len(), STANDARD.encode(&self.bytes));
        let _ = write!(
            text,
            r#"{{"asset":{{"version":"2.0"}},{scene},
"accessors":[{accessors}],
"bufferViews":[{views}],
"buffers":[{{"byteLength":{length},"uri":"data:application/octet-stream;base64,{data}"}}]}}"#
        );
        text.into_bytes()
    }
}

/// A triangle on two joints with two morph targets, all moved by keys.
fn rig() -> Vec<u8> {
    let mut file = Document::default();
    let bounds = r#","min":[0,0,0],"max":[2,1,0]"#;
    let places = file.floats("VEC3", 3, &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 1.0, 0.0], bounds);
    let weights = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0];
    let weights = file.floats("VEC4", 3, &weights, "");
    let joints = file.view([0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0]);
    file.accessors
        .push(format!(r#"{{"bufferView":{joints},"componentType":5121,"count":3,"type":"VEC4"}}"#));
    let joints = file.accessors.len() - 1;
    let inverse = [Mat4::IDENTITY, Mat4::from_translation(Vec3::NEG_X)];
    let inverse = inverse.map(|matrix| matrix.to_cols_array());
    let inverse = file.floats("MAT4", 2, inverse.as_flattened(), "");
    let times = file.floats("SCALAR", 2, &[0.0, 2.0], r#","min":[0],"max":[2]"#);
    let turns = [Quat::IDENTITY, Quat::from_rotation_z(1.5)].map(|turn| turn.to_array());
    let turns = file.floats("VEC4", 2, turns.as_flattened(), "");
    let up = file.floats("VEC3", 3, &[0.0, 0.0, 1.0].repeat(3), r#","min":[0,0,1],"max":[0,0,1]"#);
    let side =
        file.floats("VEC3", 3, &[1.0, 0.0, 0.0].repeat(3), r#","min":[1,0,0],"max":[1,0,0]"#);
    let amounts = file.floats("SCALAR", 4, &[0.0, 0.0, 1.0, 0.5], "");
    let scene = format!(
        r#""scene":0,"scenes":[{{"nodes":[2,0]}}],
"nodes":[{{"children":[1]}},{{"translation":[1,0,0]}},{{"mesh":0,"skin":0}}],
"skins":[{{"joints":[0,1],"inverseBindMatrices":{inverse}}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":{places},"WEIGHTS_0":{weights},"JOINTS_0":{joints}}},
"targets":[{{"POSITION":{up}}},{{"POSITION":{side}}}]}}],"weights":[0.25,0]}}],
"animations":[{{"channels":[{{"sampler":0,"target":{{"node":1,"path":"rotation"}}}},
{{"sampler":1,"target":{{"node":2,"path":"weights"}}}}],
"samplers":[{{"input":{times},"output":{turns},"interpolation":"LINEAR"}},{{"input":{times},
"output":{amounts}}}]}}]"#
    );
    file.finished(&scene)
}

/// A triangle with a texture in Basis Universal or KTX2.
pub(super) fn textured(image: &str) -> Vec<u8> {
    let mut file = Document::default();
    let bounds = r#","min":[0,0,0],"max":[1,1,0]"#;
    let places = file.floats("VEC3", 3, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], bounds);
    let coordinates = file.floats("VEC2", 3, &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0], "");
    let scene = format!(
        r#""scene":0,"scenes":[{{"nodes":[0]}}],"extensionsUsed":["KHR_texture_basisu"],
        "nodes":[{{"mesh":0}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":{places},"TEXCOORD_0":{coordinates}}},
"material":0}}]}}],
"materials":[{{"alphaMode":"BLEND","pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],
"textures":[{{"extensions":{{"KHR_texture_basisu":{{"source":0}}}}}}],"images":[{{"uri":"{image}"}}]"#
    );
    file.finished(&scene)
}

/// Meshes compressed by Draco, in a container: changes there hit the compressed bytes.
pub(super) fn draco() -> io::Result<Vec<Vec<u8>>> {
    let texts = [
        include_str!("../../tests/scene/wave_draco.gltf"),
        include_str!("../../tests/scene/wave_draco_seq.gltf"),
    ];
    texts.iter().map(|text| in_container(text)).collect()
}

/// A glTF whose one buffer is in its text, turned into a `.glb`.
fn in_container(text: &str) -> io::Result<Vec<u8>> {
    let mut document: Value = serde_json::from_str(text)?;
    let buffer = document["buffers"][0].as_object_mut().expect("a buffer");
    let address = buffer.remove("uri").expect("its address");
    let (_, data) = address.as_str().and_then(|text| text.split_once(',')).expect("its bytes");
    let mut bytes = STANDARD.decode(data).map_err(io::Error::other)?;
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = |bytes: usize| (bytes as u32).to_le_bytes();
    let head = [length(28 + json.len() + bytes.len()), length(json.len())].concat();
    let parts: [&[u8]; 8] = [
        b"glTF",
        &2_u32.to_le_bytes(),
        &head,
        b"JSON",
        &json,
        &length(bytes.len()),
        b"BIN\0",
        &bytes,
    ];
    Ok(parts.concat())
}

/// Three instances of a triangle; a sparse accessor replaces one of its corners.
fn instances() -> Vec<u8> {
    let mut file = Document::default();
    let which = file.view([2, 0]);
    let values = file.view([0.5_f32, 2.0, 0.0].into_iter().flat_map(f32::to_le_bytes));
    let sparse = format!(
        r#","min":[0,0,0],"max":[1,2,0],"sparse":{{"count":1,"indices":{{"bufferView":{which},
        "componentType":5123}},"values":{{"bufferView":{values}}}}}"#
    );
    let places = file.floats("VEC3", 3, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], &sparse);
    let moved = [0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, -2.0];
    let moved = file.floats("VEC3", 3, &moved, "");
    let turned = file.floats("VEC4", 3, &Quat::IDENTITY.to_array().repeat(3), "");
    let scaled = file.floats("VEC3", 3, &[1.0, 2.0, 0.5].repeat(3), "");
    let scene = format!(
        r#""scene":0,"scenes":[{{"nodes":[0]}}],"extensionsUsed":["EXT_mesh_gpu_instancing"],
"nodes":[{{"mesh":0,"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{
"TRANSLATION":{moved},"ROTATION":{turned},"SCALE":{scaled}}}}}}}}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":{places}}}}}]}}]"#
    );
    file.finished(&scene)
}

/// Seeds by the name of their reader.
pub(super) fn seeds() -> [(&'static str, Vec<Vec<u8>>); 3] {
    let compressed: [&[u8]; 3] = [
        include_bytes!("../../tests/scene/wave_ext.gltf"),
        include_bytes!("../../tests/scene/wave_float.gltf"),
        include_bytes!("../../tests/scene/wave_khr.gltf"),
    ];
    [
        ("rig", vec![rig()]),
        ("instances", vec![instances()]),
        ("meshopt", compressed.map(<[u8]>::to_vec).into()),
    ]
}
