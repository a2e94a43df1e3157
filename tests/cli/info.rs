//! `gobo info`, and messages of drivers.
use super::commands::Folder;
use serde_json::Value;
use std::process::Command;

/// The tests' adapter is correct.
#[test]
fn an_adapter_is_tried() {
    let folder = Folder::new("try");
    let text = folder.run(&["info", "--try", "--json"]);
    let report: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(report["trusted"], true);
    let compared = report["compared"].as_array().unwrap();
    // Three lights have eight views, each with four maps; and the picture.
    assert_eq!(compared.len(), 4 * 8 + 1);
    for (i, map) in compared.iter().enumerate() {
        let texels = map["texels"].as_u64().unwrap();
        assert!(texels >= 32 * 32 && map["apart"].as_u64().unwrap() * 500 <= texels, "{i}: {map}");
    }
    let casts = |name: &str| compared.iter().any(|map| map["name"] == name);
    assert!(casts("sun.0.filter") && casts("spot.0.curve") && casts("lamp.ny.opaque"));
}

#[test]
fn an_adapter_that_is_none_is_named() {
    let folder = Folder::new("try-none");
    for arguments in [&["info"][..], &["info", "--try"], &["info", "--json"]] {
        let none = [arguments, &["--adapter", "no such thing"]].concat();
        let error = folder.fail_after(&none, 3).1;
        assert!(error.contains("no such thing"), "{error}");
        let cpu = [arguments, &["--backend", "cpu"]].concat();
        assert!(folder.fail(&cpu, 2).contains("leave --backend cpu out"));
    }
}

/// On a machine without a desktop.
#[cfg(target_os = "linux")]
#[test]
fn drivers_print_nothing_of_their_own() {
    let folder = Folder::new("quiet");
    let render = ["render", "scene.toml", "-o", "o", "--set", "camera.size=[16,8]", "--set"];
    for arguments in [&["info"][..], &[&render[..], &["shadow.size=16"]].concat()] {
        for folder_for_sockets in [None, Some(""), Some("not/absolute")] {
            let mut command = Command::new(env!("CARGO_BIN_EXE_gobo"));
            command.args(arguments).current_dir(&folder.0).env_remove("GOBO_LOG");
            match folder_for_sockets {
                None => command.env_remove("XDG_RUNTIME_DIR"),
                Some(path) => command.env("XDG_RUNTIME_DIR", path),
            };
            let output = command.output().unwrap();
            assert_eq!(output.status.code(), Some(0));
            assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{arguments:?}");
        }
    }
}

/// A line for each format, and the contents of a file.
#[test]
fn files_are_described() {
    let folder = Folder::new("contents");
    let list = folder.run(&["info", "--formats"]);
    for words in [".las", ".ksplat", "lod-meta.json", ".obj", ".vdb", ".exr"] {
        assert!(list.contains(words), "{words}: {list}");
    }
    let json: Value = serde_json::from_str(&folder.run(&["info", "--formats", "--json"])).unwrap();
    assert_eq!(json.as_array().unwrap().len(), list.lines().count());
    let ply = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
        property float z\nproperty float mass\nend_header\n1 2 3 4\n";
    std::fs::write(folder.0.join("dots.ply"), ply).unwrap();
    let text = folder.run(&["info", "dots.ply"]);
    for words in ["read as particles", "1 of `vertex`: `x` `y` `z` `mass`", "1 particles", "`mass`"]
    {
        assert!(text.contains(words), "{words}: {text}");
    }
    let json: Value = serde_json::from_str(&folder.run(&["info", "dots.ply", "--json"])).unwrap();
    assert_eq!(
        (&json["format"]["family"], &json["summary"]["particles"]),
        (&"particles".into(), &1.into())
    );
    let error = folder.fail(&["info", "none.xyz"], 2);
    assert!(error.contains("no known kind") && error.contains(".las"), "{error}");
    assert!(folder.fail(&["info", "dots.ply", "--try"], 2).contains("cannot be used"));
}
