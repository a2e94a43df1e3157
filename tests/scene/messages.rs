//! Error messages: plain words, a remedy, the position; and nothing that harms a terminal.
use crate::common::files::{Folder, read};
use gobo_scene as scene;
use gobo_scene::SceneError;
use std::path::Path;

const MATERIAL: &str = "[[material]]\nname = \"m\"\n";

fn refusal(toml: &str) -> (usize, String, String) {
    match read(toml) {
        Err(SceneError::Document { line, message, help, .. }) => {
            (line, message, help.unwrap_or_default())
        }
        Err(other) => panic!("{toml}: {other}"),
        Ok(_) => panic!("read without an error:\n{toml}"),
    }
}

/// Words of the implementation that must not appear.
const FOREIGN: &[&str] = &[
    "f32",
    "f64",
    "u32",
    "u64",
    "i64",
    "usize",
    "struct",
    "Table",
    "enum",
    "variant",
    "invalid type",
    "invalid value",
    "sequence",
    "wanted",
    "newtype",
    "missing field",
    "unknown field",
    "deserial",
    "Spanned",
    "ParseError",
    "Vec<",
    "Some(",
    "None",
];

#[test]
fn every_refusal_is_plain_and_has_a_remedy() {
    for (toml, said) in [
        ("[camera]\neye = 3", "list"),
        ("[camera]\neye = [1, 2]", "3 numbers"),
        ("[camera]\neye = [1, \"2\", 3]", "number"),
        ("[camera]\nsize = [1.5, 2]", "whole number"),
        ("[camera]\nsize = [-1, 2]", "whole number"),
        ("[camera]\nfov_y = \"wide\"", "number"),
        ("[camera]\nfov_y = true", "number"),
        ("[camera]\nfov_y = [1]", "number"),
        ("[camera]\nfov_y = { a = 1 }", "number"),
        ("[camera]\nfov_y = 1979-05-27", "number"),
        ("camera = 1", "table"),
        ("camera = [[1, 2, 3]]", "table"),
        ("[[camera]]", "table"),
        ("environment = [[9, 0, 0], [0, 9, 0]]", "table"),
        ("[shadow]\nfilter = [\"pcf\", 5]", "table"),
        ("[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\nfilter = [\"none\"]", "table"),
        ("[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\nsource = [\"sphere\", 0.1]", "table"),
        ("[[emitter]]\nmaterial = \"m\"\nfluid = [1]", "table"),
        ("[[emitter]]\nmaterial = \"m\"\nfluid = [0.15, 0.3, 1, 0.01]", "table"),
        ("[[emitter]]\nmaterial = \"m\"\nboxes = [[[0, 0, 0], [1, 1, 1]]]", "table"),
        ("[shadow]\nsize = \"big\"", "whole number"),
        ("[shadow]\nsize = -1", "whole number"),
        ("[shadow]\nsize = 99999999999999999999", "number"),
        ("[shadow]\nsoften = 1", "true or false"),
        ("[shadow]\nreceiver = 4", "text"),
        ("[shadow]\nreceiver = \"fast\"", "fast"),
        ("[light]\nkind = \"point\"", "[[light]]"),
        ("[light]\nkind = \"point\"", "a single table"),
        ("light = [1]", "[[light]]"),
        ("light = [[\"a\", \"point\"]]", "[[light]]"),
        ("[[light]]\nname = \"x\"", "kind"),
        ("[[light]]\nkind = \"laser\"", "laser"),
        ("[[light]]\nkind = 3", "text"),
        ("[[light]]\nkind = \"point\"\nposition = [0, 0, 0]\nshadow = [[]]", "[[light.shadow]]"),
        ("[[material]]", "name"),
        ("[[material]]\nname = 3", "text"),
        ("[[material]]\nname = \"m\"\ntexture = 5", "image"),
        ("[[material]]\nname = \"m\"\ntexture = { generate = \"wood\" }", "wood"),
        ("[[material]]\nname = \"m\"\ntexture = {}", "generate"),
        ("[[particles]]\nmaterial = \"m\"\ngenerate = [\"smoke\", 10]", "table"),
        ("[[material]]\nname = \"m\"\n[[particles]]\nmaterial = \"m\"\ngenerate = {}", "kind"),
        (
            "[[material]]\nname = \"m\"\n[[particles]]\nmaterial = \"m\"\ngenerate = { kind = \"smoke\" }",
            "count",
        ),
        (
            "[[material]]\nname = \"m\"\n[[particles]]\nmaterial = \"m\"\n\
             generate = { kind = \"smoke\", count = -4 }",
            "whole number",
        ),
        ("[[shape]]\nkind = \"sphere\"\nmaterial = \"m\"\ndisplace = [0.5]", "table"),
        ("[[mesh]]", "file"),
        ("[[shape]]\nkind = \"torus\"\nmaterial = \"m\"", "torus"),
        ("[shadow]\nsise = 4", "sise"),
        ("[camera]\n[camera]", "camera"),
        ("a = ", ""),
        ("[a", ""),
        ("\u{0}", ""),
        ("é = 'ü", ""),
        ("[camera]\neye = [1, 2, 3", ""),
        ("[camera]\neye = 01", ""),
        ("[shadow]\nsize = 1 2", ""),
        ("name = \"\\q\"", ""),
    ] {
        let (line, message, help) = refusal(toml);
        assert!(line >= 1 && line <= toml.lines().count() + 1, "{toml}: line {line}");
        assert_ne!(help, "", "{toml}: {message}");
        let whole = format!("{message}; {help}");
        assert!(whole.contains(said), "{toml}: {whole}");
        for word in FOREIGN {
            assert!(!whole.contains(word), "{toml}: {word:?} in {whole}");
        }
    }
}

