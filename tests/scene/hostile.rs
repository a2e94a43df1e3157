//! Invalid scene files: each gives an error with position and remedy; none panics.
use crate::common::{
    files::{Folder, read, read_with},
    scenes::Chance,
};
use gobo::glam::Vec3;
use gobo_scene as scene;
use gobo_scene::SceneError;
use std::path::Path;

/// Line, column, message and help.
fn fault(toml: &str) -> (usize, usize, String, String) {
    match read(toml) {
        Err(SceneError::Document { line, column, message, help, .. }) => {
            (line, column, message, help.unwrap_or_default())
        }
        Err(other) => panic!("{toml}: {other}"),
        Ok(_) => panic!("read without an error:\n{toml}"),
    }
}

const LIGHT: &str = "[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0]\n";
const SPOT: &str = "[[light]]\nkind = \"spot\"\nposition = [0, 1, 0]\ndirection = [0, -1, 0]\n";
const POINT: &str = "[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\n";
const MATERIAL: &str = "[[material]]\nname = \"m\"\n";
const SHAPE: &str = "[[material]]\nname = \"m\"\n[[shape]]\nkind = \"box\"\nmaterial = \"m\"\n";
const PARTICLES: &str = "[[material]]\nname = \"m\"\n[[particles]]\nmaterial = \"m\"\n";

#[test]
fn unknown_keys_are_named_with_the_right_one() {
    for (head, key, right) in [
        ("", "[camra]", "camera"),
        ("[camera]\n", "eyes = [0, 0, 0]", "eye"),
        ("[shadow]\n", "sise = 512", "size"),
        ("[environment]\n", "ambiant = [0, 0, 0]", "ambient"),
        (LIGHT, "intensty = 1", "intensity"),
        (MATERIAL, "tnit = [1, 1, 1, 1]", "tint"),
        (MATERIAL, "transfer = \"filtre\"", "filter"),
        (SHAPE, "rotaton = [0, 0, 0]", "rotation"),
        (PARTICLES, "generate = { kind = \"smoke\", count = 1, hieght = 2 }", "height"),
    ] {
        let toml = format!("# first\n{head}{key}\n");
        let (line, _, message, help) = fault(&toml);
        assert_eq!(line, 2 + head.lines().count(), "{message}: {toml}");
        assert_eq!(help, format!("did you mean `{right}`?"), "{message}: {toml}");
    }
    let (line, _, message, help) =
        fault(&format!("{MATERIAL}[[shape]]\nkind = \"box\"\nmaterial = \"n\""));
    assert_eq!((line, message.as_str()), (5, "no material is named `n`"));
    assert!(help.contains('m'), "{help}");
}

