//! Defaults of a scene file: camera, light, planes and ground.
use crate::common::files::{Folder, read, read_with};
use gobo::{glam::UVec2, model::Receiver, view};
use gobo_scene as scene;
use gobo_scene::Scene;

#[test]
fn what_is_left_out_is_chosen() {
    let scene = read(
        "[[material]]\nname = \"m\"\n[[shape]]\nkind = \"box\"\nmaterial = \"m\"\n\
        scale = [2, 8, 2]\ntranslation = [5, 0, 0]",
    )
    .unwrap();
    assert_eq!(scene.lights.len(), 1);
    assert_eq!(scene.lights[0].name, "sun");
    assert_eq!(scene.camera.size, UVec2::new(960, 540));
    assert_in_picture(&scene);
    let tall = [("camera.size", "[50, 400]"), ("camera.fov_y", "20")];
    for set in [&tall[..1], &tall[1..], &tall[..]] {
        assert_in_picture(
            &read_with(
                "[[material]]\nname = \"m\"\n[[shape]]\nkind = \"box\"\nmaterial = \"m\"",
                set,
            )
            .unwrap(),
        );
    }
    // An empty file is a scene, too.
    let nothing = read("").unwrap();
    assert!(nothing.bounds().is_empty());
    assert_eq!(gobo_scene::Summary::of(&nothing).bounds, None);
}

fn assert_in_picture(scene: &Scene) {
    let bounds = scene.bounds();
    let camera = gobo::model::View::from_camera(&scene.camera, &bounds);
    for corner in bounds.corners() {
        let clip = camera.clip_from_world() * corner.extend(1.0);
        let ndc = clip.truncate() / clip.w;
        assert!(clip.w > 0.0 && ndc.truncate().abs().max_element() <= 1.0, "{corner} at {ndc}");
    }
}

#[test]
fn particles_alone_are_a_scene() {
    let folder = Folder::new();
    let path = folder.write("dots.csv", "x,y,z,radius\n0,1,0,0.1\n1,1,0,0.2\n");
    let set = [("camera.size", "[64, 32]"), ("light.sun.size", "32"), ("shadow.size", "16")]
        .map(|(key, value)| (key.to_owned(), value.to_owned()));
    let scene = scene::load_with(&path, &set).unwrap();
    assert_eq!(scene.particles.len(), 2);
    assert_eq!(scene.particles[1].radius, 0.2);
    assert_eq!(scene.camera.size, UVec2::new(64, 32));
    assert_eq!((scene.lights[0].size, scene.shadow.size), (Some(32), 16));
    assert_eq!(scene.shadow.receiver, Receiver::Curve);
    let set = [("shadow.receiver".to_owned(), "nearest".to_owned())];
    assert_eq!(scene::load_with(&path, &set).unwrap().shadow.receiver, Receiver::Nearest);
    // A ground under them, to receive the shadow.
    let ground = scene.triangles.last().unwrap();
    assert!(scene.materials[ground.material as usize].transfer.is_opaque());
    assert!(ground.positions.iter().all(|p| p.y < 0.9 && p.y > 0.5), "{ground:?}");
}

/// One plane given, the other chosen: they are in order even if the scene ends before `near`.
#[test]
fn a_chosen_far_plane_is_behind_the_given_near() {
    let shape = "[[material]]\nname = \"m\"\n[[shape]]\nkind = \"box\"\nmaterial = \"m\"\n";
    for light in [
        "kind = \"directional\"\ndirection = [0, -1, 0]",
        "kind = \"point\"\nposition = [0, 2, 0]",
        "kind = \"spot\"\nposition = [0, 2, 0]\ndirection = [0, 1, 0]",
    ] {
        for planes in ["", "near = 500", "far = 1e-4", "near = 1e7"] {
            let scene = read(&format!("{shape}[[light]]\n{light}\n{planes}\n")).unwrap();
            for view in view::shadow_views(&scene) {
                assert!(view.near < view.far, "{light}, {planes}: {} to {}", view.near, view.far);
            }
        }
    }
}
