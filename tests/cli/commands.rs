//! The binary: exit status, standard output, files.
use serde_json::Value;
use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

const SCENE: &str = r#"
[camera]
eye = [0, 2, 4]
target = [0, 0, 0]
size = [40, 24]

[shadow]
size = 32

[[light]]
name = "key/light"
kind = "directional"
direction = [0, -1, 0]

[[light]]
name = "lamp"
kind = "point"
position = [0, 2, 0]
size = 16

[[material]]
name = "ground"
transfer = "opaque"

[[material]]
name = "glass"
transfer = "filter"
tint = [1, 0.2, 0.1, 0.5]

[[shape]]
kind = "plane"
material = "ground"
scale = [4, 1, 4]

[[shape]]
kind = "pane"
material = "glass"
translation = [0, 1, 0]
rotation = [90, 0, 0]
"#;

/// A new folder with `scene.toml`; removed at the end.
pub(super) struct Folder(pub(super) PathBuf);

impl Folder {
    pub(super) fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("gobo-cli-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        fs::write(path.join("scene.toml"), SCENE).unwrap();
        Self(path)
    }

    pub(super) fn gobo(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_gobo"))
            .args(arguments)
            .current_dir(&self.0)
            .env_remove("GOBO_LOG")
            .output()
            .unwrap()
    }

    /// Standard output of a command that must succeed.
    pub(super) fn run(&self, arguments: &[&str]) -> String {
        let output = self.gobo(arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {stderr}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// Standard error of a command that must fail before it has a result.
    pub(super) fn fail(&self, arguments: &[&str], status: i32) -> String {
        let (stdout, stderr) = self.fail_after(arguments, status);
        assert_eq!(stdout, b"", "{arguments:?}");
        stderr
    }

    /// Results so far, and standard error, of a command that must fail.
    pub(super) fn fail_after(&self, arguments: &[&str], status: i32) -> (Vec<u8>, String) {
        let output = self.gobo(arguments);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {stderr}");
        assert!(!stderr.contains("panicked"), "{stderr}");
        (output.stdout, stderr)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Every file below, relative to the folder.
pub(super) fn files(root: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let mut pending = vec![root.to_owned()];
    while let Some(dir) = pending.pop() {
        for path in dir.read_dir().unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                pending.push(path);
            } else {
                let name = path.strip_prefix(root).unwrap();
                found.push(name.to_str().unwrap().replace('\\', "/"));
            }
        }
    }
    found.sort();
    found
}

/// Shape and values of an array file.
pub(super) fn npy(path: &Path) -> Result<(Vec<usize>, Vec<f32>), String> {
    let bytes = fs::read(path).map_err(|e| e.to_string())?;
    let rest = bytes.strip_prefix(b"\x93NUMPY\x01\x00").ok_or("no magic")?;
    let (length, rest) = rest.split_at_checked(2).ok_or("no length")?;
    let length = usize::from(u16::from_le_bytes([length[0], length[1]]));
    let (header, data) = rest.split_at_checked(length).ok_or("short header")?;
    let header = str::from_utf8(header).map_err(|e| e.to_string())?;
    if !header.ends_with('\n') || (length + 10) % 64 != 0 {
        return Err("the header is not padded".to_owned());
    }
    let shape = header
        .strip_prefix("{'descr': '<f4', 'fortran_order': False, 'shape': (")
        .and_then(|rest| rest.split_once(')'))
        .ok_or_else(|| header.to_owned())?
        .0;
    let shape: Vec<usize> = shape
        .split(", ")
        .map(|n| n.parse().map_err(|_| shape.to_owned()))
        .collect::<Result<_, _>>()?;
    let values: Vec<_> =
        data.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap_or_default())).collect();
    if data.len() != 4 * shape.iter().product::<usize>() {
        return Err(format!("{} bytes for {shape:?}", data.len()));
    }
    Ok((shape, values))
}

/// The message says how to build a program with a window; the options are the same.
#[test]
#[cfg(not(feature = "view"))]
fn a_program_without_a_window_says_how_to_build_one() {
    let folder = Folder::new("view");
    let error = folder.fail(&["view", "scene.toml", "--beside", "--pick", "0.5", "0.5"], 2);
    assert!(error.contains("cargo install --path crates/gobo-cli --features view"), "{error}");
    let error = folder.fail(&["view", "scene.toml", "--orbit", "3"], 2);
    assert!(error.contains("--screenshot"), "{error}");
}