/// Each invalid value is refused at its own line and column, and the nearest valid one is not.
#[test]
fn values_out_of_range_are_refused_where_they_stand() {
    for (head, key, wrong, right) in [
        ("[camera]\n", "fov_y", &["0", "180", "-3", "nan", "inf", "1e-30"][..], "179"),
        ("[camera]\n", "size", &["[0, 5]", "[5, 0]", "[99999, 5]"], "[1, 4096]"),
        ("[camera]\n", "eye", &["[nan, 0, 0]", "[0, inf, 0]", "[0, 0, 1e30]"], "[1, 2, 1e7]"),
        ("[camera]\ntarget = [1, 2, 3]\n", "eye", &["[1, 2, 3]"], "[1, 2, 4]"),
        (
            "[camera]\neye = [0, 5, 0]\ntarget = [0, 0, 0]\n",
            "up",
            &["[0, 1, 0]", "[0, 0, 0]"],
            "[1, 0, 0]",
        ),
        ("[shadow]\n", "size", &["15", "4097", "0"], "4096"),
        ("[shadow]\n", "nodes", &["0", "5", "32"], "16"),
        ("[shadow]\n", "bias", &["-0.1", "nan", "inf"], "0"),
        ("[shadow]\n", "normal_bias", &["-0.1", "nan", "inf"], "0"),
        ("[shadow]\n", "slope_bias", &["-0.1", "nan", "inf"], "2"),
        (LIGHT, "bias", &["-1", "nan"], "0"),
        (LIGHT, "slope_bias", &["-1", "inf"], "0"),
        (LIGHT, "normal_bias", &["-1", "inf"], "0"),
        ("[shadow]\n", "pair_budget", &["0"], "1"),
        ("[shadow]\n", "curve_budget", &["0"], "1"),
        ("[environment]\n", "ambient", &["[-1, 0, 0]", "[0, nan, 0]"], "[0, 9, 0]"),
        (LIGHT, "intensity", &["-1", "nan", "inf", "1e300"], "0"),
        (LIGHT, "color", &["[-1, 0, 0]", "[0, 0, nan]"], "[0, 0, 0]"),
        (LIGHT, "cascades", &["0", "7"], "6"),
        (LIGHT, "size", &["8", "5000"], "16"),
        (LIGHT, "far", &["-1", "0", "nan"], "1"),
        (LIGHT, "position", &["[0, 0, 0]"], ""),
        (LIGHT, "angle", &["30"], ""),
        (SPOT, "angle", &["0", "180", "-1", "nan"], "179"),
        (SPOT, "near", &["0", "-1", "nan", "inf"], "0.1"),
        (
            "[[light]]\nkind = \"spot\"\nposition = [0, 1, 0]\n",
            "direction",
            &["[0, 0, 0]", "[nan, 0, 0]"],
            "[0, 1, 0]",
        ),
        ("[[light]]\nfar = 2\nkind = \"point\"\nposition = [0, 1, 0]\n", "near", &["2", "3"], "1"),
        (POINT, "direction", &["[0, -1, 0]"], ""),
        (
            MATERIAL,
            "tint",
            &["[2, 0, 0, 1]", "[0, -1, 0, 1]", "[0, 0, 0, 1.5]", "[0, 0, nan, 1]"],
            "[0, 1, 0, 1]",
        ),
        (
            "[[material]]\nname = \"m\"\ntransfer = \"gain\"\n",
            "tint",
            &["[17, 0, 0, 1]"],
            "[16, 1, 0, 1]",
        ),
        (MATERIAL, "radius", &["0", "-1", "nan", "inf", "1e30"], "1e-3"),
        (MATERIAL, "reflectivity", &["-0.1", "1.1", "nan"], "1"),
        (MATERIAL, "cutoff", &["-0.1", "1.1", "nan"], "0"),
        (MATERIAL, "transmission", &["-0.1", "1.1"], "0.5"),
        (MATERIAL, "roughness", &["-0.1", "1.1"], "0.5"),
        (MATERIAL, "emission", &["[-1, 0, 0]", "[inf, 0, 0]"], "[5, 0, 0]"),
        (SHAPE, "scale", &["[0, 1, 1]", "[nan, 1, 1]", "[1, 1e20, 1]"], "[1, -1, 1e-30]"),
        (SHAPE, "translation", &["[0, inf, 0]", "[0, 2e7, 0]"], "[1, 1, 1]"),
        (SHAPE, "rotation", &["[0, nan, 0]"], "[720, -90, 1]"),
    ] {
        for value in wrong {
            let (line, column, message, help) = fault(&format!("{head}{key} = {value}\n"));
            let place = (1 + head.lines().count(), key.len() + 4);
            assert_eq!((line, column), place, "{key} = {value}: {message}");
            assert!(message.contains(key), "{key} = {value}: {message}");
            assert_ne!(help, "", "{key} = {value}: {message}");
        }
        if !right.is_empty() {
            let toml = format!("{head}{key} = {right}\n");
            read(&toml).unwrap_or_else(|e| panic!("{e}:\n{toml}"));
        }
    }
}