#[test]
fn values_that_would_break_numbers_are_refused() {
    let sun = "[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0]\n";
    let lamp = "[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\n";
    for (head, key, wrong, right) in [
        (sun, "near", "-9e18", "-50"),
        (sun, "near", "-2e7", "0"),
        (sun, "far", "-9e18", "1e7"),
        (
            "[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0]\ncascades = 2\n",
            "range",
            "1e-38",
            "0.01",
        ),
        (lamp, "near", "1e-38", "1e-4"),
        (lamp, "far", "1e-38", "0.01"),
    ] {
        let (line, message, help) = refusal(&format!("{head}{key} = {wrong}\n"));
        assert_eq!(line, 1 + head.lines().count(), "{key}: {message}");
        assert!(message.contains(key) && !help.is_empty(), "{message}; {help}");
        let scene = read(&format!("{head}{key} = {right}\n")).unwrap();
        for view in gobo::view::shadow_views(&scene) {
            let clip = view.clip_from_world().to_cols_array();
            let numbers = clip.iter().chain([&view.near, &view.far]);
            assert!(numbers.copied().all(f32::is_finite), "{key} = {right}: {view:?}");
        }
    }
}

/// Every key that names a file, in a scene that names `FILE` there.
const NAMING: [(&str, &str, &str); 8] = [
    ("environment", "file", "[environment]\nfile = \"FILE.hdr\"\n"),
    ("material", "texture", "[[material]]\nname = \"m\"\ntexture = \"FILE.png\"\n"),
    (
        "particles",
        "file",
        "[[material]]\nname = \"m\"\n[[particles]]\nmaterial = \"m\"\nfile = \"FILE.ply\"\n",
    ),
    (
        "particles",
        "file",
        "[[material]]\nname = \"m\"\n[[particles]]\nmaterial = \"m\"\nfile = \"FILE.csv\"\n",
    ),
    ("splats", "file", "[[splats]]\nfile = \"FILE.spz\"\n"),
    ("mesh", "file", "[[mesh]]\nfile = \"FILE.glb\"\n"),
    ("volume", "file", "[[volume]]\nfile = \"FILE.vdb\"\n"),
    (
        "strands",
        "file",
        "[[material]]\nname = \"m\"\n[[strands]]\nmaterial = \"m\"\nfile = \"FILE_2.ply\"\n",
    ),
];

/// The key and the line of a scene's last line, and the file's name.
fn named(toml: &str) -> (usize, &str) {
    let line = toml.lines().last().unwrap();
    (toml.lines().count(), line.split('"').nth(1).unwrap())
}

/// The error of a named file has the key, its line, the name, the problem and a remedy.
fn assert_named(path: &Path, toml: &str, key: &str, problem: &str) {
    let (last, name) = named(toml);
    let error = scene::load(path).unwrap_err();
    let SceneError::Document { path, line, message, help, excerpt, marked, .. } = &error else {
        panic!("{toml}: {error}")
    };
    assert_eq!((*line, path.ends_with("scene.toml")), (last, true), "{toml}: {error}");
    assert!(message.starts_with(&format!("{key}: ")), "{toml}: {message}");
    assert!(message.contains(name) && message.contains(problem), "{toml}: {message}");
    assert!(help.as_ref().is_some_and(|help| !help.is_empty()), "{toml}: {message}");
    let marked: String = excerpt.chars().skip(marked.start).take(marked.len()).collect();
    assert_eq!(marked, format!("\"{name}\""), "{toml}: {excerpt}");
}

