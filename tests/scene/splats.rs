//! `[[splats]]`: placing, shadows, opacity, keys, and a single file of splats as a scene.
use crate::common::{
    files::{Folder, read},
    splats::{SPLATS, bare, gltf, ply, sog, spz},
};
use gobo::{
    glam::{Quat, Vec3},
    model::{GaussianOpacity, Receiver, Shape},
};
use gobo_scene as scene;
use gobo_scene::{Scene, SceneError};

const CLOUD: &str = "generate = { kind = 'cloud', count = 50, seed = 3 }\n";

fn with_file(table: &str) -> Result<Scene, SceneError> {
    let folder = Folder::new();
    folder.write("a.ply", ply("binary_little_endian", &SPLATS, 0));
    scene::load(&folder.write("scene.toml", format!("[[splats]]\nfile = 'a.ply'\n{table}")))
}

/// Line and message of a refusal.
fn refused(result: Result<Scene, SceneError>) -> (usize, String) {
    match result {
        Err(SceneError::Document { line, message, help, .. }) => {
            assert!(help.is_some(), "{message}");
            (line, message)
        }
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("read without an error"),
    }
}

#[test]
fn splats_are_placed_by_their_table() {
    let scene =
        with_file("translation = [1, 2, 3]\nrotation = [0, 0, 90]\nscale = [2, 2, 2]\n").unwrap();
    let turn = Quat::from_rotation_z(90f32.to_radians());
    assert_eq!(scene.gaussians.len(), 3);
    for (i, (placed, stored)) in scene.gaussians.iter().zip(SPLATS).enumerate() {
        let center = Vec3::from_array(stored.center.map(|x| x as f32));
        let wanted = Vec3::new(1.0, 2.0, 3.0) + turn * center * 2.0;
        assert!((placed.center - wanted).length() < 1e-5, "{}, wanted {wanted}", placed.center);
        let mut sigma = placed.sigma.to_array();
        let mut doubled = stored.sigma.map(|s| 2.0 * s as f32);
        sigma.sort_by(f32::total_cmp);
        doubled.sort_by(f32::total_cmp);
        assert!(sigma.iter().zip(doubled).all(|(a, b)| (a / b - 1.0).abs() < 1e-5), "{sigma:?}");
        assert_eq!(placed.id, i as u32);
    }
    let summary = gobo_scene::Summary::of(&scene);
    assert_eq!((summary.splats, summary.particles), (3, 0));
}

#[test]
fn cast_and_opacity_choose_the_material() {
    let material = |table: &str| {
        let scene = with_file(table).unwrap();
        scene.materials[scene.gaussians[0].material as usize].clone()
    };
    let usual = material("");
    assert_eq!(usual.shape, Shape::Gaussian);
    assert!(usual.neutral && usual.casts && usual.gaussian == GaussianOpacity::Splat);
    assert!(!material("cast = 'own'").neutral);
    assert!(!material("cast = 'none'").casts);
    let medium = material("opacity = 'medium'\ndensity = 2.5");
    assert_eq!(medium.gaussian, GaussianOpacity::Medium { density: 2.5 });
    // A named material gives tint and transfer, and stays unchanged for particles.
    let scene = with_file(
        "material = 'tea'\n[[material]]\nname = 'tea'\ntransfer = 'smoke'\n\
        tint = [1, 0.5, 0, 0.5]\n",
    )
    .unwrap();
    assert_eq!((scene.materials.len(), scene.materials[0].shape), (2, Shape::Disc));
    assert_eq!(scene.materials[1].tint.to_array(), [1.0, 0.5, 0.0, 0.5]);
}

