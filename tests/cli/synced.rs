//! Files are on the disk before they have their name.
use super::commands::Folder;
use std::{fs, path::Path, process::Command};

/// Notes the path of each file that is synced, and syncs nothing.
const NOTES: &str = r#"
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>
extern "C" int fsync(int file) {
    char link[64], path[4096] = {0};
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    readlink(link, path, sizeof path - 1);
    FILE *notes = fopen(getenv("NOTES"), "a");
    fprintf(notes, "%s\n", path);
    return fclose(notes);
}
"#;

/// Paths from the folder that a job syncs, in order; random parts of temporary names are left out.
fn synced(folder: &Folder, out: &str, more: &[&str]) -> Vec<String> {
    let notes = folder.0.join("notes");
    let _ = fs::remove_file(&notes);
    let job = ["render", "scene.toml", "--backend", "cpu", "--maps", "--set", "camera.size=[16,8]"];
    let output = Command::new(env!("CARGO_BIN_EXE_gobo"))
        .args([&job[..], &["-o", out], more].concat())
        .current_dir(&folder.0)
        .env("NOTES", &notes)
        .env("LD_PRELOAD", folder.0.join("notes.so"))
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let root = folder.0.canonicalize().unwrap();
    let text = fs::read_to_string(notes).unwrap_or_default();
    let lines = text.lines().map(|line| {
        let path = Path::new(line).strip_prefix(&root).unwrap().to_str().unwrap();
        path.strip_suffix(".tmp")
            .and_then(|path| path.rsplit_once('.'))
            .map_or(path, |(name, _)| name)
            .to_owned()
    });
    lines.collect()
}

#[test]
fn a_frame_is_on_the_disk_before_its_sidecar_says_so() {
    let folder = Folder::new("synced");
    fs::write(folder.0.join("notes.cpp"), NOTES).unwrap();
    let compiler = std::env::var("CXX").unwrap_or_else(|_| "c++".to_owned());
    let arguments = ["-shared", "-fPIC", "-o", "notes.so", "notes.cpp"];
    let made = Command::new(compiler).args(arguments).current_dir(&folder.0).status().unwrap();
    assert!(made.success());
    assert_eq!(synced(&folder, "o", &[]), [""; 0], "without sidecars nobody waits for the disk");
    let order = synced(&folder, "s", &["--skip-existing", "--exr"]);
    let map = "s/maps/frame_0000/.key_light.0.filter.npy";
    assert!(order.contains(&map.to_owned()), "{order:?}");
    let last = [
        "s/.frame_0000.exr",
        "s/.frame_0000.png",
        "s/maps/frame_0000",
        "s/maps",
        "s",
        "s/.frame_0000.json",
        "s",
    ];
    assert_eq!(order[order.len() - last.len()..], last);
}
