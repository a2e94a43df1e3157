//! `gobo pack`: a scene and its files on another machine.
use super::commands::{Folder, files};
use std::{
    fs,
    io::{Cursor, Read as _},
    path::Path,
};

const SCENE: &str = "[camera]\nsize = [16, 8]\n[shadow]\nsize = 16\n[environment]\nfile = '../sky/room.hdr'\n\
    [[material]]\nname = 'gel'\ntexture = 'gel.png'\n[[shape]]\nkind = 'pane'\nmaterial = 'gel'\n\
    [[particles]]\nmaterial = 'gel'\nfile = 'deep/dots.csv'\n[[mesh]]\nfile = '../models/one.gltf'\n\
    [[material]]\nname = 'hair'\n[[strands]]\nmaterial = 'hair'\nfile = 'deep/hair.csv'\n";

/// A scene whose files are beside it, below it and above it; one is named twice.
pub(super) fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    let data = Path::new(crate::common::ROOT).join("data/gallery/room.hdr");
    for dir in ["in/scenes/deep", "in/sky", "in/models/parts"] {
        fs::create_dir_all(folder.0.join(dir)).unwrap();
    }
    let write =
        |name: &str, bytes: &[u8]| fs::write(folder.0.join("in").join(name), bytes).unwrap();
    fs::copy(data, folder.0.join("in/sky/room.hdr")).unwrap();
    write("scenes/own.toml", SCENE.as_bytes());
    write("scenes/deep/hair.csv", b"x,y,z,radius\n0,0,0,0.1\n0,2,0,0.1\n");
    write("scenes/deep/dots.csv", b"x,y,z,radius\n0,1,0,0.3\n");
    image::RgbImage::from_pixel(2, 2, image::Rgb([200, 90, 40]))
        .save(folder.0.join("in/scenes/gel.png"))
        .unwrap();
    fs::copy(folder.0.join("in/scenes/gel.png"), folder.0.join("in/models/an image.png")).unwrap();
    let corners = [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].map(f32::to_le_bytes).concat();
    write("models/parts/corners.bin", &corners);
    let gltf = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"images":[{"uri":"an%20image.png"}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],
        "max":[1,1,0]}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "buffers":[{"byteLength":36,"uri":"parts/corners.bin"}]}"#;
    write("models/one.gltf", gltf.as_bytes());
    folder
}

fn unpack(archive: &Path, to: &Path) -> Vec<String> {
    let mut archive = zip::ZipArchive::new(Cursor::new(fs::read(archive).unwrap())).unwrap();
    let mut names = Vec::new();
    for i in 0..archive.len() {
        let mut entry = archive.by_index(i).unwrap();
        let path = to.join(entry.enclosed_name().unwrap());
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        fs::write(path, bytes).unwrap();
        names.push(entry.name().to_owned());
    }
    names
}

#[test]
fn an_unpacked_scene_renders_to_the_same_bytes() {
    let folder = folder("pack");
    folder.run(&["render", "in/scenes/own.toml", "-o", "a", "--backend", "cpu", "--maps"]);
    assert_eq!(folder.run(&["pack", "in/scenes/own.toml", "-o", "own.zip"]), "own.zip\n");
    let first = fs::read(folder.0.join("own.zip")).unwrap();
    folder.run(&["pack", "in/scenes/own.toml", "-o", "own.zip"]);
    assert!(fs::read(folder.0.join("own.zip")).unwrap() == first, "the same bytes each time");
    fs::rename(folder.0.join("in"), folder.0.join("gone")).unwrap();
    let names = unpack(&folder.0.join("own.zip"), &folder.0.join("out"));
    let expected = [
        "scenes/own.toml",
        "models/an image.png",
        "models/one.gltf",
        "models/parts/corners.bin",
        "scenes/deep/dots.csv",
        "scenes/deep/hair.csv",
        "scenes/gel.png",
        "sky/room.hdr",
    ];
    assert_eq!(names[0], expected[0], "the scene comes first");
    let sorted = |names: &[String]| {
        let mut names = names.to_vec();
        names.sort();
        names
    };
    assert_eq!(sorted(&names), sorted(&expected.map(str::to_owned)));
    folder.run(&["render", "out/scenes/own.toml", "-o", "b", "--backend", "cpu", "--maps"]);
    let [a, b] = ["a", "b"].map(|dir| folder.0.join(dir));
    assert_eq!(files(&a), files(&b));
    for name in files(&a) {
        assert!(fs::read(a.join(&name)).unwrap() == fs::read(b.join(&name)).unwrap(), "{name}");
    }
}

/// Shards of one job unpack the scene each in its own folder.
#[test]
fn a_scene_is_the_same_wherever_it_is() {
    let folder = folder("pack-places");
    let job = ["--backend", "cpu", "--frames", "0..4", "--skip-existing", "-o", "o", "--shard"];
    folder.run(&["pack", "in/scenes/own.toml", "-o", "own.zip"]);
    for shard in 0..2 {
        let place = format!("place{shard}");
        unpack(&folder.0.join("own.zip"), &folder.0.join(&place));
        let (scene, shard) = (format!("{place}/scenes/own.toml"), format!("{shard}/2"));
        folder.run(&[&["render", &scene][..], &job, &[&shard]].concat());
    }
    assert_eq!(folder.run(&["verify", "o"]), "4 frames are whole\n");
}

#[test]
fn what_cannot_travel_is_refused() {
    let folder = folder("pack-refused");
    let path = folder.0.join("in/scenes/own.toml");
    let absolute = folder.0.join("in/scenes/gel.png").display().to_string();
    for (name, why) in [
        (absolute.as_str(), "not relative"),
        ("deep/../gel.png", "not relative"),
        ("missing.png", "missing.png"),
    ] {
        fs::write(&path, SCENE.replace("gel.png", name)).unwrap();
        let error = folder.fail(&["pack", "in/scenes/own.toml", "-o", "own.zip"], 2);
        assert!(
            error.contains("own.toml:9:") && error.contains(why) && error.contains("help: "),
            "{error}"
        );
    }
    fs::write(&path, SCENE).unwrap();
    for own in ["in/scenes/own.toml", "in/models/parts/corners.bin"] {
        let before = fs::read(folder.0.join(own)).unwrap();
        assert!(folder.fail(&["pack", "in/scenes/own.toml", "-o", own], 2).contains(own));
        assert_eq!(fs::read(folder.0.join(own)).unwrap(), before);
    }
    assert!(!files(&folder.0).iter().any(|name| name.ends_with(".zip") || name.contains("/.")));
}
