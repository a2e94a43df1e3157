//! Real-world glTF files: paths that leave the folder, unusual valid files, ignored features.
use crate::common::files::Folder;
use gobo::glam::{Mat4, Quat, Vec3};
use gobo_scene::{Model, SceneError, load_model};
use std::path::Path;

/// One triangle: `corners.bin` beside it, and `more` in the document.
fn document(uri: &str, more: &str) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}}, {more}
        "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0, 0, 0], "max": [1, 1, 0]}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
        "buffers": [{{"byteLength": 36, "uri": "{uri}"}}]}}"#
    )
}

fn corners() -> Vec<u8> {
    [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].map(f32::to_le_bytes).concat()
}

fn load(folder: &Folder, document: &str) -> Result<Model, SceneError> {
    folder.write("corners.bin", corners());
    load_model(&folder.write("model.gltf", document), Mat4::IDENTITY)
}

fn read(document: &str) -> Result<Model, SceneError> {
    load(&Folder::new(), document)
}

#[test]
fn what_leaves_the_folder_is_refused_unread() {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.0.join("inner/deep")).unwrap();
    folder.write("secret.bin", corners());
    std::fs::write(folder.0.join("inner/deep/corners.bin"), corners()).unwrap();
    let path = folder.0.join("inner/model.gltf");
    let absolute = folder.0.join("secret.bin").display().to_string();
    for uri in [
        absolute.as_str(),
        "../secret.bin",
        "%2e%2e/secret.bin",
        "deep/../../secret.bin",
        "deep/%2E%2E/%2e./secret.bin",
        "%2fetc/passwd",
        "..%2fsecret.bin",
        "..",
        "",
    ] {
        std::fs::write(&path, document(uri, "")).unwrap();
        let error = load_model(&path, Mat4::IDENTITY).unwrap_err();
        let SceneError::Invalid { message, help, .. } = error else { panic!("{uri}: {error}") };
        assert!(message.contains("folder") || uri.is_empty(), "{uri}: {message}");
        assert!(help.is_some(), "{uri}");
    }
    for uri in
        ["deep/corners.bin", "./deep/corners.bin", "deep/%63orners.bin", "deep/../deep/corners.bin"]
    {
        std::fs::write(&path, document(uri, "")).unwrap();
        let model = load_model(&path, Mat4::IDENTITY).unwrap_or_else(|e| panic!("{uri}: {e}"));
        assert_eq!(model.triangles.len(), 1, "{uri}");
    }
}

