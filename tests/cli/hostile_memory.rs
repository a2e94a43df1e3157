//! Inputs for which the host lacks memory.
use super::{
    commands::{Folder, files},
    hostile::QUICK,
};
use std::{fs, process::Command};

/// Runs with a memory limit `most` [KiB], and returns the status and standard error.
#[cfg(target_os = "linux")]
fn with_memory(folder: &Folder, most: u32, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new("sh");
    let limit = format!("ulimit -v {most}; exec \"$0\" \"$@\"");
    command.current_dir(&folder.0).args(["-c", &limit]).arg(env!("CARGO_BIN_EXE_gobo"));
    let output = command.args(arguments).output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// A file of zeros after `head`, which takes no space on the disk.
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

/// Each line of such a header becomes a string.
#[cfg(target_os = "linux")]
#[test]
fn radiance_headers_take_no_more_than_their_bytes() {
    let folder = Folder::new("hdr");
    let header = "A=1\n".repeat(10 << 20);
    let image = format!("#?RADIANCE\n{header}\n-Y 2 +X 4\n{}", "a".repeat(32));
    fs::write(folder.0.join("long.hdr"), image).unwrap();
    fs::write(folder.0.join("sky.toml"), "[environment]\nfile = \"long.hdr\"\n").unwrap();
    let texture = "[[material]]\nname = \"m\"\ntexture = \"long.hdr\"\n";
    fs::write(folder.0.join("texture.toml"), texture).unwrap();
    for name in ["sky.toml", "texture.toml"] {
        let (status, told) = with_memory(&folder, 300_000, &["check", name]);
        assert_eq!(status, Some(2), "{told}");
        assert!(told.contains("its header has more than 65536 bytes"), "{told}");
    }
    // A short header, before many texels.
    let image = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 128 +X 256\n".to_vec();
    let image = [image, [100, 120, 140, 128].repeat(128 * 256)].concat();
    fs::write(folder.0.join("long.hdr"), image).unwrap();
    folder.run(&["check", "sky.toml"]);
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

/// The CPU reference needs many times as much memory for a pixel of shadow masks as for one of the picture.
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

/// The CPU reference reads the scene's images in place, without copies.
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

/// Each table is within the limits, but not all together: the sum is known before anything is allocated. Each
/// of these scenes would take over half a GB up to the table that is too much.
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
