//! `--preview`: files that it refuses to overwrite, and videos.
use super::commands::{Folder, files};
use std::{fs, path::Path, process::Command};

const JOB: [&str; 8] = [
    "render",
    "scene.toml",
    "--backend",
    "cpu",
    "--frames=0..3",
    "--set",
    "camera.size=[15,8]",
    "--preview",
];

#[test]
fn only_previews_are_overwritten() {
    let folder = Folder::new("preview-free");
    let scene = fs::read(folder.0.join("scene.toml")).unwrap();
    image::RgbImage::new(2, 2).save(folder.0.join("photo.png")).unwrap();
    let photo = fs::read(folder.0.join("photo.png")).unwrap();
    fs::create_dir(folder.0.join("folder.png")).unwrap();
    // The mark alone, in a text file, makes no preview.
    fs::write(folder.0.join("text.png"), "made by gobo --preview").unwrap();
    for name in ["scene.toml", "photo.png", "folder.png", "text.png", "p.gif", "p", ".."] {
        let error = folder.fail(&[&JOB[..], &[name]].concat(), 2);
        assert!(error.contains(name) && error.contains("help: "), "{error}");
    }
    assert_eq!(fs::read(folder.0.join("scene.toml")).unwrap(), scene);
    assert_eq!(fs::read(folder.0.join("photo.png")).unwrap(), photo);
    // Names of frames, whether they exist or not.
    for name in ["out/frame_0001.png", "./out/../out/frame_0009.png", "out/FRAME_0001.png"] {
        let error = folder.fail(&[&JOB[..], &[name]].concat(), 2);
        assert!(error.contains("the name of a frame"), "{error}");
    }
    assert!(!files(&folder.0).iter().any(|name| name.starts_with("out/")));
    for _ in 0..2 {
        folder.run(&[&JOB[..], &["p.png"]].concat());
    }
    let hidden = |name: &String| name.contains("/.") || name.starts_with('.');
    assert!(!files(&folder.0).iter().any(hidden));
}

/// Puts a program named `ffmpeg` beside the scene.
#[cfg(unix)]
fn ffmpeg(folder: &Folder, script: &str) {
    use std::os::unix::fs::PermissionsExt as _;
    let path = folder.0.join("bin/ffmpeg");
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
}

/// Status and standard error of a job with a video, with only these programs.
fn video(folder: &Folder, path: &Path) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_gobo"))
        .args([&JOB[..], &["p.mp4"]].concat())
        .current_dir(&folder.0)
        .env("PATH", path)
        .output()
        .unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_video_without_ffmpeg_is_refused() {
    let folder = Folder::new("no-ffmpeg");
    let (status, told) = video(&folder, &folder.0.join("nowhere"));
    assert_eq!(status, Some(2), "{told}");
    assert!(
        told.contains("p.mp4: ffmpeg") && told.contains("help: install it, or name a .png"),
        "{told}"
    );
    assert_eq!(files(&folder.0), ["scene.toml"]);
}

#[cfg(unix)]
#[test]
fn a_video_is_what_ffmpeg_makes_of_all_frames() {
    let folder = Folder::new("ffmpeg");
    let path = |folder: &Folder| folder.0.join("bin");
    // Writes the head of an MP4, then its input, and its arguments as the tail.
    let writer =
        "for out; do :; done\n{ printf '....ftyp'; /bin/cat; printf '%s ' \"$@\"; } >\"$out\"";
    ffmpeg(&folder, writer);
    for _ in 0..2 {
        let (status, told) = video(&folder, &path(&folder));
        assert_eq!(status, Some(0), "{told}");
    }
    let bytes = fs::read(folder.0.join("p.mp4")).unwrap();
    let (head, rest) = bytes.split_at(8);
    let (pixels, tail) = rest.split_at(3 * 15 * 8 * 3);
    assert_eq!(head, b"....ftyp");
    for (frame, pixels) in pixels.chunks(15 * 8 * 3).enumerate() {
        let picture = image::open(folder.0.join(format!("out/frame_{frame:04}.png"))).unwrap();
        assert!(picture.into_rgb8().into_raw() == pixels, "{frame}");
    }
    let tail = String::from_utf8(tail.to_vec()).unwrap();
    for option in ["-video_size 15x8 ", "-framerate 24 ", "-f mp4 "] {
        assert!(tail.contains(option), "{tail}");
    }
    // A program that fails at once or at the end leaves the earlier video.
    for script in ["exit 7", "/bin/cat >/dev/null; exit 7"] {
        ffmpeg(&folder, script);
        let (status, told) = video(&folder, &path(&folder));
        assert_eq!(status, Some(1), "{told}");
        assert!(told.contains("p.mp4: ffmpeg"), "{told}");
        assert_eq!(fs::read(folder.0.join("p.mp4")).unwrap(), bytes);
    }
    // A foreign video.
    fs::write(folder.0.join("p.mp4"), "....ftyp of a camera").unwrap();
    let (status, told) = video(&folder, &path(&folder));
    assert_eq!(status, Some(2), "{told}");
    assert!(!files(&folder.0).iter().any(|name| name.contains("/.") || name.starts_with('.')));
}
