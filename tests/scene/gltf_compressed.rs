//! Compressed and quantized glTF meshes, against the formula of their surface. The files beside this one were
//! written by gltfpack 1.3, of meshoptimizer, with `-cc`, `-cc -vpf -vtf` and `-cz`, and by Google's Draco
//! 1.5, by edges (level 10) and in sequence (level 0).
use crate::common::files::Folder;
use gobo::glam::{Mat4, Vec2, Vec3};
use gobo_scene::{Limit, Model, SceneError, load_model};

const FILES: [(&str, &str); 5] = [
    ("quantized", include_str!("wave_ext.gltf")),
    ("floats", include_str!("wave_float.gltf")),
    ("KHR", include_str!("wave_khr.gltf")),
    ("Draco", include_str!("wave_draco.gltf")),
    ("Draco in sequence", include_str!("wave_draco_seq.gltf")),
];

fn read(document: &str) -> Result<Model, SceneError> {
    load_model(&Folder::new().write("wave.gltf", document), Mat4::IDENTITY)
}

/// Height and normal of the surface over (x, z) in -1..=1.
fn wave(x: f32, z: f32) -> (f32, Vec3) {
    let ((sx, cx), (sz, cz)) = ((2.0 * x).sin_cos(), (3.0 * z).sin_cos());
    (0.25 * sx * cz, Vec3::new(-0.5 * cx * cz, 1.0, 0.75 * sx * sz).normalize())
}

#[test]
fn compressed_meshes_are_what_they_were_made_of() {
    for (name, document) in FILES {
        let model = read(document).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(model.notes.is_empty(), "{name}: {:?}", model.notes);
        assert_eq!(model.triangles.len(), 32, "{name}");
        let mut area = 0.0;
        for triangle in &model.triangles {
            for c in 0..3 {
                let own = triangle.positions[c] - Vec3::new(1.0, 2.0, 3.0);
                let (height, normal) = wave(own.x, own.z);
                assert!((own.y - height).abs() < 1e-3, "{name}: {own} for {height}");
                let apart = triangle.normals[c].distance(normal);
                assert!(apart < 0.02, "{name}: {} for {normal}", triangle.normals[c]);
                let uv = (Vec2::new(own.x, own.z) + 1.0) * 0.5;
                assert!(
                    triangle.uvs[c].distance(uv) < 1e-3,
                    "{name}: {} for {uv}",
                    triangle.uvs[c]
                );
            }
            let [a, b, c] = triangle.positions;
            area += (b - a).cross(c - a).y / 2.0;
        }
        assert!((area - 4.0).abs() < 1e-2, "{name}: {area}");
    }
}

#[test]
fn damaged_compression_is_named() {
    let (_, document) = FILES[0];
    let refused = |from: &str, to: &str| {
        assert!(document.contains(from), "{from}");
        let SceneError::Invalid { message, help, .. } =
            read(&document.replace(from, to)).expect_err(to)
        else {
            panic!("{from}")
        };
        assert!(help.is_some(), "{message}");
        message
    };
    assert!(refused("\"TRIANGLES\"", "\"SQUARES\"").contains("bufferView 4: mode"));
    assert!(refused("\"OCTAHEDRAL\"", "\"OCTO\"").contains("bufferView 2: filter"));
    let beyond = "bufferView 1: its compression: its bytes leave their buffer";
    assert_eq!(refused("\"byteOffset\":68", "\"byteOffset\":680"), beyond);
    assert!(refused("\"byteOffset\":68", "\"byteOffset\":-1").contains("byteOffset"));
    assert!(refused("\"byteLength\":151", "\"byteLength\":150").contains("bufferView 1"));
    assert_eq!(refused("\"buffer\":0,\"byteOffset\":68", "\"buffer\":9"), beyond);
    let most = Limit::Unpacked.most();
    let message = refused("\"count\":96}}", "\"count\":960000000}}");
    assert!(message.contains(&most.to_string()), "{message}");
    // Far more than so few bytes can hold.
    assert!(refused("\"count\":96}}", "\"count\":96000000}}").contains("bufferView 4"));
}

