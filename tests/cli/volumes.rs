//! Sequences of `OpenVDB` files on the command line.
use super::commands::Folder;
use crate::common::vdb::{Format, VdbGrid, file, placed};
use gobo::glam::{DVec3, IVec3};
use std::fs;

const SCENE: &str = "[camera]\neye = [0, 3, 9]\ntarget = [0, 1, 0]\nsize = [48, 32]\n[shadow]\nsize = 64\n\
    [[material]]\nname = 'ground'\ntransfer = 'opaque'\n\
    [[shape]]\nkind = 'plane'\nmaterial = 'ground'\nscale = [20, 1, 20]\n\
    [[volume]]\nfile = 'smoke_%04d.vdb'\nframes = [7, 9]\n";

fn cube(value: f32) -> Vec<u8> {
    let transform = placed(DVec3::splat(0.2), DVec3::new(-1.0, 0.5, -1.0));
    let mut grid = VdbGrid { transform, ..VdbGrid::default() };
    for i in 0..10 * 10 * 10 {
        grid.set(IVec3::new(i % 10, i / 10 % 10, i / 100), value);
    }
    file(Format::default(), &[grid])
}

/// A frame shows the file with its number, alone and among others; a damaged file is counted.
#[test]
fn a_sequence_of_volumes_is_rendered_frame_by_frame() {
    let folder = Folder::new("volumes");
    fs::write(folder.0.join("smoke.toml"), SCENE).unwrap();
    for (number, value) in [(7, 0.1), (8, 0.6), (9, 3.0)] {
        fs::write(folder.0.join(format!("smoke_{number:04}.vdb")), cube(value)).unwrap();
    }
    let by = ["render", "smoke.toml", "--backend", "cpu"];
    folder.run(&[&by[..], &["--frames", "0..4", "-o", "all"]].concat());
    folder.run(&[&by[..], &["--frame", "2", "-o", "one"]].concat());
    let picture = |folder_name: &str, frame: u32| {
        fs::read(folder.0.join(folder_name).join(format!("frame_{frame:04}.png"))).unwrap()
    };
    assert!(picture("all", 0) != picture("all", 1) && picture("all", 1) != picture("all", 2));
    assert!(picture("all", 2) == picture("one", 2), "alone and among others");
    assert!(picture("all", 2) == picture("all", 3), "the last file stays");
    fs::write(folder.0.join("smoke_0008.vdb"), "PK").unwrap();
    let lines = folder.run(&[&by[..], &["--frames", "0..3", "-o", "bad", "--json"]].concat());
    let lines: Vec<&str> = lines.lines().collect();
    let is_counted = |line: &str| line.contains("file of a volume's frame not read");
    assert_eq!(lines.iter().map(|line| is_counted(line)).collect::<Vec<_>>(), [false, true, false]);
}
