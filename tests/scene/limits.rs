//! Limits of a scene's contents, whatever its files announce, and of the work to detect a violation.
use crate::common::{
    files::{Folder, read},
    splats::{SPLATS, bare},
};
use gobo_scene as scene;
use gobo_scene::SceneError;
use std::{
    fs,
    path::Path,
    time::{Duration, Instant},
};

/// Line and message of a refusal.
fn refused(toml: &str) -> (usize, String) {
    match read(toml) {
        Err(SceneError::Document { line, message, help, .. }) => {
            assert!(help.is_some(), "{message}");
            (line, message)
        }
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("read without an error"),
    }
}

/// The lengths of two files announce more splats than a scene has, although hardly any of them is valid.
#[test]
fn splats_of_files_are_summed_before_they_are_read() {
    let folder = Folder::new();
    let path = folder.write("a.splat", bare(&SPLATS).repeat(64));
    let file = fs::OpenOptions::new().write(true).open(&path).unwrap();
    file.set_len(9_000_000 * 32).unwrap();
    let table = "[[splats]]\nfile = \"a.splat\"\n";
    let error = scene::check(&folder.write("s.toml", table.repeat(2))).unwrap_err();
    let SceneError::Document { line, message, .. } = error else { panic!("{error}") };
    assert!(line == 4 && message.contains("18000000 splats"), "{line}: {message}");
    // A file alone.
    file.set_len(20_000_000 * 32).unwrap();
    let error = scene::check(&path).unwrap_err().to_string();
    assert!(error.contains("20000000 splats, but a scene has at most 16000000"), "{error}");
}

const MATERIAL: &str = "[[material]]\nname = \"m\"\n";
const LAMP: &str = "[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\n";

#[test]
fn the_table_that_is_too_much_is_named() {
    let dust =
        "[[particles]]\nmaterial = \"m\"\ngenerate = { kind = \"smoke\", count = 9000000 }\n";
    let (line, message) = refused(&format!("{MATERIAL}{dust}{dust}"));
    assert_eq!(line, 8, "{message}");
    assert!(message.contains("18000000") && message.contains("16000000"), "{message}");

    let sphere = "[[shape]]\nkind = \"sphere\"\nmaterial = \"m\"\nlevel = 7\n";
    let (line, message) = refused(&(MATERIAL.to_owned() + &sphere.repeat(1000)));
    // 24 spheres of 327,680 triangles fit into 8,000,000.
    assert_eq!(line, 3 + 24 * 4 + 3, "{message}");
    assert!(message.contains("8192000") && message.contains("8000000"), "{message}");

    let materials: String = (0..513).map(|i| format!("[[material]]\nname = \"m{i}\"\n")).collect();
    let (line, message) = refused(&materials);
    assert_eq!(line, 2 + 512 * 2, "{message}");
    assert!(message.contains("513") && message.contains("512"), "{message}");

    let (line, message) = refused(&LAMP.repeat(4097));
    assert_eq!(line, 2 + 4096 * 3, "{message}");
    assert!(message.contains("4097") && message.contains("4096"), "{message}");
    assert_eq!(read(&LAMP.repeat(4096)).unwrap().lights.len(), 4096);
}

/// A PNG with a size but no contents.
fn promise(width: u32, height: u32) -> Vec<u8> {
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
    png.extend([width, height].iter().flat_map(|n| n.to_be_bytes()));
    png.extend([8, 6, 0, 0, 0]);
    let crc = crc(&png[12..]);
    png.extend(crc.to_be_bytes());
    png.extend(b"\0\0\0\x01IDAT\0");
    png
}

fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| (c >> 1) ^ (0xedb8_8320 & (c & 1).wrapping_neg()))
    })
}

fn white(folder: &Folder, name: &str) {
    image::GrayImage::from_pixel(1, 1, image::Luma([255])).save(folder.0.join(name)).unwrap();
}

#[test]
fn images_are_counted_before_they_are_decoded() {
    let folder = Folder::new();
    white(&folder, "white.png");
    folder.write("huge.png", promise(16384, 16384));
    let material = |image: usize| {
        format!(r#"{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": {image}}}}}}}"#)
    };
    let gltf = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}},
            {{"attributes": {{"POSITION": 0}}, "material": 1}}]}}],
        "materials": [{}, {}], "textures": [{{"source": 0}}, {{"source": 1}}],
        "images": [{{"uri": "white.png"}}, {{"uri": "huge.png"}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0, 0, 0], "max": [1, 1, 0]}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
        "buffers": [{{"byteLength": 36, "uri": "corners.bin"}}]}}"#,
        material(0),
        material(1)
    );
    let corners = [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].map(f32::to_le_bytes).concat();
    folder.write("corners.bin", corners);
    let error = scene::load(&folder.write("huge.gltf", gltf)).unwrap_err().to_string();
    assert!(error.contains("268435457") && error.contains("268435456"), "{error}");
}