#[test]
fn mutated_files_do_not_panic() {
    let mut state = 7_u32;
    let mut random = |below: usize| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as usize % below
    };
    for (_, document) in FILES {
        for _ in 0..700 {
            let mut bytes = document.as_bytes().to_vec();
            for _ in 0..1 + random(3) {
                let at = random(bytes.len());
                bytes[at] =
                    if random(2) == 0 { b'0' + random(10) as u8 } else { b'A' + random(26) as u8 };
            }
            if let Ok(model) = read(&String::from_utf8(bytes).unwrap()) {
                let positions = model.triangles.iter().flat_map(|triangle| triangle.positions);
                assert!(positions.into_iter().all(Vec3::is_finite));
            }
        }
    }
}

#[test]
fn damage_of_draco_is_named() {
    let (_, document) = FILES[3];
    let refused = |from: &str, to: &str| {
        assert!(document.contains(from), "{from}");
        let error = read(&document.replacen(from, to, 1)).expect_err(to);
        let SceneError::Invalid { message, help, .. } = error else { panic!("{from}") };
        assert!(help.is_some() && message.contains("mesh 0, primitive 0"), "{message}");
        message
    };
    let packed = "\"KHR_draco_mesh_compression\":{\"bufferView\":0,";
    assert!(refused(packed, &packed.replace(":0,", ":9,")).contains("bufferView"));
    assert!(refused("\"indices\":0,", "").contains("indices"));
    assert!(refused("\"indices\":0,", "\"indices\":0,\"mode\":5,").contains("mode"));
    assert!(refused("\"type\":\"VEC2\"", "\"type\":\"VEC4\"").contains("too few components"));
    assert!(refused("\"componentType\":5123", "\"componentType\":5122").contains("componentType"));
    assert!(
        refused("\"attributes\":{\"POSITION\":2", "\"attributes\":{\"POSITION\":7")
            .contains("no attribute 7")
    );
    assert!(refused("base64,RFJBQ08", "base64,RFJBQ0A").contains("its compression"));
    let error = read(&document.replace("\"count\":96", "\"count\":960000000")).unwrap_err();
    assert!(error.to_string().contains(&Limit::Unpacked.most().to_string()), "{error}");
}

/// Accessors whose counts differ from their stream's follow the stream, if all accessors of a primitive do.
#[test]
fn streams_of_draco_have_the_last_word() {
    let (_, document) = FILES[3];
    let whole = read(document).unwrap();
    for (from, to) in [
        ("\"count\":96", "\"count\":93"),
        ("\"count\":96", "\"count\":99"),
        ("\"count\":25", "\"count\":24"),
    ] {
        assert!(document.contains(from), "{from}");
        for changed in [document.replacen(from, to, 1), document.replace(from, to)] {
            assert_eq!(read(&changed).unwrap().triangles, whole.triangles, "{to}");
        }
    }
    // Uncompressed normals must be as many.
    let mut beside: serde_json::Value = serde_json::from_str(document).unwrap();
    beside["accessors"][2] = serde_json::json!(
        { "bufferView": 0, "componentType": 5120, "normalized": true, "count": 24, "type": "VEC3" });
    let error = read(&beside.to_string()).unwrap_err().to_string();
    assert!(error.contains("differ in count"), "{error}");
}

/// Accessors with a view of their own are read from it.
#[test]
fn draco_beside_plain_data_is_not_decoded() {
    let (_, plain) = FILES[1];
    let from = "\"primitives\":[{";
    assert!(plain.contains(from));
    let to = "\"primitives\":[{\"extensions\":{\"KHR_draco_mesh_compression\":{\"bufferView\":0,\
              \"attributes\":{\"POSITION\":0}}},";
    let (both, plain) = (read(&plain.replace(from, to)).unwrap(), read(plain).unwrap());
    assert_eq!(both.triangles, plain.triangles);
}