#[test]
fn a_file_that_a_scene_names_is_refused_with_the_line_of_the_scene() {
    let folder = Folder::new();
    for (_, key, toml) in NAMING {
        let (_, name) = named(toml);
        let extension = &name["FILE".len()..];
        let path = folder.write("scene.toml", toml);
        assert_named(&path, toml, key, "os error 2");
        // Bytes of no known format.
        folder.write(name, "\0\u{1}x");
        assert_named(&path, toml, key, "");
        let toml = toml.replace("FILE", "folder");
        std::fs::create_dir(folder.0.join(format!("folder{extension}"))).unwrap();
        assert_named(&folder.write("scene.toml", &toml), &toml, key, "is a folder");
    }
    // A file that a file names.
    let gltf = r#"{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 9, "uri": "no.bin"}]}"#;
    folder.write("model.gltf", gltf);
    let toml = "[[mesh]]\nfile = \"model.gltf\"\n";
    assert_named(&folder.write("scene.toml", toml), toml, "file", "`no.bin`");
}

/// The tables above are those that name files.
#[test]
fn every_key_that_names_a_file_is_tried() {
    let folder = Path::new(crate::common::ROOT).join("crates/gobo-scene/src");
    let keys_of = |file: &str| {
        let text = std::fs::read_to_string(folder.join(file)).unwrap();
        let lines = text.lines().filter(|line| line.contains("PathBuf"));
        lines.filter(|line| !line.starts_with("use ")).count()
    };
    let keys = keys_of("document.rs") + keys_of("document/values.rs");
    let mut tried: Vec<_> = NAMING.iter().map(|(table, key, _)| (table, key)).collect();
    tried.dedup();
    assert_eq!(keys, tried.len(), "keys that name files: {tried:?}");
}

#[test]
fn long_and_strange_names_are_shown_short_and_escaped() {
    let long = "k".repeat(1 << 20);
    for toml in [
        format!("{long} = 1\n"),
        format!("[camera]\n{long} = 1\n"),
        format!("[shadow]\nreceiver = \"{long}\"\n"),
        format!("[[material]]\nname = \"{long}\"\n[[material]]\nname = \"{long}\"\n"),
        format!("{MATERIAL}[[shape]]\nkind = \"box\"\nmaterial = \"{long}\"\n"),
        format!("{MATERIAL}texture = \"{long}\"\n"),
        format!("[[light]]\nkind = \"{long}\"\n"),
    ] {
        let (_, message, help) = refusal(&toml);
        assert!(message.len() + help.len() < 2000, "{} bytes", message.len() + help.len());
    }
    for toml in [
        "\"\\u001b[31mred\" = 1\n",
        "[camera]\n\"\\u009b2J\" = 1\n",
        "[shadow]\nreceiver = \"\\u001b[2J\"\n",
        "[[material]]\nname = \"m\"\ntexture = \"\\u001b]0;title\\u0007.png\"\n",
    ] {
        let (_, message, help) = refusal(toml);
        assert!(!(message + &help).chars().any(char::is_control), "{toml}");
    }
}

#[cfg(unix)]
#[test]
fn what_is_no_plain_file_is_refused() {
    let folder = Folder::new();
    let device = |name: &str| {
        std::os::unix::fs::symlink("/dev/null", folder.0.join(name)).unwrap();
    };
    for name in ["null.toml", "null.ply", "null.glb"] {
        device(name);
        let error = scene::load(&folder.0.join(name)).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains("device"), "{error}");
    }
    for (_, key, toml) in NAMING {
        for made in ["device", "pipe"] {
            let toml = toml.replace("FILE", made);
            let (_, name) = named(&toml);
            if made == "device" {
                device(name);
            } else {
                let status = std::process::Command::new("mkfifo").arg(folder.0.join(name)).status();
                assert!(status.unwrap().success());
            }
            let path = folder.write("scene.toml", &toml);
            assert_named(&path, &toml, key, "is a device or a pipe");
        }
    }
    // A buffer and an image of a model.
    device("null.bin");
    for part in [
        r#""buffers": [{"byteLength": 9, "uri": "null.bin"}]"#,
        r#""buffers": [{"byteLength": 36, "uri": "corners.bin"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "scenes": [{"nodes": [0]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0, 0, 0], "max": [1, 1, 0]}],
        "nodes": [{"mesh": 0}], "images": [{"uri": "null.bin"}], "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}]"#,
    ] {
        let corners = [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].map(f32::to_le_bytes).concat();
        folder.write("corners.bin", corners);
        folder.write("model.gltf", format!(r#"{{"asset": {{"version": "2.0"}}, {part}}}"#));
        let toml = "[[mesh]]\nfile = \"model.gltf\"\n";
        assert_named(&folder.write("scene.toml", toml), toml, "file", "`null.bin` is a device");
    }
}