/// Contents that cannot be decoded: no image is decoded before the heads of all are counted.
#[test]
fn images_of_all_tables_are_counted_before_one_is_decoded() {
    let folder = Folder::new();
    let mut toml = String::new();
    for i in 0..20 {
        folder.write(&format!("{i}.png"), promise(8192, 8192));
        toml += &format!("[[material]]\nname = \"{i}\"\ntexture = \"{i}.png\"\n");
        // Named twice, counted once.
        toml += &format!("[[material]]\nname = \"{i} again\"\ntexture = \"{i}.png\"\n");
    }
    let path = folder.write("images.toml", &toml);
    let SceneError::Document { line, message, .. } = scene::load(&path).unwrap_err() else {
        panic!("no line")
    };
    // Four fit.
    assert_eq!(line, 4 * 6 + 3, "{message}");
    for sum in ["335544320", "1342177280", "268435456"] {
        assert!(message.contains(sum), "{sum}: {message}");
    }

    let part = |i: usize| format!(r#"{{"attributes": {{"POSITION": 0}}, "material": {i}}}"#);
    let image = |i: usize| format!(r#"{{"uri": "huge{i}.png"}}"#);
    let material = |i: usize| {
        format!(r#"{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": {i}}}}}}}"#)
    };
    let texture = |i: usize| format!(r#"{{"source": {i}}}"#);
    let gltf = |count: usize| {
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
            "meshes": [{{"primitives": [{}]}}], "materials": [{}], "textures": [{}], "images": [{}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                "min": [0, 0, 0], "max": [1, 1, 0]}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
            "buffers": [{{"byteLength": 36, "uri": "corners.bin"}}]}}"#,
            list(count, part),
            list(count, material),
            list(count, texture),
            list(count, image)
        )
    };
    let corners = [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].map(f32::to_le_bytes).concat();
    folder.write("corners.bin", corners);
    for i in 0..2 {
        folder.write(&format!("huge{i}.png"), promise(16384, 16384));
    }
    // Alone, and as one of two files that are each within the limit.
    let two = scene::load(&folder.write("two.gltf", gltf(2))).unwrap_err().to_string();
    folder.write("one.gltf", gltf(1));
    folder.write("other.gltf", gltf(1).replace("huge0", "huge1"));
    let toml = "[[mesh]]\nfile = \"one.gltf\"\n[[mesh]]\nfile = \"other.gltf\"\n";
    let both = scene::load(&folder.write("both.toml", toml)).unwrap_err().to_string();
    for error in [&two, &both] {
        assert!(error.contains("536870912") && error.contains("268435456"), "{error}");
    }
    assert!(both.contains("both.toml:4:8: "), "{both}");
}

fn quick<T>(what: &str, of: impl FnOnce() -> T) -> T {
    let clock = Instant::now();
    let result = of();
    assert!(clock.elapsed() < Duration::from_secs(20), "{what} took {:?}", clock.elapsed());
    result
}

/// `nodes` nodes that all name one mesh of `corners` corners.
fn crowd(nodes: usize, corners: usize, flat: bool) -> (String, Vec<u8>) {
    let names = (0..nodes).map(|i| i.to_string()).collect::<Vec<_>>().join(",");
    let all = vec![r#"{"mesh":0}"#; nodes].join(",");
    let length = corners * 12;
    let gltf = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[{names}]}}],"nodes":[{all}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":{corners},"type":"VEC3",
        "min":[0,0,0],"max":[1,1,0]}}],"bufferViews":[{{"buffer":0,"byteLength":{length}}}],
        "buffers":[{{"byteLength":{length},"uri":"crowd.bin"}}]}}"#
    );
    let corner = |i: usize| [u8::from(i % 3 == 1), u8::from(i % 3 == 2 && !flat), 0].map(f32::from);
    (gltf, (0..corners).flat_map(corner).flat_map(f32::to_le_bytes).collect())
}

#[test]
fn meshes_that_are_named_often_are_refused_soon() {
    let folder = Folder::new();
    for flat in [false, true] {
        let (gltf, corners) = crowd(100_000, 99_999, flat);
        folder.write("crowd.bin", corners);
        let path = folder.write("crowd.gltf", gltf);
        let error = quick("a crowd", || scene::load(&path).unwrap_err()).to_string();
        assert!(error.contains("8000000"), "{error}");
    }
    // A few nodes are counted exactly.
    let (gltf, corners) = crowd(7, 6, false);
    folder.write("crowd.bin", corners);
    // The ground adds two.
    assert_eq!(scene::load(&folder.write("few.gltf", gltf)).unwrap().triangles.len(), 14 + 2);
}

