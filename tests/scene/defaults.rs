//! Defaults of a scene file: camera, light, planes and ground.
use crate::common::files::{Folder, read, read_with};
use gobo::{
    glam::{UVec2, Vec3},
    model::{Receiver, Triangle, View},
    view,
};
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
    assert_eq!((scene.shadow.receiver, scene.shadow.nodes), (Receiver::Curve, 8));
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
    let camera = View::from_camera(&scene.camera, &bounds);
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

/// Largest share of the picture's width or height that triangles fill.
fn filled(scene: &Scene, of: impl Fn(&Triangle) -> bool) -> f32 {
    let camera = scene::usual_camera(scene, UVec2::new(960, 540));
    let seen = View::from_camera(&camera, &scene.bounds());
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for corner in scene.triangles.iter().filter(|t| of(t)).flat_map(|t| t.positions) {
        let clip = seen.clip_from_world() * corner.extend(1.0);
        let at = clip.truncate() / clip.w;
        (low, high) = (low.min(at), high.max(at));
    }
    assert!(low.truncate().min_element() >= -1.0 && high.truncate().max_element() <= 1.0);
    (high - low).truncate().max_element() / 2.0
}

/// A chair on a field.
#[test]
fn what_stands_on_a_large_ground_is_framed() {
    let field = |edge: f32, at: &str| {
        read(&format!(
            "[[material]]\nname = 'm'\ntransfer = 'opaque'\n[[shape]]\nkind = 'plane'\nmaterial = 'm'\nscale = [{edge}, 1, {edge}]\n\
             [[shape]]\nkind = 'box'\nmaterial = 'm'\ntranslation = {at}\n"
        ))
        .unwrap()
    };
    let stands = |triangle: &Triangle| {
        triangle.positions.iter().any(|p| p.y > 0.1) || triangle.normals.iter().any(|n| n.y < 0.9)
    };
    for edge in [200.0, 20.0] {
        let share = filled(&field(edge, "[3, 0.5, -2]"), stands);
        assert!((0.7..0.8).contains(&share), "{edge}: {share}");
    }
    // A table on a carpet: both are in the picture.
    assert!(filled(&field(3.0, "[0, 0.5, 0]"), |_| true) > 0.7);
}

/// A sign, edge-on to the usual side, and turned to the other one: its front is seen.
#[test]
fn signs_are_seen_from_their_front() {
    for turned in [0.0_f32, 34.5, 145.5, 90.0, 250.0] {
        let mut sign = read(&format!(
            "[[material]]\nname = 'm'\ntransfer = 'opaque'\n[[shape]]\nkind = 'box'\nmaterial = 'm'\n\
             scale = [2, 1.2, 0.05]\nrotation = [0, {turned}, 0]\n"
        ))
        .unwrap();
        let normal = Vec3::new(turned.to_radians().sin(), 0.0, turned.to_radians().cos());
        let off = |scene: &Scene| {
            let camera = scene::usual_camera(scene, UVec2::new(960, 540));
            (camera.eye - camera.target).normalize().dot(normal)
        };
        assert!(off(&sign).abs() > 0.85, "{turned}: {}", off(&sign));
        // With one face alone that is in front.
        sign.triangles.retain(|triangle| triangle.normals[0].dot(normal) > 0.9);
        assert_eq!(sign.triangles.len(), 2);
        assert!(off(&sign) > 0.85, "{turned}: {}", off(&sign));
    }
}

/// A room of walls that look inward, with a block in it, is seen from within, by a lamp; the same walls
/// looking outward are a box.
#[test]
fn closed_rooms_are_seen_from_within() {
    let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|i: u32| {
        [4 * (i & 1), 3 * (i >> 1 & 1), 5 * (i >> 2)].map(|at| at.to_string()).join(" ")
    });
    let faces =
        [[1, 5, 6, 2], [3, 4, 8, 7], [1, 2, 4, 3], [5, 7, 8, 6], [1, 3, 7, 5], [2, 6, 8, 4]];
    let model = |inward: bool| {
        let mut text: String = corners.iter().map(|corner| format!("v {corner}\n")).collect();
        for mut face in faces {
            if !inward {
                face.reverse();
            }
            text += &format!("f {}\n", face.map(|i| i.to_string()).join(" "));
        }
        text
    };
    let folder = Folder::new();
    for inward in [true, false] {
        let scene = scene::load(&folder.write("room.obj", model(inward))).unwrap();
        let eye = scene.camera.eye + scene.origin;
        let is_inside = eye.cmpgt(Vec3::ZERO).all() && eye.cmplt(Vec3::new(4.0, 3.0, 5.0)).all();
        let is_lamp = matches!(scene.lights[0].kind, gobo::LightKind::Point { .. });
        assert_eq!((is_inside, is_lamp), (inward, inward), "{eye}");
    }
}

/// No other ground is laid under a file that has one, whose far end would take the near plane past what
/// stands on it.
#[test]
fn a_field_is_ground_enough() {
    let strip = "o strip\nv -250 0 10\nv 250 0 10\nv 250 0 -10\nv -250 0 -10\nf 1 2 3 4\n";
    let sign = "o sign\nv -1 0 0\nv 1 0 0\nv 1 1.8 0\nv -1 1.8 0\nf 5 6 7 8\n";
    let folder = Folder::new();
    let scene = scene::load(&folder.write("field.obj", [strip, sign].concat())).unwrap();
    assert_eq!(scene.triangles.len(), 4);
    assert!((scene.camera.eye - scene.camera.target).length() < 10.0);
}
