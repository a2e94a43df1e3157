//! Ignored parts of a glTF file are named once, and valid files are never refused.
use crate::common::{
    files::Folder,
    model::{BYTE, Glb, SHORT, UBYTE, USHORT, floats},
};
use gobo::{
    glam::{Mat4, Vec2, Vec3},
    model::{LightKind, VertexColor},
};
use gobo_scene::{Model, load_model};
use serde_json::json;

fn load(model: &Glb) -> Model {
    load_model(&Folder::new().write("model.glb", model.bytes()), Mat4::IDENTITY).unwrap()
}

#[test]
fn attributes_of_other_names_are_skipped() {
    let mut model = Glb::new();
    let mut square = model.square(json!({}));
    let scalars = model.floats("SCALAR", &[1.0; 4]);
    let colors = model.floats("VEC4", &[1.0; 16]);
    for name in ["_TEMPERATURE", "_FEATURE_ID_0", "FOO", "TEXCOORD_x"] {
        square["attributes"][name] = scalars.into();
    }
    square["attributes"]["COLOR_1"] = colors.into();
    let moved = square["attributes"]["POSITION"].clone();
    square["targets"] = json!([{ "POSITION": moved, "COLOR_0": colors }]);
    model.place(square.clone(), [0.0; 3]);
    model.place(square, [1.0; 3]);
    let model = load(&model);
    assert_eq!(model.triangles.len(), 4);
    let [note] = &model.notes[..] else { panic!("{:?}", model.notes) };
    for name in [
        "`_TEMPERATURE`",
        "`_FEATURE_ID_0`",
        "`FOO`",
        "`TEXCOORD_x`",
        "`COLOR_1`",
        "`COLOR_0 of morph targets`",
    ] {
        assert_eq!(note.matches(name).count(), 1, "{note}");
    }
}

#[test]
fn what_is_not_read_is_named_once() {
    let mut model = Glb::new();
    let texture = model.texture(1, 1, &[9, 9, 255, 255]);
    let sampler = model.push("samplers", json!({ "wrapS": 33071, "magFilter": 9728 }));
    model.json["textures"][0]["sampler"] = sampler.into();
    for _ in 0..2 {
        let square = model.square(json!({
            "normalTexture": { "index": texture },
            "extensions": { "KHR_materials_sheen": {}, "KHR_materials_specular": {}, "KHR_materials_anisotropy": {} },
        }));
        model.place(square, [0.0; 3]);
    }
    model.push("scenes", json!({}));
    let model = load(&model);
    let all = model.notes.join("\n");
    for name in [
        "`KHR_materials_sheen`",
        "`KHR_materials_specular`",
        "`KHR_materials_anisotropy`",
        "wrap modes",
        "filters",
        "scenes",
    ] {
        assert_eq!(all.matches(name).count(), 1, "{name}: {all}");
    }
}

#[test]
fn corners_follow_eight_joints() {
    let mut model = Glb::new();
    let mut square = model.square(json!({}));
    let (first, second) = ([0u8; 16], [1u8; 16]);
    for (set, joints) in [(0, first), (1, second)] {
        // Weights with the sum 2, to be scaled.
        let weights = model.floats("VEC4", &[0.25; 16]);
        let joints = model.items((UBYTE, "VEC4", 4), &joints, json!({}));
        square["attributes"][format!("JOINTS_{set}")] = joints.into();
        square["attributes"][format!("WEIGHTS_{set}")] = weights.into();
    }
    let mesh = model.push("meshes", json!({ "primitives": [square] }));
    let near = model.node(json!({ "translation": [0, 1, 0] }));
    let far = model.node(json!({ "translation": [4, 1, 0] }));
    model.push("skins", json!({ "joints": [near, far] }));
    model.node(json!({ "mesh": mesh, "skin": 0 }));
    let corners = load(&model).triangles[0].positions;
    assert_eq!(corners[0], Vec3::new(1.5, 1.0, 0.5));
}