#[test]
fn wrong_types_and_lengths_are_refused() {
    for toml in [
        "[camera]\neye = 3",
        "[camera]\neye = [1, 2]",
        "[camera]\neye = [1, 2, 3, 4]",
        "[camera]\neye = [1, \"2\", 3]",
        "[camera]\nsize = [1.5, 2]",
        "[camera]\nsize = [-1, 2]",
        "camera = 1",
        "[[camera]]",
        "[shadow]\nsize = \"big\"",
        "[shadow]\nsize = -1",
        "[shadow]\nsize = 99999999999999999999",
        "[light]\nkind = \"point\"",
        "[[light]]\nname = \"x\"",
        "[[light]]\nkind = \"laser\"",
        "[[light]]\nkind = \"point\"",
        "[[light]]\nkind = \"spot\"\nposition = [0, 0, 0]",
        "[[light]]\nkind = \"directional\"",
        "[[material]]",
        "[[material]]\nname = 3",
        "[[material]]\nname = \"m\"\n[[material]]\nname = \"m\"",
        "[[light]]\nname = \"l\"\nkind = \"point\"\nposition = [0, 0, 0]\n[[light]]\nname = \"l\"\n\
         kind = \"point\"\nposition = [0, 0, 0]",
        "[[particles]]\nmaterial = \"none\"\nfile = \"x.ply\"",
        "[[material]]\nname = \"m\"\n[[particles]]\nmaterial = \"m\"",
        "[[material]]\nname = \"m\"\n[[particles]]\nmaterial = \"m\"\nfile = \"x.ply\"\n\
         generate = { kind = \"smoke\", count = 1 }",
        "[[material]]\nname = \"m\"\n[[particles]]\nmaterial = \"m\"\ngenerate = { kind = \"smoke\" }",
        "[[material]]\nname = \"m\"\n[[particles]]\nmaterial = \"m\"\n\
         generate = { kind = \"fog\", count = 1 }",
        "[[material]]\nname = \"m\"\n[[particles]]\nmaterial = \"m\"\n\
         generate = { kind = \"smoke\", count = 4000000000 }",
        "[[material]]\nname = \"m\"\n[[particles]]\nmaterial = \"m\"\n\
         generate = { kind = \"smoke\", count = 1, height = nan }",
        "[[material]]\nname = \"m\"\n[[particles]]\nmaterial = \"m\"\n\
         generate = { kind = \"dust\", count = 1, min = [0, 0], max = [1, 1, 1] }",
        "[[mesh]]",
        "[[shape]]\nkind = \"torus\"\nmaterial = \"m\"",
        "a = ",
        "[a",
        "[camera]\n[camera]",
        "\u{0}",
        "é = 'ü",
    ] {
        let (line, column, message, _) = fault(toml);
        assert!(line >= 1 && line <= toml.lines().count() + 1 && column >= 1, "{toml}");
        assert_ne!(message, "", "{toml}");
    }
}

#[test]
fn wrong_values_of_the_command_line_name_it() {
    let deep = ["a"; 5000].join(".");
    for (key, value, said) in [
        ("shadow.sise", "512", "sise"),
        ("shadow.size", "8", "size is 8"),
        ("shadow.size", "big", "whole number"),
        ("shadow", "1", "shadow"),
        ("camera.size", "[1, 2, 3]", "2 numbers"),
        ("camera.size", "[1, 2", "camera.size"),
        ("light.sun.intensity", "nan", "intensity is NaN"),
        ("light.moon.size", "64", "moon"),
        ("light.7.size", "64", "7"),
        ("light.0", "64", "which key"),
        ("material.m.tint", "[1, 1, 1, 1]", "tint"),
        (".", "1", "no such key"),
        (deep.as_str(), "1", "no such key"),
    ] {
        let error = read_with("[shadow]\nsize = 64\n", &[(key, value)]).unwrap_err();
        let text = error.to_string();
        assert!(text.contains("scene.toml"), "{text}");
        let shown: String = format!("--set {key}").chars().take(60).collect();
        assert!(text.contains(&shown) && text.contains(&format!("={value}")), "{text}");
        assert!(text.len() < 1000, "{text}");
        assert!(text.contains(said), "{said}: {text}");
    }
    // A fault of the file keeps its line.
    let error = read_with("\n[shadow]\nsize = 1\n", &[("shadow.bias", "1")]).unwrap_err();
    assert!(error.to_string().contains("scene.toml:3:8: size is 1"), "{error}");
}

