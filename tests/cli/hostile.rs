//! The binary in a hostile environment: full streams, names that are not text, pipes, files left by a
//! killed run, adapters that cannot run the kernels.
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

const QUICK: [&str; 4] = ["--backend", "cpu", "--set", "camera.size=[16,8]"];

#[cfg(target_os = "linux")]
#[test]
fn a_full_or_closed_standard_error_changes_no_status() {
    let folder = Folder::new("full");
    fs::write(folder.0.join("bad.toml"), "[shadow]\nsise = 4\n").unwrap();
    // Warns, for a name that has to change.
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

/// Where a sidecar is looked for.
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
    assert_eq!(ends(&mut child), Some(0));
    folder.run(&["verify", "o"]);
}

/// Each frame's writer holds its lock: what is left of a frame that nobody writes goes with the next writer.
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
    // Of another frame, which another run may be writing; and somebody else's.
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
    // A signal ends the waiting.
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

/// For any set of drivers: the adapter that `info` marks can render, and without a mark `render` fails.
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
        "[[light]]\nname = \"\\u001b]0;x\\u0007\"\nkind = \"point\"\nposition = [0, 1, 0]\nfar = 0\n".to_owned(),
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

/// Ignored contents are reported once, by `check` and by `render`.
#[test]
fn notes_reach_standard_error() {
    let folder = Folder::new("notes");
    fs::write(folder.0.join("dots.csv"), "x,y,z,mass\n0,1,0,7\n").unwrap();
    for arguments in [&["check", "dots.csv"][..], &["render", "dots.csv", "-o", "o"]] {
        let render = if arguments.len() > 2 { &QUICK[..] } else { &[] };
        let output = gobo(&folder).args(arguments).args(render).output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{stderr}");
        assert_eq!(stderr.matches("mass").count(), 1, "{stderr}");
    }
}

/// The required formats of an adapter are exactly those that core kernels write.
#[test]
fn formats_that_adapters_are_asked_for_are_those_that_kernels_write() {
    use gobo::internals::gpu::{BindingKind, STORAGE_FORMATS, Tier};
    let mut written = Vec::new();
    for desc in gobo::internals::stage::KERNELS {
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

/// Runs with so much memory [KiB], and returns the status and standard error.
#[cfg(target_os = "linux")]
fn with_memory(folder: &Folder, most: u32, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new("sh");
    let limit = format!("ulimit -v {most}; exec \"$0\" \"$@\"");
    command.current_dir(&folder.0).args(["-c", &limit]).arg(env!("CARGO_BIN_EXE_gobo"));
    let output = command.args(arguments).output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// A file of zeros behind `head`, which takes no space on the disk.
#[cfg(target_os = "linux")]
fn sparse(folder: &Folder, name: &str, head: &[u8], length: u64) {
    fs::write(folder.0.join(name), head).unwrap();
    fs::File::options().write(true).open(folder.0.join(name)).unwrap().set_len(length).unwrap();
}

#[cfg(target_os = "linux")]
#[test]
fn files_that_the_host_has_no_memory_for_are_refused() {
    let folder = Folder::new("large");
    let refused = |most: u32, arguments: &[&str], why: &str| {
        let (status, told) = with_memory(&folder, most, arguments);
        assert!(matches!(status, Some(1 | 2)), "{arguments:?}: {status:?} {told}");
        assert!(told.contains(why) && told.contains("help: "), "{told}");
    };
    // One quoted field to the end.
    sparse(&folder, "field.csv", b"x,y,z\n\"", 300 << 20);
    refused(1_000_000, &["check", "field.csv"], "no memory");
    // A list of 20 million tables, in 60 MB.
    let json = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{}{{}}]}}",
        "{},".repeat(20_000_000)
    );
    fs::write(folder.0.join("nodes.gltf"), json).unwrap();
    refused(1_500_000, &["check", "nodes.gltf"], "no memory");
}

#[test]
fn previews_of_more_frames_than_the_format_has_are_refused() {
    let folder = Folder::new("frames-preview");
    let all = ["render", "scene.toml", "--frames", "0..4294967295", "--preview", "p.png"];
    assert!(folder.fail(&[&all[..], &QUICK].concat(), 2).contains("2147483647"));
    assert!(!files(&folder.0).iter().any(|name| name.contains("p.png")));
}

/// Six maps of 16 million texels each, with less memory than they need.
#[cfg(target_os = "linux")]
#[test]
fn maps_that_the_host_has_no_memory_for_are_refused() {
    let folder = Folder::new("memory");
    let scene = "[[light]]\nkind = \"point\"\nposition = [0, 2, 0]\nsize = 4096\n\
                 [[material]]\nname = \"m\"\n[[shape]]\nkind = \"pane\"\nmaterial = \"m\"\n";
    fs::write(folder.0.join("scene.toml"), scene).unwrap();
    let mut command = Command::new("sh");
    command.current_dir(&folder.0).args(["-c", "ulimit -v 1500000; exec \"$0\" \"$@\""]);
    let output = command
        .arg(env!("CARGO_BIN_EXE_gobo"))
        .args(["render", "scene.toml", "-o", "o"])
        .args(QUICK)
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("no memory for") && told.contains("help: "), "{told}");
    assert!(!folder.0.join("o/frame_0000.png").exists());
}

