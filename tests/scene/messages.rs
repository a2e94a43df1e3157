//! Error messages: plain words, a remedy, the position; and nothing that harms a terminal.
use crate::common::files::{Folder, read};
use gobo::scene::{self, SceneError};

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
            "[[material]]\nname = \"m\"\n[[particles]]\nmaterial = \"m\"\ngenerate = { kind = \"smoke\", count = -4 }",
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

#[test]
fn a_missing_file_has_the_line_of_the_scene() {
    for (toml, line) in [
        (format!("{MATERIAL}texture = \"no.png\"\n"), 3),
        (format!("{MATERIAL}\n[[particles]]\nmaterial = \"m\"\nfile = \"no.png\"\n"), 6),
        ("\n[[mesh]]\nfile = \"no.png\"\n".to_owned(), 3),
    ] {
        let (found, message, help) = refusal(&toml);
        assert_eq!(found, line, "{message}");
        assert!(message.contains("no.png") && !help.is_empty(), "{message}; {help}");
    }
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
    for name in ["null.toml", "null.ply", "null.glb", "null.png"] {
        std::os::unix::fs::symlink("/dev/null", folder.0.join(name)).unwrap();
    }
    for name in ["null.toml", "null.ply", "null.glb"] {
        let error = scene::load(&folder.0.join(name)).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains("device"), "{error}");
    }
    let toml = folder.write("scene.toml", format!("{MATERIAL}texture = \"null.png\"\n"));
    let error = scene::load(&toml).unwrap_err().to_string();
    assert!(error.contains("null.png") && error.contains("device"), "{error}");
}
