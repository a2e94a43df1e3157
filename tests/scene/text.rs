//! Scenes from text, as hosts make them, and a camera for them.
use crate::common::files::Folder;
use gobo::{
    Particle,
    glam::{UVec2, Vec3, Vec4},
    model::View,
};
use gobo_scene as scene;
use gobo_scene::{LoadOptions, Scene, SceneError};
use std::path::Path;

const TEXT: &str = r#"
[shadow]
size = 256
[[light]]
kind = "spot"
position = [0, 4, 0]
direction = [0, -1, 0]
angle = 40
[[material]]
name = "smoke"
tint = [0.5, 0.6, 0.7, 0.2]
[[particles]]
file = "smoke.csv"
material = "smoke"
"#;

#[test]
fn text_is_a_scene_file() {
    let folder = Folder::new();
    let rows = folder.write("smoke.csv", "x,y,z,radius\n0,1,0,0.5\n1,nan,0,0.5\n");
    let file = folder.write("scene.toml", TEXT);
    let of_file = scene::load(&file).unwrap();
    // The file whose name locates the others need not exist.
    let path = rows.with_file_name("nowhere.toml");
    let of_text = scene::load_text(TEXT, &path, &LoadOptions::default()).unwrap();
    assert_eq!(format!("{of_text:?}"), format!("{of_file:?}"));
    assert_eq!(of_text.particles.len(), 1);
    let mut options = LoadOptions::default();
    options.set = vec![("shadow.size".to_owned(), "64".to_owned())];
    assert_eq!(scene::load_text(TEXT, &path, &options).unwrap().shadow.size, 64);
}

#[test]
fn text_that_is_wrong_names_its_line() {
    let text = "[shadow]\nsise = 3\n";
    let error = scene::load_text(text, Path::new("host"), &LoadOptions::default()).unwrap_err();
    let SceneError::Document { path, line, .. } = &error else { panic!("{error}") };
    assert_eq!((path.as_path(), *line), (Path::new("host"), 2));
    let long = " ".repeat((1 << 24) + 1);
    let error = scene::load_text(&long, Path::new("host"), &LoadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("at most"), "{error}");
}

#[test]
fn the_usual_camera_sees_everything_and_little_else() {
    let places = [Vec3::new(-3.0, 0.5, 1.0), Vec3::new(4.0, 2.0, -2.0), Vec3::new(0.0, 7.0, 0.0)];
    let particles = places.map(|place| Particle::new(place, 0.2)).to_vec();
    let mut scene = Scene { particles, ..gobo_scene::empty_scene() };
    for size in [UVec2::new(640, 360), UVec2::new(200, 500)] {
        scene.camera = gobo_scene::usual_camera(&scene, size);
        assert_eq!(scene.camera.size, size);
        let clip = View::from_camera(&scene.camera, &scene.bounds()).clip_from_world();
        let seen = places.map(|place| clip * place.extend(1.0));
        let farthest = seen.map(|at: Vec4| (at.truncate() / at.w).truncate().abs().max_element());
        assert!(seen.iter().all(|at| at.w > 0.0), "{seen:?}");
        let farthest = farthest.into_iter().fold(0.0, f32::max);
        assert!((0.6..0.8).contains(&farthest), "{farthest}");
    }
}

#[test]
fn particles_tell_what_is_wrong_with_them() {
    let good = Particle::new([0.0; 3], 0.1);
    let rgba = |r, a| Vec4::new(r, 1.0, 1.0, a);
    let of = |particle: Particle| particle.problem(1.0);
    assert_eq!(of(good), None);
    assert_eq!(of(Particle { rotation: f32::NAN, ..good }), Some("not finite"));
    assert_eq!(of(Particle { center: Vec3::splat(2e7), ..good }), Some("too far"));
    assert_eq!(of(Particle { radius: 0.0, ..good }), Some("radius not positive"));
    assert_eq!(of(Particle { color: rgba(1.5, 1.0), ..good }), Some("colour out of range"));
    assert_eq!(Particle { color: rgba(1.5, 1.0), ..good }.problem(16.0), None);
    assert_eq!(of(Particle { color: rgba(1.0, 1.5), ..good }), Some("alpha out of range"));
}