#[test]
fn many_names_are_looked_up_soon() {
    let folder = Folder::new();
    let materials: String =
        (0..100_000).map(|i| format!("[[material]]\nname = \"m{i}\"\n")).collect();
    quick("materials", || refused(&materials));
    let lights: String = (0..4096).map(|i| format!("{LAMP}name = \"lamp {i}\"\n")).collect();
    quick("lights", || read(&lights).unwrap());
    // A glTF file may give many lights one name.
    let nodes = vec![r#"{"extensions":{"KHR_lights_punctual":{"light":0}}}"#; 4096].join(",");
    let names = (0..4096).map(|i| i.to_string()).collect::<Vec<_>>().join(",");
    let gltf = |lights: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[{names}]}}],"nodes":[{nodes}],
            "extensionsUsed":["KHR_lights_punctual"],
            "extensions":{{"KHR_lights_punctual":{{"lights":[{lights}]}}}}}}"#
        )
    };
    let lamp = r#"{"type":"point","name":"lamp"}"#;
    let scene = scene::load(&folder.write("lamps.gltf", gltf(lamp))).unwrap();
    assert_eq!(scene.lights.len(), 4096);
}

#[test]
fn long_scene_files_are_refused_unread() {
    let folder = Folder::new();
    let path = folder.write("long.toml", "# ");
    fs::File::options().write(true).open(&path).unwrap().set_len((1 << 24) + 1).unwrap();
    let SceneError::Invalid { message, help, .. } = scene::load(&path).unwrap_err() else {
        panic!("read as a document")
    };
    assert!(message.contains("16777217") && message.contains("16777216"), "{message}");
    assert!(help.unwrap().contains("files of their own"));
}

/// A triangle mesh, keys and joints, each named by many parts of the file.
fn shared(nodes: &str, more: &str) -> String {
    let length = 400_000 * 4;
    format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{nodes}],{more}
        "accessors":[{{"bufferView":0,"componentType":5126,"count":100000,"type":"SCALAR","min":[0],
        "max":[1]}},
        {{"bufferView":0,"componentType":5126,"count":100000,"type":"VEC3"}},
        {{"bufferView":0,"componentType":5126,"count":3000,"type":"VEC3","min":[0,0,0],"max":[1,1,1]}}],
        "bufferViews":[{{"buffer":0,"byteLength":{length}}}],
        "buffers":[{{"byteLength":{length},"uri":"shared.bin"}}]}}"#
    )
}

fn list(count: usize, item: impl Fn(usize) -> String) -> String {
    (0..count).map(item).collect::<Vec<_>>().join(",")
}

#[test]
fn what_a_model_names_often_is_counted_each_time() {
    let folder = Folder::new();
    // Ascending, and no three in a line.
    let numbers = (0..400_000_u32).map(|i| i as f32 + (i % 7) as f32 * 0.1);
    folder.write("shared.bin", numbers.flat_map(f32::to_le_bytes).collect::<Vec<_>>());
    let refused = |nodes: &str, more: &str, most: &str| {
        let path = folder.write("shared.gltf", shared(nodes, more));
        let error = quick(most, || scene::load(&path).unwrap_err()).to_string();
        assert!(error.contains(most), "{error}");
    };
    let of_mesh = |primitive: &str, more: &str| {
        format!(
            r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":2}}{primitive}}}]{more}}}],"#
        )
    };
    // 60 channels of 200,000 numbers.
    let channel = |i| format!(r#"{{"sampler":0,"target":{{"node":{i},"path":"translation"}}}}"#);
    let animation = format!(
        r#""animations":[{{"samplers":[{{"input":0,"output":1}}],"channels":[{}]}}],"#,
        list(60, channel)
    );
    refused(&list(60, |_| "{}".to_owned()), &animation, "10000000");
    // 300 meshes of 5,000 joints.
    let skin = format!(r#""skins":[{{"joints":[{}]}}],"#, list(5000, |i| i.to_string()));
    let node = |i| if i < 5000 { "{}" } else { r#"{"mesh":0,"skin":0}"# }.to_owned();
    refused(&list(5300, node), &(of_mesh("", "") + &skin), "1000000");
    // 300 meshes of 1,000 triangles with 50 targets.
    let targets = list(50, |_| r#"{"POSITION":2}"#.to_owned());
    let weights = format!(r#","weights":[{}]"#, list(50, |_| "1".to_owned()));
    let mesh = of_mesh(&format!(r#","targets":[{targets}]"#), &weights);
    refused(&list(300, |_| r#"{"mesh":0}"#.to_owned()), &mesh, "10000000");
}

/// docs/scene.md states each limit.
#[test]
fn limits_are_documented() {
    let path = Path::new(crate::common::ROOT).join("docs/scene.md");
    let text = fs::read_to_string(path).unwrap();
    let (_, section) = text.split_once("## Limits").expect("a section on limits");
    let section = section.split("\n## ").next().unwrap();
    for limit in scene::Limit::ALL {
        let row = format!("| {} | {} |", limit.noun(), grouped(limit.most()));
        assert!(section.contains(&row), "docs/scene.md lacks {row}");
    }
}

/// A number with thousands separators, such as 1,234,567.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let parts: Vec<_> = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy).collect();
    parts.join(",")
}