/// What the CPU reference keeps of a pixel of shadow masks is many times a pixel of the picture.
#[cfg(target_os = "linux")]
#[test]
fn masks_that_the_reference_has_no_memory_for_are_refused() {
    let folder = Folder::new("large-masks");
    let set = ["--set", "camera.size=[4096,4096]", "--set", "mask.limit=1"];
    let all = [&["render", "scene.toml", "-o", "o", "--backend", "cpu"][..], &set].concat();
    let (status, told) = with_memory(&folder, 5_000_000, &all);
    assert_eq!(status, Some(1), "{told}");
    assert!(told.contains("no memory for") && told.contains("help: "), "{told}");
}

/// The CPU reference reads images as they are in the scene, and makes no copies.
#[cfg(target_os = "linux")]
#[test]
fn the_reference_renders_large_images_in_little_memory() {
    let folder = Folder::new("large-images");
    let mut scene = "[shadow]\nsize = 16\n".to_owned();
    for i in 0..2 {
        let image = image::RgbImage::from_pixel(4096, 4096, image::Rgb([200, 90 * i, 40]));
        image.save(folder.0.join(format!("{i}.png"))).unwrap();
        scene += &format!("[[material]]\nname = \"{i}\"\ntexture = \"{i}.png\"\n");
        scene += &format!("[[shape]]\nkind = \"pane\"\nmaterial = \"{i}\"\n");
    }
    fs::write(folder.0.join("images.toml"), scene).unwrap();
    let all = [&["render", "images.toml", "-o", "o"][..], &QUICK].concat();
    let (status, told) = with_memory(&folder, 800_000, &all);
    assert_eq!(status, Some(0), "{told}");
}

#[cfg(target_os = "linux")]
#[test]
fn emitters_that_the_host_has_no_memory_for_are_refused() {
    let folder = Folder::new("large-emitters");
    let emitter = "[[emitter]]\nmaterial = \"m\"\nrate = 90000\nlifetime = [3, 5]\nstart = -5\n";
    let scene = "[[material]]\nname = \"m\"\n".to_owned() + &emitter.repeat(30);
    fs::write(folder.0.join("many.toml"), scene).unwrap();
    let (status, told) = with_memory(&folder, 1_000_000, &["check", "many.toml"]);
    assert_eq!(status, Some(1), "{told}");
    assert!(told.contains("no memory for") && told.contains("help: "), "{told}");
}

/// Tables that fit each, but not together: the sum is known before anything is made. Each of these scenes
/// would take over half a GB up to the table that is too much.
#[cfg(target_os = "linux")]
#[test]
fn scenes_that_are_too_large_together_take_no_memory() {
    let folder = Folder::new("together");
    let material = "[[material]]\nname = \"m\"\n";
    let dust =
        "[[particles]]\nmaterial = \"m\"\ngenerate = { kind = \"smoke\", count = 16000000 }\n";
    let sphere = "[[shape]]\nkind = \"sphere\"\nmaterial = \"m\"\nlevel = 7\n";
    let emitter = "[[emitter]]\nmaterial = \"m\"\nrate = 90000\nlifetime = 1\n";
    let ply = "[[particles]]\nmaterial = \"m\"\nfile = \"dots.ply\"\n";
    let mesh = "[[mesh]]\nfile = \"fan.gltf\"\n";
    let head = "ply\nformat binary_little_endian 1.0\nelement vertex 9000000\nproperty float x\n\
                property float y\nproperty float z\nend_header\n";
    sparse(&folder, "dots.ply", head.as_bytes(), head.len() as u64 + 12 * 9_000_000);
    // A fan of 200,000 triangles.
    let fan = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":6}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":200002,"type":"VEC3",
        "min":[0,0,0],"max":[0,0,0]}],"bufferViews":[{"buffer":0,"byteLength":2400024}],
        "buffers":[{"byteLength":2400024,"uri":"zeros.bin"}]}"#;
    fs::write(folder.0.join("fan.gltf"), fan).unwrap();
    sparse(&folder, "zeros.bin", &[], 2_400_024);
    for (tables, line, sums) in [
        (dust.repeat(12), 2 + 3 + 3, &["32000000", "192000000", "16000000"][..]),
        (sphere.repeat(1000), 2 + 24 * 4 + 4, &["8192000", "327680000", "8000000"]),
        (dust.to_owned() + emitter, 2 + 3 + 3, &["16091501", "16000000"]),
        (ply.repeat(2), 2 + 3 + 3, &["18000000", "16000000"]),
        (sphere.repeat(24) + mesh, 2 + 24 * 4 + 2, &["8064320", "8000000"]),
    ] {
        fs::write(folder.0.join("large.toml"), material.to_owned() + &tables).unwrap();
        let (status, told) = with_memory(&folder, 400_000, &["check", "large.toml"]);
        assert_eq!(status, Some(2), "{told}");
        assert!(told.contains(&format!("large.toml:{line}:")) && told.contains("help: "), "{told}");
        for sum in sums {
            assert!(told.contains(sum), "{sum}: {told}");
        }
    }
}