#[test]
fn bad_usage_is_2() {
    let folder = Folder::new("usage");
    for arguments in [
        &[][..],
        &["paint"],
        &["render"],
        &["render", "scene.toml", "--frames", "3..1"],
        &["render", "scene.toml", "--frame", "1", "--frames", "0..2"],
        &["render", "scene.toml", "--shard", "4/4"],
        &["render", "scene.toml", "--backend", "voodoo"],
        &["render", "scene.toml", "--set", "shadow.size"],
        &["render", "scene.toml", "--debug", "everything"],
        &["render", "scene.toml", "--backend", "cpu", "--debug", "clusters"],
        &["export", "--target", "cobol", "-o", "out"],
        &["export", "--target", "wgsl"],
    ] {
        folder.fail(arguments, 2);
    }
    assert_eq!(files(&folder.0), ["scene.toml"]);
}

#[test]
fn bad_input_is_2_and_is_named() {
    let folder = Folder::new("input");
    for command in ["check", "render"] {
        assert!(folder.fail(&[command, "missing.toml"], 2).contains("missing.toml"));
    }
    assert_eq!(files(&folder.0), ["scene.toml"]);
}

#[test]
fn help_and_version_are_results() {
    let folder = Folder::new("help");
    assert!(folder.run(&["--version"]).starts_with("gobo "));
    let help = folder.run(&["render", "--help"]);
    for option in
        ["--frames", "--shard", "--backend", "--adapter", "--maps", "--debug", "--set", "--json"]
    {
        assert!(help.contains(option), "{option}");
    }
}

#[test]
fn check_prints_a_summary() {
    let folder = Folder::new("check");
    assert!(folder.run(&["check", "scene.toml"]).contains("casters    0 particles, 4 triangles\n"));
    // Emitters are empty, and the most live particles are known: 100 a second for 600 s, and two more.
    let emitter = "[[emitter]]\nmaterial = \"glass\"\nrate = 100\nlifetime = 600\nstart = -600\n";
    fs::write(folder.0.join("scene.toml"), format!("{SCENE}{emitter}")).unwrap();
    let told = folder.run(&["check", "scene.toml"]);
    assert!(
        told.contains("casters    0 particles") && told.contains("at most 60003 particles"),
        "{told}"
    );
}

#[test]
fn info_marks_one_adapter() {
    let folder = Folder::new("info");
    let report: Value = serde_json::from_str(&folder.run(&["info", "--json"])).unwrap();
    let adapters = report["adapters"].as_array().unwrap();
    let chosen: Vec<_> = adapters.iter().filter(|a| a["chosen"] == true).collect();
    assert_eq!(chosen.len(), 1, "{report}");
    let tier = chosen[0]["tier"].as_str().unwrap();
    assert!(chosen[0]["reason"].as_str().unwrap().starts_with(&format!("{tier}: ")));
    assert!(chosen[0]["limits"]["max_storage_buffer_binding_size"].as_u64() >= Some(128 << 20));
    let name = chosen[0]["name"].as_str().unwrap();
    let text = folder.run(&["info"]);
    assert!(text.contains(&format!("* {name}")));
    let is_software = chosen[0]["device_type"] == "Cpu";
    assert_eq!(chosen[0]["advice"].is_string(), is_software);
    assert_eq!(text.contains("--backend cpu is quicker"), is_software);
}

#[test]
fn no_such_adapter_is_3() {
    let folder = Folder::new("adapter");
    let stderr = folder.fail(&["render", "scene.toml", "--adapter", "no such adapter"], 3);
    assert!(stderr.contains("no such adapter") && stderr.contains("gobo info"), "{stderr}");
    assert_eq!(files(&folder.0), ["scene.toml"]);
}

