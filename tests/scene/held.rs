//! Files that a host holds instead of the file system.
use crate::common::{
    files::Folder,
    splats::{SPLATS, sog, spz},
};
use gobo::glam::Vec3;
use gobo_scene as scene;
use gobo_scene::{HeldFile, Scene, hold_files};
use image::{ImageFormat, RgbaImage};
use std::{
    io::Cursor,
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

const SCENE: &str = "material = [{ name = \"m\", texture = \"images/red.png\" }]\n\
                     [[particles]]\nfile = \"./dots.csv\"\nmaterial = \"m\"\n";

fn held(folder: &str, files: &[(&str, Vec<u8>)]) -> Vec<(PathBuf, HeldFile)> {
    let file = |(name, bytes): &(&str, Vec<u8>)| {
        (Path::new(folder).join(name), HeldFile::of_bytes(bytes.clone()))
    };
    files.iter().map(file).collect()
}

fn files() -> [(&'static str, Vec<u8>); 3] {
    let mut png = Vec::new();
    let red = RgbaImage::from_pixel(2, 3, image::Rgba([255, 0, 0, 255]));
    red.write_to(&mut Cursor::new(&mut png), ImageFormat::Png).unwrap();
    let dots = b"x,y,z,radius\n1,2,3,0.5\n4,5,6,0.25\n".to_vec();
    [("scene.toml", SCENE.into()), ("dots.csv", dots), ("images/red.png", png)]
}

#[test]
fn a_scene_is_read_with_what_it_names() {
    let folder = "held-scene";
    let files = hold_files(held(folder, &files()));
    let path = Path::new(folder).join("scene.toml");
    let Scene { particles, textures, .. } = scene::load(&path).unwrap();
    let read: Vec<_> = particles.iter().map(|dot| (dot.center, dot.radius)).collect();
    assert_eq!(read, [(Vec3::new(1.0, 2.0, 3.0), 0.5), (Vec3::new(4.0, 5.0, 6.0), 0.25)]);
    assert_eq!([textures[0].width, textures[0].height], [2, 3]);
    assert_eq!(scene::files(&path).unwrap().len(), 3);
    drop(files);
    let gone = scene::load(&path).unwrap_err().to_string();
    assert!(gone.starts_with("held-scene/scene.toml: "), "{gone}");
}

#[test]
fn splats_are_those_of_the_file_system() {
    for (name, bytes) in [("ring.spz", spz(3, &SPLATS)), ("ring.sog", sog(&SPLATS))] {
        let folder = Folder::new();
        let stored = scene::load(&folder.write(name, &bytes)).unwrap();
        let _files = hold_files(held("held-splats", &[(name, bytes)]));
        let read = scene::load(&Path::new("held-splats").join(name)).unwrap();
        assert_eq!(read.gaussians, stored.gaussians, "{name}");
        assert_eq!(read.camera, stored.camera, "{name}");
        assert_eq!(read.gaussians.len(), 3);
    }
}

#[test]
fn what_is_not_held_is_named() {
    let [scene, dots, _] = files();
    let _files = hold_files(held("held-part", &[scene, dots]));
    let error = scene::load(Path::new("held-part/scene.toml")).unwrap_err().to_string();
    assert!(error.contains("red.png"), "{error}");
}

/// A file's head tells its format: readers ask only for the ranges that they use, and never beyond the file.
#[test]
fn a_file_is_asked_for_within_its_length() {
    let asked = Arc::new(AtomicU64::new(0));
    let bytes = files()[1].1.clone();
    let (length, seen) = (bytes.len() as u64, asked.clone());
    let file = HeldFile::new(length, move |range| {
        assert!(range.end <= length);
        seen.fetch_max(range.end, Ordering::Relaxed);
        Ok(bytes[range.start as usize..range.end as usize].to_vec())
    });
    let _files = hold_files([(PathBuf::from("held-asked/dots.csv"), file)]);
    assert_eq!(scene::load(Path::new("held-asked/./dots.csv")).unwrap().particles.len(), 2);
    assert_eq!(asked.load(Ordering::Relaxed), length);
}

/// A host that delivers less than announced is an error of that file.
#[test]
fn a_file_that_ends_early_is_an_error() {
    let file = HeldFile::new(1000, |_| Ok(b"x,y,z,radius\n".to_vec()));
    let _files = hold_files([(PathBuf::from("held-short/dots.csv"), file)]);
    let error = scene::load(Path::new("held-short/dots.csv")).unwrap_err().to_string();
    assert!(error.starts_with("held-short/dots.csv: "), "{error}");
}
