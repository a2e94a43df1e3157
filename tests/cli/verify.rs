//! `gobo verify` on bad folders: foreign, wrong and hostile sidecars.
use super::commands::Folder;
use serde_json::{Value, json};
use std::fs;

const JOB: [&str; 8] = [
    "render",
    "scene.toml",
    "--backend",
    "cpu",
    "--skip-existing",
    "--frames=0..4",
    "--set",
    "camera.size=[16,8]",
];

/// A folder with a job of four frames, rendered to `out`.
fn job(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.run(&JOB);
    folder.run(&["verify", "out"]);
    folder
}

/// Lines of `verify`, which must fail.
fn faults(folder: &Folder) -> Vec<String> {
    let output = folder.gobo(&["verify", "out"]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
}

/// Changes the sidecar of frame 1.
fn change(folder: &Folder, change: impl Fn(&mut Value)) {
    let path = folder.0.join("out/frame_0001.json");
    let mut sidecar: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    change(&mut sidecar);
    fs::write(path, sidecar.to_string()).unwrap();
}

#[test]
fn frames_of_another_scene_or_version_are_not_of_the_job() {
    let folder = job("foreign");
    let other = [&JOB[..5], &["--frames=1..2", "--set", "camera.exposure=-2", "-o", "other"]];
    folder.run(&other.concat());
    for name in ["frame_0001.png", "frame_0001.json"] {
        fs::copy(folder.0.join("other").join(name), folder.0.join("out").join(name)).unwrap();
    }
    let foreign = "frame 1 is of another scene, other options or another version than most";
    assert_eq!(faults(&folder), [foreign]);
    folder.run(&JOB);
    folder.run(&["verify", "out"]);
    change(&folder, |sidecar| sidecar["gobo"] = json!("0.0.1"));
    assert_eq!(faults(&folder), [foreign]);
    // Outside of the job's frames it does not belong to the job either.
    folder.run(&JOB);
    folder.run(&[&JOB[..5], &["--frames=7..8", "--set", "camera.exposure=-2"]].concat());
    assert_eq!(faults(&folder), [foreign.replace('1', "7")]);
}

#[test]
fn files_that_a_frame_did_not_write_are_not_its_own() {
    let folder = job("stale");
    for name in ["out/frame_0001.exr", "out/frame_0002.cost.png", "out/notes.txt"] {
        fs::write(folder.0.join(name), "of an earlier run").unwrap();
    }
    fs::create_dir_all(folder.0.join("out/maps/frame_0003")).unwrap();
    fs::write(folder.0.join("out/maps/frame_0003/sun.0.filter.npy"), "").unwrap();
    // Nor does it enter the sidecar of a frame that is rendered again.
    fs::remove_file(folder.0.join("out/frame_0001.png")).unwrap();
    folder.run(&JOB);
    let expected = [
        "frame 1 has frame_0001.exr of another run",
        "frame 2 has frame_0002.cost.png of another run",
        "frame 3 has maps/frame_0003/sun.0.filter.npy of another run",
    ];
    assert_eq!(faults(&folder), expected);
}

#[test]
fn sidecars_that_lie_are_damaged() {
    let folder = job("lies");
    let good = fs::read(folder.0.join("out/frame_0001.json")).unwrap();
    let contents = json!({ "bytes": 0, "sha256": "" });
    type Lie = Box<dyn Fn(&mut Value)>;
    let named = |name: &'static str| -> Lie {
        let contents = contents.clone();
        Box::new(move |sidecar| sidecar["files"][name] = contents.clone())
    };
    let lies: Vec<Lie> = vec![
        Box::new(|sidecar| sidecar["files"] = json!({})),
        Box::new(|sidecar| sidecar["frames"] = json!([2, 4])),
        Box::new(|sidecar| sidecar["frames"] = json!([4, 0])),
        Box::new(|sidecar| sidecar["frame"] = json!(2)),
        named("/dev/zero"),
        named("../scene.toml"),
        named("frame_0001./../../scene.toml"),
        named("maps/frame_0001/../../../scene.toml"),
        named("maps/frame_0001/.."),
        named("frame_0002.png"),
        named(""),
    ];
    for lie in lies {
        fs::write(folder.0.join("out/frame_0001.json"), &good).unwrap();
        change(&folder, lie);
        assert_eq!(faults(&folder), ["frame 1 has a damaged sidecar"]);
    }
    // Renewed, not trusted.
    folder.run(&JOB);
    folder.run(&["verify", "out"]);
}

#[test]
fn a_range_without_end_is_one_line() {
    let folder = job("range");
    change(&folder, |sidecar| sidecar["frames"] = json!([0, u32::MAX]));
    assert_eq!(faults(&folder), ["frames 4 to 4294967294 are missing"]);
}

#[cfg(unix)]
#[test]
fn only_plain_files_are_read() {
    let folder = job("plain");
    let picture = folder.0.join("out/frame_0001.png");
    for target in ["/dev/zero", "../scene.toml"] {
        fs::remove_file(&picture).unwrap();
        std::os::unix::fs::symlink(target, &picture).unwrap();
        assert_eq!(faults(&folder), ["frame 1 lacks frame_0001.png"]);
    }
    fs::remove_file(&picture).unwrap();
    let fifo = std::process::Command::new("mkfifo").arg(&picture).status().unwrap();
    assert!(fifo.success());
    assert_eq!(faults(&folder), ["frame 1 lacks frame_0001.png"]);
    let (_, error) = folder.fail_after(&JOB, 2);
    assert!(error.contains("frame_0001.png: is no plain file"), "{error}");
    fs::remove_file(&picture).unwrap();
    folder.run(&JOB);
    folder.run(&["verify", "out"]);
}

/// Files of another run: without a sidecar, outside of the job.
#[test]
fn stray_frames_are_named() {
    let folder = job("strays");
    let out = folder.0.join("out");
    for name in ["frame_0007.png", "frame_0007.cost.png", "frame_12345.exr"] {
        fs::write(out.join(name), "of an earlier run").unwrap();
    }
    // Foreign files have other names.
    for name in ["frame_007.png", "frame_0008x.png", "frame_0009.notes.txt", "frame_.png"] {
        fs::write(out.join(name), "somebody's").unwrap();
    }
    fs::create_dir_all(out.join("maps/frame_0009")).unwrap();
    fs::write(out.join("maps/frame_0009/sun.0.filter.npy"), "").unwrap();
    let expected = [
        "frame 7 has frame_0007.cost.png of another run",
        "frame 7 has frame_0007.png of another run",
        "frame 9 has maps/frame_0009/sun.0.filter.npy of another run",
        "frame 12345 has frame_12345.exr of another run",
    ];
    assert_eq!(faults(&folder), expected);
    // A missing frame is rendered again, and its present files are not its own.
    fs::write(out.join("frame_0002.exr"), "of an earlier run").unwrap();
    fs::remove_file(out.join("frame_0002.json")).unwrap();
    assert_eq!(faults(&folder)[..1], ["frame 2 is missing"]);
    assert_eq!(faults(&folder).len(), 5);
}
