//! Many processes in one folder.
use super::commands::{Folder, files};
use serde_json::Value;
use std::{
    collections::BTreeMap,
    fs,
    process::{Child, Command, Stdio},
    time::Duration,
};

const PROCESSES: usize = 16;
const QUICK: [&str; 6] =
    ["--backend", "cpu", "--set", "camera.size=[16,8]", "--set", "shadow.size=16"];

/// A frame takes about 2 ms.
fn start(folder: &Folder, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_gobo"))
        .args(["render", "scene.toml"])
        .args(QUICK)
        .args(arguments)
        .current_dir(&folder.0)
        .env_remove("GOBO_LOG")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Standard output of processes that must all succeed.
fn outputs(children: Vec<Child>) -> Vec<String> {
    let end = |child: Child| {
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{stderr}");
        String::from_utf8(output.stdout).unwrap()
    };
    children.into_iter().map(end).collect()
}

fn contents(folder: &Folder, dir: &str) -> BTreeMap<String, Vec<u8>> {
    let dir = folder.0.join(dir);
    files(&dir).into_iter().map(|name| (name.clone(), fs::read(dir.join(name)).unwrap())).collect()
}

#[test]
fn shards_in_one_folder_lose_nothing() {
    let folder = Folder::new("many-shards");
    for job in 0..6 {
        let out = format!("job{job}");
        let shard = |i| format!("{i}/{PROCESSES}");
        let job = ["-o", &out, "--frames", "0..64", "--skip-existing", "--shard"];
        let children = (0..PROCESSES).map(|i| start(&folder, &[&job[..], &[&shard(i)]].concat()));
        outputs(children.collect());
        assert_eq!(folder.run(&["verify", &out]), "64 frames are whole\n");
        let hidden: Vec<_> = files(&folder.0.join(&out))
            .into_iter()
            .filter(|f| f.contains("/.") || f.starts_with('.'))
            .collect();
        assert!(hidden.is_empty(), "{hidden:?}");
    }
}

#[test]
fn processes_with_the_same_frames_render_each_once() {
    let folder = Folder::new("same-frames");
    let job = |out| ["-o", out, "--frames", "0..64", "--maps", "--skip-existing", "--json"];
    outputs(vec![start(&folder, &job("alone"))]);
    let all = outputs((0..PROCESSES).map(|_| start(&folder, &job("o"))).collect());
    let mut rendered = Vec::new();
    for stdout in &all {
        let lines: Vec<Value> = stdout.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
        assert_eq!(lines.len(), 64, "each process names each frame");
        let own = lines.iter().filter(|line| line["kept"] != true);
        rendered.extend(own.map(|line| line["frame"].as_u64().unwrap()));
    }
    rendered.sort_unstable();
    assert_eq!(rendered, (0..64).collect::<Vec<u64>>());
    assert!(contents(&folder, "o") == contents(&folder, "alone"));
}

#[test]
fn processes_that_overwrite_each_other_all_succeed() {
    let folder = Folder::new("overwrite");
    let job = |out| ["-o", out, "--frames", "0..24", "--maps", "--exr"];
    outputs(vec![start(&folder, &job("alone"))]);
    outputs((0..PROCESSES).map(|_| start(&folder, &job("o"))).collect());
    assert!(contents(&folder, "o") == contents(&folder, "alone"));
}

/// Processes are killed at any moment, also between a claim and a sidecar: the others take over, and nothing
/// is left behind.
#[cfg(unix)]
#[test]
fn killed_processes_lose_nothing() {
    let folder = Folder::new("killed");
    let job = ["-o", "o", "--frames", "0..150", "--maps", "--skip-existing"];
    for round in 0..8 {
        let mut doomed: Vec<_> = (0..4).map(|_| start(&folder, &job)).collect();
        std::thread::sleep(Duration::from_millis(60 + 17 * round));
        for child in &mut doomed {
            child.kill().unwrap();
            child.wait().unwrap();
        }
    }
    let some = fs::read_dir(folder.0.join("o")).unwrap().count();
    assert!((2..300).contains(&some), "{some} entries: the kills were too late or too early");
    outputs((0..4).map(|_| start(&folder, &job)).collect());
    assert_eq!(folder.run(&["verify", "o"]), "150 frames are whole\n");
    let hidden: Vec<_> = files(&folder.0).into_iter().filter(|name| name.contains("/.")).collect();
    assert!(hidden.is_empty(), "{hidden:?}");
}