#[test]
fn render_writes_pictures_and_maps() {
    let folder = Folder::new("render");
    let arguments = [
        "render",
        "scene.toml",
        "-o",
        "o",
        "--maps",
        "--json",
        "--frames",
        "0..5",
        "--shard",
        "1/3",
        "--debug",
        "clusters",
        "--debug",
        "cost",
    ];
    let stdout = folder.run(&arguments);
    let lines: Vec<Value> = stdout.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let frames: Vec<_> = lines.iter().map(|line| line["frame"].as_u64().unwrap()).collect();
    assert_eq!(frames, [1, 4]);
    let views = ["views_rendered", "views_kept"].map(|key| lines[1][key].as_u64().unwrap());
    assert!(views[0] == 0 && views[1] > 0 && lines[0]["views_kept"] == 0, "{stdout}");
    for line in &lines {
        for key in [
            "casters",
            "visible",
            "pairs",
            "segments",
            "scattered",
            "overflowed",
            "unordered",
            "peak_bytes",
        ] {
            assert!(line[key].is_u64(), "{key} in {line}");
        }
        for key in ["skipped", "stages", "bytes"] {
            assert!(line[key].is_object(), "{key} in {line}");
        }
        let picture = image::open(folder.0.join(line["picture"].as_str().unwrap())).unwrap();
        assert_eq!((picture.width(), picture.height()), (40, 24));
    }

    let views = [("key_light", "0", 32)].into_iter();
    let views: Vec<_> =
        views.chain(["px", "nx", "py", "ny", "pz", "nz"].map(|face| ("lamp", face, 16))).collect();
    let mut expected = vec!["scene.toml".to_owned()];
    for frame in ["frame_0001", "frame_0004"] {
        expected.push(format!("o/{frame}.png"));
        for (mode, height) in [("clusters", 24), ("cost", 48)] {
            expected.push(format!("o/{frame}.{mode}.png"));
            let image = image::open(folder.0.join(format!("o/{frame}.{mode}.png"))).unwrap();
            assert_eq!((image.width(), image.height()), (40, height), "{mode}");
        }
        expected.push(format!("o/maps/{frame}/views.json"));
        for (light, view, size) in &views {
            for (map, shape, most) in [
                ("filter", &[*size, *size, 3][..], 1.0),
                ("nearest", &[*size, *size], 1.0),
                ("opaque", &[*size, *size], 1.0),
                ("curve", &[*size, *size, 8, 5], 2.0),
            ] {
                let stem = format!("o/maps/{frame}/{light}.{view}.{map}");
                let (found, values) = npy(&folder.0.join(format!("{stem}.npy"))).unwrap();
                assert_eq!(found, shape, "{stem}");
                assert!(values.iter().all(|value| (0.0..=most).contains(value)), "{stem}");
                let preview = image::open(folder.0.join(format!("{stem}.png"))).unwrap();
                assert_eq!((preview.width() as usize, preview.height() as usize), (*size, *size));
                expected.extend([format!("{stem}.npy"), format!("{stem}.png")]);
            }
        }
    }
    expected.sort();
    assert_eq!(files(&folder.0), expected);

    let json = fs::read_to_string(folder.0.join("o/maps/frame_0001/views.json")).unwrap();
    let entries: Value = serde_json::from_str(&json).unwrap();
    let entries = entries.as_array().unwrap();
    let names: Vec<_> = entries
        .iter()
        .map(|e| {
            (
                e["light"].as_str().unwrap(),
                e["view"].as_str().unwrap(),
                e["size"][1].as_u64().unwrap() as usize,
            )
        })
        .collect();
    assert_eq!(names, views);
    assert_eq!(entries[0]["kind"], "directional");
    assert_eq!(entries[0]["direction"], serde_json::json!([0.0, -1.0, 0.0]));
    assert!(entries[0].get("position").is_none());
    assert_eq!(entries[1]["kind"], "point");
    assert_eq!(entries[1]["position"], serde_json::json!([0.0, 2.0, 0.0]));
    assert!(entries[1].get("direction").is_none());
    for entry in entries {
        for matrix in ["clip_from_world", "view_from_world"] {
            assert_eq!(entry[matrix].as_array().unwrap().len(), 16);
        }
        assert!(entry["near"].as_f64() < entry["far"].as_f64(), "{entry}");
    }
}

#[test]
fn a_truncated_array_is_noticed() {
    let folder = Folder::new("truncated");
    folder.run(&["render", "scene.toml", "-o", "o", "--maps", "--backend", "cpu"]);
    let path = folder.0.join("o/maps/frame_0000/key_light.0.filter.npy");
    let bytes = fs::read(&path).unwrap();
    npy(&path).unwrap();
    for length in [bytes.len() - 4, 100, 9, 3, 0] {
        fs::write(&path, &bytes[..length]).unwrap();
        assert!(npy(&path).is_err(), "{length} bytes");
    }
}

#[test]
fn changed_names_are_reported() {
    let folder = Folder::new("names");
    let output = folder.gobo(&["render", "scene.toml", "-o", "o", "--maps", "--backend", "cpu"]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("key/light") && stderr.contains("key_light"), "{stderr}");
    assert!(!stderr.contains("lamp"), "{stderr}");
}

#[test]
fn an_unwritable_folder_is_1() {
    let folder = Folder::new("unwritable");
    let stderr = folder.fail(&["render", "scene.toml", "-o", "scene.toml", "--backend", "cpu"], 1);
    assert!(stderr.contains("scene.toml"), "{stderr}");
    assert_eq!(fs::read_to_string(folder.0.join("scene.toml")).unwrap(), SCENE);
}

/// A folder has the picture's name: the rename fails after the data was written.
#[test]
fn a_failed_write_leaves_nothing_behind() {
    let folder = Folder::new("atomic");
    fs::create_dir_all(folder.0.join("o/frame_0000.png")).unwrap();
    let stderr = folder.fail(&["render", "scene.toml", "-o", "o", "--backend", "cpu"], 1);
    assert!(stderr.contains("frame_0000.png"), "{stderr}");
    assert_eq!(files(&folder.0), ["scene.toml"]);
}
