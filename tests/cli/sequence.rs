//! Jobs of many frames: stopped, damaged and continued.
use super::commands::Folder;
use std::{
    collections::BTreeMap,
    fs,
    path::Path,
    process::{Command, Stdio},
    time::{Duration, Instant, SystemTime},
};

const JOB: [&str; 6] =
    ["render", "scene.toml", "--backend", "cpu", "--skip-existing", "--frames=0..4"];

/// Modification time and contents of each picture.
fn pictures(dir: &Path) -> BTreeMap<String, (SystemTime, Vec<u8>)> {
    let files = fs::read_dir(dir.join("out")).unwrap().map(|entry| entry.unwrap().path());
    files
        .filter(|path| path.extension().is_some_and(|extension| extension == "png"))
        .map(|path| {
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            let written = fs::metadata(&path).unwrap().modified().unwrap();
            (name, (written, fs::read(&path).unwrap()))
        })
        .collect()
}

#[test]
fn a_job_goes_on_where_frames_are_missing_or_damaged() {
    let folder = Folder::new("goes-on");
    let first = folder.run(&JOB);
    let before = pictures(&folder.0);
    assert_eq!(before.len(), 4);
    folder.run(&["verify", "out"]);

    let out = folder.0.join("out");
    fs::remove_file(out.join("frame_0001.png")).unwrap();
    let damaged = out.join("frame_0002.png");
    let mut bytes = fs::read(&damaged).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&damaged, bytes).unwrap();
    fs::remove_file(out.join("frame_0003.json")).unwrap();
    let verified = folder.gobo(&["verify", "out"]);
    assert_eq!(verified.status.code(), Some(1));
    let lines = String::from_utf8(verified.stdout).unwrap();
    assert_eq!(
        lines.lines().collect::<Vec<_>>(),
        [
            "frame 1 lacks frame_0001.png",
            "frame 2 has a damaged frame_0002.png",
            "frame 3 is missing"
        ]
    );

    let again = folder.run(&JOB);
    assert_eq!(again, first, "each frame is named, rendered or not");
    let after = pictures(&folder.0);
    for (name, (written, bytes)) in &before {
        let (later, same) = &after[name];
        assert_eq!(bytes, same, "{name}");
        assert_eq!(later == written, name == "frame_0000.png", "{name}");
    }
    folder.run(&["verify", "out"]);
}

#[test]
fn other_inputs_make_other_frames() {
    let folder = Folder::new("other-inputs");
    folder.run(&JOB);
    let before = pictures(&folder.0);
    let darker = [&JOB[..], &["--set", "camera.exposure=-2"]].concat();
    folder.run(&darker);
    let after = pictures(&folder.0);
    assert!(before.iter().all(|(name, (_, bytes))| after[name].1 != *bytes));
    // Options that add files are a change, too.
    folder.run(&[&darker[..], &["--maps"]].concat());
    assert!(folder.0.join("out/maps/frame_0003/views.json").is_file());
    fs::remove_file(folder.0.join("out/maps/frame_0003/views.json")).unwrap();
    let verified = folder.gobo(&["verify", "out"]);
    let lines = String::from_utf8(verified.stdout).unwrap();
    assert_eq!(lines, "frame 3 lacks maps/frame_0003/views.json\n");
}

#[test]
fn shards_are_one_job() {
    let folder = Folder::new("shards");
    folder.run(&[&JOB[..], &["--shard", "1/2"]].concat());
    let verified = folder.gobo(&["verify", "out"]);
    let lines = String::from_utf8(verified.stdout).unwrap();
    assert_eq!(lines, "frame 0 is missing\nframe 2 is missing\n");
    folder.run(&[&JOB[..], &["--shard", "0/2"]].concat());
    folder.run(&["verify", "out"]);
    // Without any sidecar, `verify` fails too.
    fs::create_dir(folder.0.join("empty")).unwrap();
    assert_eq!(folder.gobo(&["verify", "empty"]).status.code(), Some(1));
    assert_eq!(folder.gobo(&["verify", "nowhere"]).status.code(), Some(1));
}

#[cfg(unix)]
#[test]
fn a_signal_ends_a_job_after_a_frame() {
    let folder = Folder::new("signal");
    let job = ["render", "scene.toml", "--backend", "cpu", "--skip-existing", "--frames=0..5000"];
    let mut child = Command::new(env!("CARGO_BIN_EXE_gobo"))
        .args(job)
        .current_dir(&folder.0)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while !folder.0.join("out/frame_0002.json").exists() {
        assert!(start.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(10));
    }
    let killed = Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(1), "it ended by itself");
    // Each started frame is complete, and none is partial.
    let names: Vec<_> = fs::read_dir(folder.0.join("out"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    let count = names.len() / 2;
    assert!(count < 5000);
    for frame in 0..count {
        for extension in ["png", "json"] {
            assert!(names.contains(&format!("frame_{frame:04}.{extension}")), "{names:?}");
        }
    }
}