#[test]
fn files_that_are_not_there_are_named() {
    let folder = Folder::new();
    let fail = |path: &Path| scene::load(path).unwrap_err().to_string();
    for name in ["none.toml", "none.glb", "none.gltf", "none.ply", "none.csv"] {
        let text = fail(&folder.0.join(name));
        assert!(text.contains(name), "{text}");
        std::fs::create_dir(folder.0.join(format!("folder-{name}"))).unwrap();
        let text = fail(&folder.0.join(format!("folder-{name}")));
        assert!(text.contains(name), "{text}");
    }
    for name in ["scene.dat", "scene", ".toml", ""] {
        let error = scene::load(&folder.0.join(name)).unwrap_err();
        let SceneError::Invalid { help: Some(help), .. } = error else { panic!("{name}: {error}") };
        for kind in [".toml", ".glb", ".gltf", ".ply", ".csv"] {
            assert!(help.contains(kind), "{help}");
        }
    }
    for (toml, name) in [
        (format!("{MATERIAL}texture = \"no.png\""), "no.png"),
        (format!("{MATERIAL}texture = \".\""), ""),
        (format!("{MATERIAL}texture = \"scene.toml\""), "scene.toml"),
        (format!("{PARTICLES}file = \"no.ply\""), "no.ply"),
        (format!("{PARTICLES}file = \"no.csv\""), "no.csv"),
        (format!("{PARTICLES}file = \"scene.toml\""), "scene.toml"),
        ("[[mesh]]\nfile = \"no.glb\"".to_owned(), "no.glb"),
    ] {
        let text = fail(&folder.write("scene.toml", &toml));
        assert!(text.contains(name), "{text}");
    }
    for name in ["e.glb", "e.gltf", "e.ply", "e.csv", "e.vdb"] {
        let text = fail(&folder.write(name, ""));
        assert!(text.contains(name), "{text}");
    }
    let text = fail(&folder.write("latin.toml", b"# \xe9\n"));
    assert!(text.contains("latin.toml"), "{text}");
}

/// Bytes changed, cut out, duplicated: each file gives a result or an error, and a scene that is read is
/// valid.
#[test]
fn mutated_files_do_not_panic() {
    let small = format!(
        "[camera]\neye = [4, 3, 6]\nfov_y = 45\nsize = [96, 54]\n[shadow]\nsize = 64\n{SPOT}\
         angle = 30\n{PARTICLES}generate = {{ kind = \"cloud\", count = 9, extent = [1, 2, 3] }}\n\
         [[shape]]\nkind = \"sphere\"\nmaterial = \"m\"\nscale = [1, 2, 3]\n"
    );
    let folder = Folder::new();
    let mut chance = Chance::new(41);
    let (mut read, mut refused) = (0, 0);
    for _ in 0..3000 {
        let mut bytes = small.clone().into_bytes();
        for _ in 0..=chance.below(3) {
            let at = chance.below(bytes.len());
            match chance.below(4) {
                0 => bytes[at] = chance.below(256) as u8,
                1 => bytes[at] = b"0123456789-.e[]\"={}\n"[chance.below(20)],
                2 => drop(bytes.drain(at..(at + 1 + chance.below(9)).min(bytes.len()))),
                _ => bytes.insert(at, b"09-.e"[chance.below(5)]),
            }
        }
        match scene::load(&folder.write("scene.toml", &bytes)) {
            Ok(scene) => {
                read += 1;
                assert!(scene.camera.eye.is_finite());
                let particles = scene.particles.iter().all(|p| p.center.is_finite());
                let normals = scene.triangles.iter().flat_map(|t| t.normals).all(Vec3::is_finite);
                assert!(particles && normals, "{}", String::from_utf8_lossy(&bytes));
                assert_eq!(gobo_scene::Summary::of(&scene).lights, scene.lights.len());
            }
            Err(error) => {
                refused += 1;
                assert!(error.to_string().contains("scene.toml"), "{error}");
            }
        }
    }
    assert!(read > 30 && refused > 1000, "{read} read, {refused} refused");
}