#[test]
fn errors_name_line_and_key() {
    for (table, line, words) in [
        ("opacity = 'medium'\n", 3, "needs a density"),
        ("density = 2\n", 3, "needs opacity"),
        ("opacity = 'splat'\ndensity = 2\n", 4, "no density"),
        ("opacity = 'medium'\ndensity = 0\n", 4, "density is 0"),
        ("cast = 'coloured'\n", 3, "coloured"),
        ("materiel = 'm'\n", 3, "materiel"),
        ("material = 'm'\n", 3, "no material is named `m`"),
        (CLOUD, 2, "either a file or generate"),
        ("scale = [1, 0, 1]\n", 3, "scale has a 0"),
        ("translation = [1e9, 0, 0]\n", 3, "translation"),
        (
            "name = 'a'\n[[splats]]\nname = 'a'\ngenerate = { kind = 'cloud', count = 1 }\n",
            5,
            "a second splats",
        ),
        (
            "[[animate]]\ntarget = 'splats.b.scale'\ntimes = [0]\nvalues = [[1, 1, 1]]\n",
            4,
            "no splats `b`",
        ),
    ] {
        let (at, message) = refused(with_file(table));
        assert!(message.contains(words), "{table}: {message}");
        assert_eq!(at, line, "{table}: {message}");
    }
    let (line, message) = refused(read("[[splats]]\nfile = 'none.spz'\n"));
    assert!(line == 2 && message.contains("none.spz"), "{message}");
    let (line, message) = refused(read(
        "[[splats]]\ngenerate = { kind = 'dust', count = 17000000, min = [0,0,0], max = [1,1,1] }\n",
    ));
    assert!(line == 2 && message.contains("17000000 splats"), "{message}");
}

#[test]
fn generated_splats_are_the_same_each_time() {
    let scene = |seed: u32| {
        read(&format!("[[splats]]\ngenerate = {{ kind = 'cloud', count = 50, seed = {seed} }}\n"))
            .unwrap()
            .gaussians
    };
    assert_eq!(scene(3), scene(3));
    assert_ne!(scene(3)[0].center, scene(4)[0].center);
    let aspects =
        scene(3).iter().map(|g| g.sigma.max_element() / g.sigma.min_element()).fold(0.0, f32::max);
    assert!(aspects > 2.0, "all are round: {aspects}");
}

#[test]
fn keys_move_splats() {
    let text = format!(
        "[[splats]]\nname = 'a'\n{CLOUD}[[animate]]\ntarget = 'splats.a.translation'\ntimes = [0, 1]\n\
         values = [[0, 0, 0], [0, 4, 0]]\n[[animate]]\ntarget = 'splats.0.scale'\ntimes = [0, 1]\n\
         values = [[1, 1, 1], [2, 2, 2]]\n"
    );
    let mut scene = read(&text).unwrap();
    let before = scene.gaussians.clone();
    scene.set_time(1.0);
    for (moved, before) in scene.gaussians.iter().zip(&before) {
        let wanted = before.center * 2.0 + Vec3::Y * 4.0;
        assert!((moved.center - wanted).length() < 1e-4, "{}, wanted {wanted}", moved.center);
        assert!((moved.sigma.max_element() / before.sigma.max_element() - 2.0).abs() < 1e-4);
    }
    scene.set_time(0.0);
    assert!(
        scene.gaussians.iter().zip(&before).all(|(a, b)| (a.center - b.center).length() < 1e-5)
    );
    // Out of the world and back.
    let far = text.replace("[0, 4, 0]", "[9e6, 9e6, 9e6]").replace("[2, 2, 2]", "[1e7, 1e7, 1e7]");
    let mut scene = read(&far).unwrap();
    scene.set_time(1.0);
    assert!(
        scene.skipped.get("gaussian moved too far").is_some_and(|&count| count > 0),
        "{:?}",
        scene.skipped
    );
}

