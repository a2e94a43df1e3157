//! Compressed and quantized glTF meshes, against the formula of the surface that they were made of. The files
//! beside this one were written by gltfpack 1.3, of meshoptimizer, with `-cc`, `-cc -vpf -vtf` and `-cz`.
use crate::common::files::Folder;
use gobo::{
    glam::{Mat4, Vec2, Vec3},
    scene::{Limit, Model, SceneError, load_model},
};

const FILES: [(&str, &str); 3] = [
    ("quantized", include_str!("wave_ext.gltf")),
    ("floats", include_str!("wave_float.gltf")),
    ("KHR", include_str!("wave_khr.gltf")),
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
fn draco_is_refused_with_a_way_out() {
    let (_, document) = FILES[0];
    let name = "KHR_draco_mesh_compression";
    let from = "\"extensionsRequired\":[";
    let error = read(&document.replace(from, &format!("{from}\"{name}\","))).unwrap_err();
    let SceneError::Invalid { message, help, .. } = error else { panic!("{error}") };
    assert!(message.contains(name) && help.unwrap().contains("without Draco"), "{message}");
}