#[test]
fn lights_have_cones_and_ranges() {
    let mut model = Glb::new();
    model.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    model.json["extensions"]["KHR_lights_punctual"]["lights"] = json!([
        { "type": "spot", "spot": { "innerConeAngle": 0.2, "outerConeAngle": 0.5 }, "range": 7 },
        { "type": "spot", "spot": {} },
        { "type": "point", "range": 3 },
    ]);
    for light in 0..3 {
        model.node(json!({ "extensions": { "KHR_lights_punctual": { "light": light } } }));
    }
    let [spot, usual, point] = &load(&model).lights[..] else { panic!() };
    assert_eq!((spot.inner_angle, spot.end), (Some(0.4), Some(7.0)));
    let LightKind::Spot { angle, .. } = usual.kind else { panic!("{usual:?}") };
    assert!((angle - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    assert_eq!((usual.inner_angle, usual.end), (Some(0.0), None));
    assert_eq!((point.inner_angle, point.end), (None, Some(3.0)));
}

/// Texture coordinates of the second set, moved, scaled and rotated, for the texture alone.
#[test]
fn texture_transforms_and_sets_are_followed() {
    let mut model = Glb::new();
    let texture = model.texture(1, 1, &[255; 4]);
    let transform = json!({
        "offset": [0.5, 0.25], "rotation": std::f32::consts::FRAC_PI_2, "scale": [2, 3], "texCoord": 1
    });
    let used = json!({ "index": texture, "extensions": { "KHR_texture_transform": transform } });
    let mut square = model.square(json!({ "emissiveFactor": [1, 1, 1], "emissiveTexture": used }));
    // Normalised integers: u is 0 or 1, v a fifth or 1.
    let shorts = [[0u16, 65535], [65535, 13107], [0, 0], [65535, 65535]];
    let bytes: Vec<u8> = shorts.as_flattened().iter().flat_map(|i| i.to_le_bytes()).collect();
    let second = model.items((USHORT, "VEC2", 4), &bytes, json!({ "normalized": true }));
    square["attributes"]["TEXCOORD_1"] = second.into();
    model.place(square, [0.0; 3]);
    let model = load(&model);
    assert!(
        model.skipped.is_empty() && model.notes.is_empty(),
        "{:?} {:?}",
        model.skipped,
        model.notes
    );
    // u' = cos sx u + sin sy v + ox and v' = -sin sx u + cos sy v + oy, by the extension's matrices.
    let wanted = [[3.5, 0.25], [0.6 + 0.5, -1.75], [0.5, 0.25]];
    for (found, wanted) in model.triangles[0].uvs.iter().zip(wanted) {
        assert!(found.distance(Vec2::from(wanted)) < 1e-5, "{found}, not {wanted:?}");
    }
}

/// Sparse accessors over a base and over zeros, quantized positions and normals, and nodes that mirror.
#[test]
fn accessors_of_all_kinds_are_read() {
    let mut model = Glb::new();
    model.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    model.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let mut square = model.square(json!({}));
    let corners = [
        [-32767i16, 0, 32767, 0],
        [32767, 0, 32767, 0],
        [32767, 0, -32767, 0],
        [-32768, 0, -32768, 0],
    ];
    let bytes: Vec<u8> = corners.as_flattened().iter().flat_map(|i| i.to_le_bytes()).collect();
    let position = model.items(
        (SHORT, "VEC3", 4),
        &bytes,
        json!({ "normalized": true, "min": [-1, 0, -1], "max": [1, 0, 1] }),
    );
    let view = model.json["accessors"][position]["bufferView"].as_u64().unwrap() as usize;
    model.json["bufferViews"][view]["byteStride"] = 8.into();
    square["attributes"]["POSITION"] = position.into();
    let normals =
        model.items((BYTE, "VEC3", 4), &[0, 127, 0, 0].repeat(4), json!({ "normalized": true }));
    let view = model.json["accessors"][normals]["bufferView"].as_u64().unwrap() as usize;
    model.json["bufferViews"][view]["byteStride"] = 4.into();
    square["attributes"]["NORMAL"] = normals.into();
    let mesh = model.push("meshes", json!({ "primitives": [square] }));
    model.node(json!({ "mesh": mesh, "scale": [-1, 1, 2], "translation": [5, 0, 0] }));
    // Two corners replaced by sparse ones: of a base, and of zeros.
    for has_base in [true, false] {
        let mut square = model.square(json!({}));
        let base = square["attributes"]["POSITION"].as_u64().unwrap() as usize;
        let (indices, values) =
            (model.view(&[1, 0, 2, 0]), model.view(&floats(&[7.0, 0.0, 0.0, 0.0, 0.0, -7.0])));
        let accessor = &mut model.json["accessors"][base];
        accessor["sparse"] = json!({
            "count": 2,
            "indices": { "bufferView": indices, "componentType": 5123 },
            "values": { "bufferView": values }
        });
        if !has_base {
            accessor.as_object_mut().unwrap().remove("bufferView");
        }
        square["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
        model.place(square, [0.0; 3]);
    }
    let model = load(&model);
    let first = model.triangles[0];
    assert_eq!(
        first.positions,
        [[6.0, 0.0, 2.0], [4.0, 0.0, 2.0], [4.0, 0.0, -2.0]].map(Vec3::from)
    );
    // The mirrored normal still looks up.
    assert_eq!(first.normals, [Vec3::Y; 3]);
    assert_eq!(model.triangles[1].positions[2], Vec3::new(6.0, 0.0, -2.0));
    let corners = |i: usize| model.triangles[i].positions;
    assert_eq!(corners(2), [[-0.5, 0.0, 0.5], [7.0, 0.0, 0.0], [0.0, 0.0, -7.0]].map(Vec3::from));
    assert_eq!(corners(4), [[0.0, 0.0, 0.0], [7.0, 0.0, 0.0], [0.0, 0.0, -7.0]].map(Vec3::from));
}

/// A body whose faces point inwards is reversed, with all attributes of its corners.
#[test]
fn corners_keep_their_colours_when_bodies_are_turned() {
    let mut model = Glb::new();
    let glass = json!({
        "KHR_materials_transmission": { "transmissionFactor": 1 },
        "KHR_materials_volume": {
            "thicknessFactor": 1, "attenuationDistance": 1, "attenuationColor": [0.5, 0.5, 0.5]
        },
    });
    let mut body = model
        .square(json!({ "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": glass }));
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let inwards: Vec<u8> =
        [0u16, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2].iter().flat_map(|i| i.to_le_bytes()).collect();
    body["attributes"] = json!({ "POSITION": model.floats("VEC3", corners.as_flattened()) });
    body["attributes"]["COLOR_0"] = model.floats("VEC3", corners.as_flattened()).into();
    body["indices"] = model.items((USHORT, "SCALAR", 12), &inwards, json!({})).into();
    model.place(body, [0.0; 3]);
    let model = load(&model);
    assert!(model.materials[model.triangles[0].material as usize].is_volume());
    for triangle in &model.triangles {
        let [a, b, c] = triangle.positions;
        assert!((b - a).cross(c - a).dot(a - Vec3::splat(0.25)) > 0.0, "{triangle:?}");
        for (position, color) in triangle.positions.into_iter().zip(triangle.colors) {
            assert_eq!(color, VertexColor::new(position.extend(1.0)));
        }
    }
}

/// Containers of plain bytes, as `toktx` and `ktx create` write them: rgb and rgba, with Zstandard, zlib or
/// uncompressed.
#[test]
fn plain_ktx2_is_read() {
    use std::io::Write as _;
    let (width, height) = (5u32, 3u32);
    let texel = |i: u32, channel: u32| (i * 17 + channel * 90) as u8;
    for (format, channels) in [(23u32, 3u32), (29, 3), (37, 4), (43, 4)] {
        let count = width * height;
        let plain: Vec<u8> =
            (0..count).flat_map(|i| (0..channels).map(move |c| texel(i, c))).collect();
        let zstd = ruzstd::encoding::compress_to_vec(
            &plain[..],
            ruzstd::encoding::CompressionLevel::Fastest,
        );
        let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        zlib.write_all(&plain).unwrap();
        for (scheme, stored) in [(0u32, plain.clone()), (2, zstd), (3, zlib.finish().unwrap())] {
            let mut file = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
            let head = [format, 1, width, height, 0, 0, 1, 1, scheme, 0, 0, 0, 0, 0, 0, 0, 0];
            file.extend(head.iter().flat_map(|word| word.to_le_bytes()));
            for long in [104u64, stored.len() as u64, plain.len() as u64] {
                file.extend(long.to_le_bytes());
            }
            file.extend(&stored);
            let load = |bytes: &[u8]| {
                let mut model = Glb::new();
                let view = model.view(bytes);
                model.push("images", json!({ "bufferView": view, "mimeType": "image/ktx2" }));
                model.push(
                    "textures",
                    json!({ "extensions": { "KHR_texture_basisu": { "source": 0 } } }),
                );
                let used = json!({ "baseColorTexture": { "index": 0 } });
                let square =
                    model.square(json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": used }));
                model.place(square, [0.0; 3]);
                load_model(&Folder::new().write("model.glb", model.bytes()), Mat4::IDENTITY)
            };
            let model = load(&file).unwrap();
            let texture = &model.textures[0];
            assert_eq!((texture.width, texture.height), (width, height));
            for (i, found) in (0..).zip(texture.rgba.chunks_exact(4)) {
                let alpha = if channels == 4 { texel(i, 3) } else { 255 };
                assert_eq!(
                    found,
                    [texel(i, 0), texel(i, 1), texel(i, 2), alpha],
                    "{format} {scheme}"
                );
            }
            // Damage gives an error that names it, and never a panic.
            for at in (0..file.len()).step_by(7) {
                let mut changed = file.clone();
                changed[at] ^= 0xff;
                let of_changed = load(&changed).err();
                assert!(of_changed.is_none_or(|error| error.to_string().contains("image 0")));
                assert!(load(&file[..at]).is_err(), "{at} bytes");
            }
        }
    }
}