#[test]
fn a_file_alone_is_framed_on_a_ground() {
    let files = [
        ("a.ply", ply("ascii", &SPLATS, 0), true),
        ("b.splat", bare(&SPLATS), true),
        ("c.spz", spz(4, &SPLATS), false),
        ("d.sog", sog(&SPLATS), true),
        ("e.gltf", gltf(&SPLATS, false).into_bytes(), false),
        ("no.kind", spz(2, &SPLATS), false),
    ];
    for (name, bytes, is_turned) in files {
        let folder = Folder::new();
        let scene =
            scene::load(&folder.write(name, bytes)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(scene.gaussians.len(), 3, "{name}");
        assert_eq!(scene.shadow.receiver, Receiver::Curve, "{name}");
        assert!(!scene.triangles.is_empty() && scene.lights.len() == 1, "{name}: ground and sun");
        let material = &scene.materials[scene.gaussians[0].material as usize];
        assert!(material.neutral && material.shape == Shape::Gaussian, "{name}");
        let said = scene.notes.iter().any(|note| note.contains("turned by 180 degrees"));
        assert_eq!(said, is_turned, "{name}");
        let highest = scene.gaussians.iter().map(|g| g.center.y).fold(f32::MIN, f32::max);
        let moved = if name == "e.gltf" { 1.0 } else { 0.0 };
        let wanted = if is_turned { 0.5 } else { 2.0 + moved };
        assert!((highest - wanted).abs() < 0.01, "{name}: {highest}");
        assert!(scene.camera.target.cmpge(scene.bounds().min).all(), "{name}");
    }
}

#[test]
fn the_other_tables_name_the_right_one() {
    let folder = Folder::new();
    folder.write("a.ply", ply("ascii", &SPLATS, 0));
    folder.write("b.gltf", gltf(&SPLATS, false));
    let text = "[[material]]\nname = 'm'\n[[particles]]\nfile = 'a.ply'\nmaterial = 'm'\n";
    let (line, message) = refused(scene::load(&folder.write("p.toml", text)));
    assert!(line == 4 && message.contains("splats"), "{message}");
    let scene = scene::load(&folder.write("m.toml", "[[mesh]]\nfile = 'b.gltf'\n")).unwrap();
    assert!(
        scene.gaussians.is_empty() && scene.notes.iter().any(|note| note.contains("[[splats]]"))
    );
    assert_eq!(
        scene::files(&folder.write("s.toml", "[[splats]]\nfile = 'a.ply'\n")).unwrap().len(),
        2
    );
}

/// As a single file, a medium that hardly shows is made denser, to an optical depth of 4 from top to bottom,
/// with a note; in a table it keeps its density.
#[test]
fn a_thin_medium_alone_is_made_to_show() {
    let columns = "x y z albedo_0 albedo_1 albedo_2 sigma_t_0 scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 \
        rot_3";
    let properties: String =
        columns.split(' ').map(|name| format!("property float {name}\n")).collect();
    let log = 0.1f64.ln();
    let file = |integral: f64| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 1\n{properties}end_header\n\
             0 0 0 0.9 0.9 0.9 {integral} {log} {log} {log} 1 0 0 0\n"
        )
    };
    let density = |scene: &Scene| match scene.materials[0].gaussian {
        GaussianOpacity::Medium { density } => f64::from(density),
        other => panic!("{other:?}"),
    };
    let volume = std::f64::consts::TAU.powf(1.5) * 1e-3;
    let folder = Folder::new();
    for (integral, is_denser) in [(0.002, true), (20.0, false)] {
        let own = integral / volume;
        let alone = scene::load(&folder.write("a.ply", file(integral))).unwrap();
        let table = scene::load(&folder.write("t.toml", "[[splats]]\nfile = 'a.ply'\n")).unwrap();
        assert!((density(&table) / own - 1.0).abs() < 1e-5);
        // Mean of a Gaussian's shadow along y: its integral over 4 pi times the product of its deviations.
        let thickness = density(&alone) * volume / (2.0 * std::f64::consts::TAU * 0.01);
        let wanted = if is_denser {
            4.0
        } else {
            density(&table) * volume / (2.0 * std::f64::consts::TAU * 0.01)
        };
        assert!((thickness / wanted - 1.0).abs() < 1e-3, "{thickness} instead of {wanted}");
        assert_eq!(alone.notes.iter().any(|note| note.contains("times as dense")), is_denser);
    }
}
