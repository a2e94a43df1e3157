//! The binary in a hostile environment: full streams, names that are not text, pipes, files left by a killed
//! run, adapters that cannot run the kernels.
use super::commands::{Folder, files};
use serde_json::Value;
use std::{
    fs,
    process::Command,
    time::{Duration, Instant},
};

fn gobo(folder: &Folder) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gobo"));
    command.current_dir(&folder.0).env_remove("GOBO_LOG");
    command
}

pub(super) const QUICK: [&str; 4] = ["--backend", "cpu", "--set", "camera.size=[16,8]"];

#[cfg(target_os = "linux")]
#[test]
fn a_full_or_closed_standard_error_changes_no_status() {
    let folder = Folder::new("full");
    fs::write(folder.0.join("bad.toml"), "[shadow]\nsise = 4\n").unwrap();
    // Warns of a name that has to change.
    let warns = ["render", "scene.toml", "-o", "o", "--maps", "--set", "shadow.size=16"];
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    for (arguments, status) in [
        (&["check", "bad.toml"][..], 2),
        (&["render", "bad.toml"], 2),
        (&["paint"], 2),
        (&warns, 0),
    ] {
        let all: Vec<_> =
            arguments.iter().chain(if status == 0 { &QUICK[..] } else { &[] }).collect();
        let found = gobo(&folder).args(&all).stderr(full()).status().unwrap().code();
        assert_eq!(found, Some(status), "{arguments:?} with a full standard error");
        let shell = "exec \"$0\" \"$@\" 2>&-".to_owned();
        let found = Command::new("sh")
            .args(["-c", &shell, env!("CARGO_BIN_EXE_gobo")])
            .args(&all)
            .current_dir(&folder.0)
            .status()
            .unwrap()
            .code();
        assert_eq!(found, Some(status), "{arguments:?} with a closed standard error");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_whose_name_is_no_text_is_written() {
    use std::{ffi::OsStr, os::unix::ffi::OsStrExt as _};
    let folder = Folder::new("bytes");
    let name = OsStr::from_bytes(b"o\xff");
    let output = gobo(&folder)
        .args(["render", "scene.toml", "--json"])
        .args(QUICK)
        .arg("-o")
        .arg(name)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let line: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(line["picture"].as_str().unwrap().ends_with("frame_0000.png"), "{line}");
    assert!(folder.0.join(name).join("frame_0000.png").is_file());
}

#[cfg(unix)]
#[test]
fn a_pipe_is_no_scene() {
    let folder = Folder::new("pipe");
    for name in ["pipe.toml", "pipe.ply", "pipe.glb"] {
        assert!(Command::new("mkfifo").arg(folder.0.join(name)).status().unwrap().success());
        let mut child = gobo(&folder).args(["check", name]).spawn().unwrap();
        assert_eq!(ends(&mut child), Some(2), "{name}");
    }
}

/// A pipe in the place of a sidecar.
#[cfg(unix)]
#[test]
fn a_pipe_is_no_sidecar() {
    let folder = Folder::new("pipe-sidecar");
    let job = ["render", "scene.toml", "-o", "o", "--frames", "0..2", "--skip-existing"];
    assert!(gobo(&folder).args(job).args(QUICK).status().unwrap().success());
    let sidecar = folder.0.join("o/frame_0001.json");
    fs::remove_file(&sidecar).unwrap();
    assert!(Command::new("mkfifo").arg(&sidecar).status().unwrap().success());
    let mut child = gobo(&folder).args(["verify", "o"]).spawn().unwrap();
    assert_eq!(ends(&mut child), Some(1));
    let mut child = gobo(&folder).args(job).args(QUICK).spawn().unwrap();
    assert_eq!(ends(&mut child), Some(2));
    fs::remove_file(&sidecar).unwrap();
    let mut child = gobo(&folder).args(job).args(QUICK).spawn().unwrap();
    assert_eq!(ends(&mut child), Some(0));
    folder.run(&["verify", "o"]);
}

/// Each frame's writer holds its lock: the next writer removes the remains of a frame that nobody writes.
#[test]
fn what_a_killed_run_left_is_removed() {
    let folder = Folder::new("stray");
    let out = folder.0.join("o/maps/frame_0000");
    fs::create_dir_all(&out).unwrap();
    for stray in [
        "o/.frame_0000.png.4711.tmp",
        "o/.frame_0000.lock",
        "o/maps/frame_0000/.sun.0.filter.npy.99.tmp",
    ] {
        fs::write(folder.0.join(stray), "half").unwrap();
    }
    // Files of another frame, which another run may be writing, and foreign files.
    let others = ["o/.a.b.tmp", "o/.frame_0001.png.12.tmp", "o/.notes.tmp", "o/notes.tmp"];
    for other in others {
        fs::write(folder.0.join(other), "mine").unwrap();
    }
    let arguments = ["render", "scene.toml", "-o", "o", "--maps", "--set", "shadow.size=16"];
    let status = gobo(&folder).args(arguments).args(QUICK).status().unwrap();
    assert_eq!(status.code(), Some(0));
    let hidden = |name: &String| name.contains("/.") || name.ends_with(".tmp");
    let left: Vec<_> = files(&folder.0).into_iter().filter(hidden).collect();
    assert_eq!(left, others);
}

/// Nobody writes a frame while another process holds its lock.
#[cfg(unix)]
#[test]
fn a_frame_that_another_process_writes_is_waited_for() {
    let folder = Folder::new("busy");
    fs::create_dir(folder.0.join("o")).unwrap();
    let lock = fs::File::create(folder.0.join("o/.frame_0001.lock")).unwrap();
    lock.lock().unwrap();
    let job = ["render", "scene.toml", "-o", "o", "--frames", "0..3", "--skip-existing"];
    let mut child = gobo(&folder).args(job).args(QUICK).spawn().unwrap();
    let last = folder.0.join("o/frame_0002.json");
    let clock = Instant::now();
    while !last.exists() {
        assert!(clock.elapsed() < Duration::from_secs(20), "it waits for frame 1 too early");
        std::thread::sleep(Duration::from_millis(10));
    }
    std::thread::sleep(Duration::from_millis(100));
    assert!(child.try_wait().unwrap().is_none() && !folder.0.join("o/frame_0001.png").exists());
    drop(lock);
    assert_eq!(child.wait().unwrap().code(), Some(0));
    folder.run(&["verify", "o"]);
    // A signal ends the wait.
    let lock = fs::File::create(folder.0.join("o/.frame_0003.lock")).unwrap();
    lock.lock().unwrap();
    let job = ["render", "scene.toml", "-o", "o", "--frames", "0..4", "--skip-existing"];
    let mut child = gobo(&folder).args(job).args(QUICK).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert_eq!(ends(&mut child), Some(1));
}

/// Status of a process that must end by itself.
#[cfg(unix)]
pub(super) fn ends(child: &mut std::process::Child) -> Option<i32> {
    let clock = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status.code();
        }
        if clock.elapsed() > Duration::from_secs(20) {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("it does not end");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// For any set of drivers, the adapter that `info` marks can render; without a mark `render` fails.
#[test]
fn info_and_render_agree_without_vulkan() {
    let folder = Folder::new("gl");
    let without = |arguments: &[&str]| {
        let missing = "/there/is/no/driver.json";
        gobo(&folder)
            .args(arguments)
            .env("VK_ICD_FILENAMES", missing)
            .env("VK_DRIVER_FILES", missing)
            .output()
            .unwrap()
    };
    let info = without(&["info", "--json"]);
    let report: Value = serde_json::from_slice(&info.stdout).unwrap();
    let adapters = report["adapters"].as_array().unwrap();
    let chosen = adapters.iter().find(|adapter| adapter["chosen"] == true);
    let render = without(&["render", "scene.toml", "-o", "o", "--set", "camera.size=[16,8]"]);
    let stderr = String::from_utf8_lossy(&render.stderr);
    let statuses = (info.status.code(), render.status.code());
    if chosen.is_some() {
        assert_eq!(statuses, (Some(0), Some(0)), "{stderr}");
        return;
    }
    assert_eq!(statuses, (Some(3), Some(3)), "{stderr}");
    assert!(stderr.contains("--backend cpu") && stderr.contains("Vulkan"), "{stderr}");
    assert!(!stderr.contains("Validation"), "{stderr}");
    for adapter in adapters {
        let reason = adapter["unusable"].as_str().expect("a reason");
        assert!(stderr.contains(adapter["name"].as_str().unwrap()), "{stderr}");
        assert_ne!(reason, "");
    }
}

#[test]
fn frames_past_the_last_are_refused() {
    let folder = Folder::new("frames");
    for arguments in [["--frame", "4294967295"], ["--frames", "4294967295..4294967295"]] {
        let all = [&["render", "scene.toml"][..], &arguments].concat();
        assert!(folder.fail(&all, 2).contains("4294967295"));
    }
    assert_eq!(files(&folder.0), ["scene.toml"]);
}

#[test]
fn nothing_of_the_input_reaches_the_terminal_raw() {
    let folder = Folder::new("escape");
    let scenes = [
        "\"\\u001b[31mred\" = 1\n".to_owned(),
        "# \x1b[31m\nsize \x1b[2J= = 1\n".to_owned(),
        format!("[shadow]\nsise = 1 # \x1b[2J {}\n", "long ".repeat(100_000)),
        format!("{}\n", "k".repeat(1 << 20)),
        "[[light]]\nname = \"\\u001b]0;x\\u0007\"\nkind = \"point\"\nposition = [0, 1, 0]\n\
         far = 0\n"
            .to_owned(),
    ];
    for scene in scenes {
        fs::write(folder.0.join("scene.toml"), &scene).unwrap();
        let stderr = folder.fail(&["check", "scene.toml"], 2);
        assert!(!stderr.contains(|c: char| c.is_control() && c != '\n'), "{stderr:?}");
        assert!(stderr.len() < 4000, "{} bytes", stderr.len());
    }
    fs::write(folder.0.join("scene.toml"), "[[mesh]]\nfile = \"\\u001b[2J.glb\"\n").unwrap();
    assert!(!folder.fail(&["check", "scene.toml"], 2).contains('\x1b'));
}

/// The decoder panics at an incomplete code table: the error names the file, and no line of source.
#[test]
fn a_damaged_container_is_one_error() {
    let folder = Folder::new("ktx2");
    let mut bytes = include_bytes!("../scene/tiles_etc1s.ktx2").to_vec();
    bytes[284..288].copy_from_slice(&[1, 0, 0, 0]);
    fs::write(folder.0.join("tiles.ktx2"), bytes).unwrap();
    let gltf = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "extensionsUsed":["KHR_texture_basisu"],"images":[{"uri":"tiles.ktx2"}],
        "textures":[{"extensions":{"KHR_texture_basisu":{"source":0}}}],
        "materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
        "accessors":[{"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[0,0,0]}]}"#;
    fs::write(folder.0.join("tiles.gltf"), gltf).unwrap();
    let stderr = folder.fail(&["check", "tiles.gltf"], 2);
    assert!(stderr.contains("tiles.gltf: image 0: the KTX2 container is damaged"), "{stderr}");
    assert!(!stderr.contains("panicked"), "{stderr}");
}

/// Ignored contents are reported once, by `check` and by `render`.
#[test]
fn notes_reach_standard_error() {
    let folder = Folder::new("notes");
    fs::write(folder.0.join("dots.csv"), "x,y,z,mass\n0,1,0,7\n").unwrap();
    for arguments in [&["check", "dots.csv"][..], &["render", "dots.csv", "-o", "o"]] {
        let small = [&QUICK[..], &["--set", "shadow.size=16"]].concat();
        let render = if arguments.len() > 2 { &small[..] } else { &[] };
        let output = gobo(&folder).args(arguments).args(render).output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{stderr}");
        assert_eq!(stderr.matches("mass").count(), 1, "{stderr}");
    }
}

/// The required formats of an adapter are exactly those that core kernels write.
#[test]
fn formats_that_adapters_are_asked_for_are_those_that_kernels_write() {
    use gobo::gpu::{BindingKind, STORAGE_FORMATS, Tier};
    let mut written = Vec::new();
    for desc in gobo_picture::stage::kernels() {
        let Ok(linked) = desc.link(Tier::Core) else { continue };
        for binding in linked.bindings().unwrap() {
            if let BindingKind::StorageTexture { format, .. } = binding.kind {
                assert!(STORAGE_FORMATS.contains(&format), "{}: {format:?}", binding.name);
                written.push(format);
            }
        }
    }
    for format in STORAGE_FORMATS {
        assert!(written.contains(&format), "no kernel writes {format:?}");
    }
}
