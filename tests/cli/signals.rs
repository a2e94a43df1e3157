//! Signals: the files that they leave, and the commands that they do not end.
use super::{
    commands::files,
    hostile::{QUICK, ends},
    light::array,
    outputs::{CASES, folder},
};
use std::{
    fs,
    path::Path,
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

/// Waits for a temporary file.
fn appears(dir: &Path) {
    let clock = Instant::now();
    while !files(dir).iter().any(|name| name.ends_with(".tmp")) {
        assert!(clock.elapsed() < Duration::from_secs(30), "no temporary file in {dir:?}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Signals end a command that waits for the reader of a pipe, and one that writes a file.
#[test]
fn signals_leave_no_temporary_files() {
    let signal = |child: &Child, name: &str| {
        Command::new("kill").args([name, &child.id().to_string()]).status().unwrap();
    };
    // Signals that this process, and so its children, was not started to ignore.
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.map_or(0, |bits| u64::from_str_radix(bits.trim(), 16).unwrap());
    let signals = [("-INT", 2), ("-TERM", 15), ("-HUP", 1)];
    let signals = signals.iter().filter(|(_, number)| ignored >> (number - 1) & 1 == 0);
    let signals: Vec<_> = signals.map(|&(name, _)| name).collect();
    for (i, case) in CASES.iter().enumerate() {
        let (folder, root) = folder(&format!("outputs-signals{i}"));
        let path = case.path(&root);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
        let mut child = case.run(&folder, &root).stdout(Stdio::null()).spawn().unwrap();
        appears(&folder.0.join("tmp"));
        signal(&child, signals[i % signals.len()]);
        assert_eq!(ends(&mut child), Some(1), "{:?}", case.arguments);
        assert_eq!(files(&folder.0.join("tmp")), [""; 0], "{:?}", case.arguments);
    }
    let (folder, root) = folder("outputs-signals-file");
    let many = vec![0; 12 * 4_000_000];
    fs::write(folder.0.join("p.npy"), array("<f4", 3, &many)).unwrap();
    for name in signals {
        let mut child = CASES[0].run(&folder, &root).spawn().unwrap();
        appears(&root);
        signal(&child, name);
        assert_eq!(ends(&mut child), Some(1), "{name}");
        assert_eq!(files(&root), [""; 0], "{name}");
    }
}

/// At its second signal a job ends at once, and no frame stays locked.
#[test]
fn a_second_signal_leaves_no_locks() {
    let (folder, root) = folder("outputs-twice");
    let job = "render scene.toml -o o --frames 0..4000 --skip-existing --preview o/p.png --backend cpu \
        --set camera.size=[640,360]";
    for _ in 0..3 {
        let mut child = Command::new(env!("CARGO_BIN_EXE_gobo"))
            .args(job.split(' '))
            .current_dir(&folder.0)
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        let clock = Instant::now();
        while !files(&root)
            .iter()
            .any(|name| name.starts_with(".frame_") && name.ends_with(".lock"))
        {
            assert!(clock.elapsed() < Duration::from_secs(30), "no frame is begun");
        }
        // Waiting processes are one.
        let status = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break status.code();
            }
            Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
            std::thread::sleep(Duration::from_millis(20));
        };
        assert_eq!(status, Some(1));
        let is_left = |name: &String| name.ends_with(".lock") || name.ends_with(".tmp");
        let left: Vec<_> = files(&root).into_iter().filter(is_left).collect();
        assert_eq!(left, [""; 0]);
    }
}

/// A signal that a shell or `nohup` makes a program ignore stays ignored.
#[cfg(target_os = "linux")]
#[test]
fn an_ignored_signal_stays_ignored() {
    let (folder, _) = folder("outputs-nohup");
    let script = "trap '' HUP; exec \"$0\" \"$@\"";
    let job = ["render", "scene.toml", "--frames", "0..400", "-o", "o"];
    let mut child = Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_gobo")])
        .args(job)
        .args(QUICK)
        .current_dir(&folder.0)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let first = folder.0.join("o/frame_0000.png");
    let clock = Instant::now();
    while !first.exists() {
        assert!(clock.elapsed() < Duration::from_secs(20));
        std::thread::sleep(Duration::from_millis(5));
    }
    Command::new("kill").args(["-HUP", &child.id().to_string()]).status().unwrap();
    assert_eq!(ends(&mut child), Some(0));
    assert!(folder.0.join("o/frame_0399.png").exists());
}