#[test]
fn valid_files_are_read() {
    for extras in [r#""text""#, "5", "[1]", "true", "null", r#"{"a": 1}"#] {
        let model = read(&document("corners.bin", &format!(r#""extras": {extras},"#))).unwrap();
        assert_eq!(model.triangles.len(), 1, "{extras}");
        let inner = document("corners.bin", "")
            .replace(r#"{"mesh": 0}"#, &format!(r#"{{"mesh": 0, "extras": {extras}}}"#));
        assert_eq!(read(&inner).unwrap().triangles.len(), 1, "{extras}");
    }
    let empty = read(r#"{"asset": {"version": "2.0"}, "scenes": [{}]}"#).unwrap();
    assert!(empty.triangles.is_empty());
    // "AAAA" is three bytes of 0: 36 bytes are 48 digits.
    let data = format!("DATA:application/octet-stream;BASE64,{}", "A".repeat(48));
    let model = read(&document(&data, "")).unwrap();
    assert_eq!(model.skipped["triangle without area"], 1);
}

#[test]
fn versions_that_cannot_be_read_are_refused() {
    for (asset, ok) in [
        (r#"{"version": "2.0"}"#, true),
        (r#"{"version": "2.9", "minVersion": "2.0"}"#, true),
        (r#"{"version": "2.1"}"#, true),
        (r#"{"version": "9.9", "minVersion": "9.9"}"#, false),
        (r#"{"version": "2.0", "minVersion": "2.1"}"#, false),
        (r#"{"version": "1.0"}"#, false),
    ] {
        let text = document("corners.bin", "").replace(r#"{"version": "2.0"}"#, asset);
        let result = read(&text).map_err(|e| e.to_string());
        assert_eq!(result.is_ok(), ok, "{asset}: {:?}", result.err());
    }
}

#[test]
fn used_extensions_that_nobody_reads_are_named_once() {
    let used = r#""extensionsUsed": ["KHR_materials_unlit", "KHR_materials_sheen", "ACME_fur", "ACME_fur"],"#;
    let model = read(&document("corners.bin", used)).unwrap();
    let [note] = &model.notes[..] else { panic!("{:?}", model.notes) };
    assert_eq!(note.matches("ACME_fur").count(), 1, "{note}");
    assert!(note.contains("KHR_materials_sheen") && !note.contains("unlit"), "{note}");
    let required = r#""extensionsRequired": ["ACME_fur"],"#;
    assert!(read(&document("corners.bin", required)).unwrap_err().to_string().contains("ACME_fur"));
}

/// Three instances of one triangle below a moved node: world = node * T R S.
#[test]
fn instances_are_placed() {
    let turn = Quat::from_rotation_z(0.7);
    let floats: Vec<f32> = [
        &[0f32, 0., 0., 1., 0., 0., 0., 1., 0.][..],
        &[1., 2., 3., -4., 0., 0., 0., 0., 9.],
        &[0., 0., 0., 1.],
        &turn.to_array(),
        &[0., 0., 0., 1.],
        &[1., 1., 1., 2., 2., 2., 1., 3., 1.],
    ]
    .concat();
    let bytes: Vec<u8> = floats.into_iter().flat_map(f32::to_le_bytes).collect();
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}}, "extensionsUsed": ["EXT_mesh_gpu_instancing"],
        "extensionsRequired": ["EXT_mesh_gpu_instancing"], "scenes": [{{"nodes": [0]}}],
        "nodes": [{{"mesh": 0, "translation": [10, 0, 0], "extensions": {{"EXT_mesh_gpu_instancing":
            {{"attributes": {{"TRANSLATION": 1, "ROTATION": 2, "SCALE": 3}}}}}}}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
        "accessors": [
            {{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}},
            {{"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 3, "type": "VEC3"}},
            {{"bufferView": 0, "byteOffset": 72, "componentType": 5126, "count": 3, "type": "VEC4"}},
            {{"bufferView": 0, "byteOffset": 120, "componentType": 5126, "count": 3, "type": "VEC3"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": {length}}}],
        "buffers": [{{"byteLength": {length}, "uri": "instances.bin"}}]}}"#,
        length = bytes.len()
    );
    let folder = Folder::new();
    folder.write("instances.bin", &bytes);
    let model = load(&folder, &text).unwrap();
    assert!(model.notes.is_empty(), "{:?}", model.notes);
    assert_eq!(model.triangles.len(), 3);
    let places = [
        (Vec3::ONE, Quat::IDENTITY, Vec3::new(1.0, 2.0, 3.0)),
        (Vec3::splat(2.0), turn, Vec3::new(-4.0, 0.0, 0.0)),
        (Vec3::new(1.0, 3.0, 1.0), Quat::IDENTITY, Vec3::new(0.0, 0.0, 9.0)),
    ];
    for (triangle, (scale, turn, place)) in model.triangles.iter().zip(places) {
        for (found, corner) in triangle.positions.iter().zip([Vec3::ZERO, Vec3::X, Vec3::Y]) {
            let want = Vec3::X * 10.0 + place + turn * (scale * corner);
            assert!(found.abs_diff_eq(want, 1e-5), "{found} is not {want}");
        }
    }
    // Instances are objects of their own.
    let ids: Vec<_> = model.triangles.iter().map(|t| t.id).collect();
    assert!(ids[0] != ids[1] && ids[1] != ids[2], "{ids:?}");
    let short = text.replace(
        r#""byteOffset": 120, "componentType": 5126, "count": 3"#,
        r#""byteOffset": 120, "componentType": 5126, "count": 2"#,
    );
    assert_ne!(short, text);
    assert!(load(&folder, &short).unwrap_err().to_string().contains("instanc"));
    let wrong = text.replace("\"ROTATION\": 2", "\"ROTATION\": 77");
    assert!(load(&folder, &wrong).is_err());
}

#[test]
fn sparse_indices_are_checked() {
    let text = |first: u16, second: u16| {
        let mut bytes = corners();
        bytes.extend([first, second].iter().flat_map(|i| i.to_le_bytes()));
        bytes.extend([5f32, 0., 0., 0., 7., 0.].map(f32::to_le_bytes).concat());
        let document = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                "min": [0, 0, 0], "max": [5, 7, 0], "sparse": {"count": 2,
                "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 2}}}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 4},
                {"buffer": 0, "byteOffset": 40, "byteLength": 24}],
            "buffers": [{"byteLength": 64, "uri": "sparse.bin"}]}"#;
        let folder = Folder::new();
        folder.write("sparse.bin", bytes);
        load(&folder, document)
    };
    let model = text(1, 2).unwrap();
    assert_eq!(model.triangles[0].positions, [Vec3::ZERO, Vec3::X * 5.0, Vec3::Y * 7.0]);
    for (first, second) in [(1, 3), (3, 4), (2, 1), (1, 1), (0, 65535)] {
        let error = text(first, second).unwrap_err().to_string();
        assert!(error.contains("accessor 0") && error.contains("sparse"), "{error}");
    }
}

#[test]
fn webp_images_are_read() {
    let image = image::RgbaImage::from_fn(2, 1, |x, _| image::Rgba([10, 200, x as u8 * 255, 255]));
    let folder = Folder::new();
    image.save(folder.0.join("dots.webp")).unwrap();
    let text = document(
        "corners.bin",
        r#""extensionsUsed": ["EXT_texture_webp"], "extensionsRequired": ["EXT_texture_webp"],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"extensions": {"EXT_texture_webp": {"source": 0}}}],
        "images": [{"uri": "dots.webp"}],"#,
    )
    .replace(r#""POSITION": 0}"#, r#""POSITION": 0}, "material": 0"#);
    let model = load(&folder, &text).unwrap();
    assert_eq!(model.textures[0].rgba, image.into_raw());
    assert!(model.notes.is_empty(), "{:?}", model.notes);
    let toml = "[[material]]\nname = \"m\"\ntexture = \"dots.webp\"\n";
    let scene = gobo_scene::load(&folder.write("scene.toml", toml)).unwrap();
    assert_eq!(scene.textures[0].rgba, model.textures[0].rgba);
}

/// Tiles of 4 x 4 texels, each of one colour, encoded by Basis Universal 1.16: as ETC1S, and as UASTC with
/// mip levels and Zstandard.
#[test]
fn textures_in_ktx2_are_read() {
    let text = document(
        "corners.bin",
        r#""extensionsUsed": ["KHR_texture_basisu"], "extensionsRequired": ["KHR_texture_basisu"],
        "materials": [{"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"extensions": {"KHR_texture_basisu": {"source": 0}}}],
        "images": [{"uri": "tiles.ktx2"}],"#,
    )
    .replace(r#""POSITION": 0}"#, r#""POSITION": 0}, "material": 0"#);
    let load = |bytes: &[u8]| {
        let folder = Folder::new();
        folder.write("tiles.ktx2", bytes);
        load(&folder, &text)
    };
    // ETC1S has 5 bits per channel.
    for (bytes, tolerance) in
        [(&include_bytes!("tiles_etc1s.ktx2")[..], 4), (include_bytes!("tiles_uastc.ktx2"), 1)]
    {
        let model = load(bytes).unwrap();
        assert!(model.notes.is_empty(), "{:?}", model.notes);
        let texture = &model.textures[0];
        assert_eq!((texture.width, texture.height), (16, 8));
        for (i, texel) in texture.rgba.chunks_exact(4).enumerate() {
            let (x, y) = (i % 16 / 4, i / 16 / 4);
            let blue = if (x + y) % 2 == 1 { 128 } else { 24 };
            let wanted = [8 + 80 * x, 40 + 160 * y, blue, if x < 2 { 255 } else { 92 }];
            let apart = texel.iter().zip(wanted).map(|(&a, b)| i32::from(a).abs_diff(b as i32));
            assert!(apart.max().unwrap() <= tolerance, "{texel:?} for {wanted:?}");
        }
        // Damage gives an error that names it, and never a panic.
        for at in 0..bytes.len() {
            let mut changed = bytes.to_vec();
            changed[at] ^= 0xff;
            if let Err(error) = load(&changed) {
                assert!(error.to_string().contains("image 0"), "{error}");
            }
            assert!(load(&bytes[..at]).is_err(), "{at} bytes");
        }
    }
    // A code table with most of its codes missing.
    let mut changed = include_bytes!("tiles_etc1s.ktx2").to_vec();
    changed[284..288].copy_from_slice(&[1, 0, 0, 0]);
    assert!(load(&changed).unwrap_err().to_string().contains("damaged"));
}

/// A texture whose only image has an unsupported extension is white, and a note says so.
#[test]
fn textures_without_an_image_are_white() {
    let text = document(
        "corners.bin",
        r#""extensionsUsed": ["EXT_texture_avif"],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"extensions": {"EXT_texture_avif": {"source": 0}}}],
        "images": [{"uri": "dots.avif"}],"#,
    )
    .replace(r#""POSITION": 0}"#, r#""POSITION": 0}, "material": 0"#);
    let model = read(&text).unwrap();
    assert_eq!(model.textures[0].rgba, [255; 4]);
    assert!(model.notes.iter().any(|note| note.contains("EXT_texture_avif")), "{:?}", model.notes);
}

#[test]
fn images_are_shared_by_what_looks_alike() {
    let image = image::RgbaImage::from_pixel(4, 4, image::Rgba([10, 20, 30, 255]));
    let folder = Folder::new();
    image.save(folder.0.join("dots.png")).unwrap();
    let material = r#"{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}"#;
    let primitive = |i: usize| format!(r#"{{"attributes": {{"POSITION": 0}}, "material": {i}}}"#);
    let text = document(
        "corners.bin",
        &format!(
            r#""materials": [{}], "textures": [{{"source": 0}}, {{"source": 0, "sampler": 0}}],
            "samplers": [{{}}], "images": [{{"uri": "dots.png"}}],"#,
            [
                material,
                &material.replace(": 0}", ": 1}"),
                &material.replace("{\"pbr", "{\"alphaMode\": \"BLEND\", \"pbr")
            ]
            .join(",")
        ),
    )
    .replace(
        r#"{"attributes": {"POSITION": 0}}"#,
        &(0..3).map(primitive).collect::<Vec<_>>().join(","),
    );
    let model = load(&folder, &text).unwrap();
    assert_eq!((model.materials.len(), model.textures.len()), (3, 1));
    assert!(Path::new(&model.textures[0].name).is_relative());
}

/// Regression: an unknown path ended the program (found by `make fuzz`).
#[test]
fn channels_that_move_no_node_are_passed_over() {
    let animated = |target: &str| {
        let more = format!(
            r#""animations": [{{"channels": [{{"sampler": 0, "target": {target}}}],
                "samplers": [{{"input": 0, "output": 0}}]}}],"#
        );
        read(&document("corners.bin", &more))
    };
    for target in [
        r#"{"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/x"}}}"#,
        r#"{"node": 0, "path": "pointer"}"#,
        r#"{"node": 0, "path": ""}"#,
        r#"{"path": "translation"}"#,
    ] {
        let model = animated(target).unwrap_or_else(|error| panic!("{target}: {error}"));
        assert_eq!(model.triangles.len(), 1, "{target}");
    }
    // A channel that moves a node is read: these times are invalid.
    assert!(animated(r#"{"node": 0, "path": "translation"}"#).is_err());
}

/// Textures in AVIF alone are white, and counted with a remedy; if AVIF is required, the file is refused.
#[test]
fn images_of_other_kinds_are_named() {
    let textures = |sources: &str| {
        format!(
            "\"extensionsUsed\": [\"EXT_texture_avif\"], \"textures\": [{sources}], \
             \"images\": [{{\"uri\": \"a.avif\"}}, {{\"uri\": \"a.png\"}}],"
        )
    };
    let only = "{\"extensions\": {\"EXT_texture_avif\": {\"source\": 0}}}";
    let both = "{\"source\": 1, \"extensions\": {\"EXT_texture_avif\": {\"source\": 0}}}";
    let notes = |sources: &str| read(&document("corners.bin", &textures(sources))).unwrap().notes;
    let told = |notes: &[String]| notes.iter().any(|note| note.contains("2 textures are white"));
    let found = notes(&format!("{only}, {both}, {only}"));
    assert!(told(&found) && found.iter().any(|note| note.contains("PNG")), "{found:?}");
    assert!(!told(&notes(both)));
    let required = textures(only) + "\"extensionsRequired\": [\"EXT_texture_avif\"],";
    let error = read(&document("corners.bin", &required)).unwrap_err();
    let SceneError::Invalid { message, help, .. } = error else { panic!("{error}") };
    assert!(message.contains("EXT_texture_avif") && help.unwrap().contains("PNG"), "{message}");
}

/// Vertex colours, as bytes with alpha and as floats without, in each corner.
#[test]
fn colours_of_vertices_are_read() {
    let of = |kind: &str, component: u32, normalized: bool| {
        let length = if component == 5121 { 12 } else { 36 };
        document("corners.bin", "")
            .replace("\"POSITION\": 0", "\"POSITION\": 0, \"COLOR_0\": 1")
            .replace(
                "\"bufferViews\": [",
                &format!("\"bufferViews\": [{{\"buffer\": 1, \"byteLength\": {length}}},"),
            )
            .replace(
                "\"bufferView\": 0, \"componentType\": 5126",
                "\"bufferView\": 1, \"componentType\": 5126",
            )
            .replace(
                "\"max\": [1, 1, 0]}",
                &format!(
                    "\"max\": [1, 1, 0]}}, {{\"bufferView\": 0, \"componentType\": {component}, \
                     \"count\": 3, \"type\": \"{kind}\", \"normalized\": {normalized}}}"
                ),
            )
            .replace(
                "\"corners.bin\"}]",
                &format!(
                    "\"corners.bin\"}}, {{\"byteLength\": {length}, \"uri\": \"colors.bin\"}}]"
                ),
            )
    };
    let folder = Folder::new();
    folder.write("colors.bin", [255u8, 0, 0, 255, 0, 255, 0, 128, 64, 64, 64, 0]);
    let bytes = load(&folder, &of("VEC4", 5121, true)).unwrap();
    let half = (64f32 / 255.0).sqrt();
    let gray = (half * 255.0).round() as u8;
    let expected = [[255, 0, 0, 255], [0, 255, 0, 128], [gray, gray, gray, 0]];
    assert_eq!(bytes.triangles[0].colors.map(|color| color.0), expected);
    let floats = [0f32, 1.0, 0.25, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0].map(f32::to_le_bytes).concat();
    folder.write("colors.bin", floats);
    let floats = load(&folder, &of("VEC3", 5126, false)).unwrap();
    let expected = [[0, 255, 128, 255], [255; 4], [0, 0, 0, 255]];
    assert_eq!(floats.triangles[0].colors.map(|color| color.0), expected);
    // Integers that are not normalised are no colours.
    folder.write("colors.bin", [0u8; 12]);
    assert!(load(&folder, &of("VEC4", 5121, false)).is_err());
}
