//! Strands of a scene file: from PLY and CSV, and generated; and refused files.
use crate::common::files::{Folder, read};
use gobo::{glam::Vec3, model::Shape};
use gobo_scene as scene;
use gobo_scene::{Scene, SceneError};

const HAIR: &str = "[[material]]\nname = \"hair\"\ntint = [0.5, 0.4, 0.3, 0.9]\n";

fn of_file(name: &str, text: &str, keys: &str) -> Scene {
    let folder = Folder::new();
    folder.write(name, text);
    let toml = format!("{HAIR}[[strands]]\nfile = \"{name}\"\nmaterial = \"hair\"\n{keys}");
    scene::load(&folder.write("scene.toml", toml)).unwrap()
}

fn refused(toml: &str) -> String {
    match read(toml) {
        Err(SceneError::Document { message, help, .. }) => {
            format!("{message}; {}", help.expect("a remedy"))
        }
        other => panic!("{:?}", other.map(|_| ())),
    }
}

#[test]
fn rows_of_one_id_are_a_strand() {
    let csv = "x,y,z,radius,alpha,id\n0,0,0,0.1,1,7\n1,0,0,0.05,1,7\n2,0,0,0,0.5,7\n0,1,0,0.1,1,8\n\
        0,2,0,0.1,1,8\n";
    let scene = of_file("hair.csv", csv, "translation = [0, 0, 5]\nscale = [2, 2, 2]\n");
    let [long, short] = &scene.strands[..] else { panic!("two strands") };
    assert_eq!((long.vertices.len(), long.id, short.vertices.len(), short.id), (3, 7, 2, 8));
    assert_eq!(long.vertices[1].position, Vec3::new(2.0, 0.0, 5.0));
    let radii = long.vertices.iter().map(|vertex| vertex.radius).collect::<Vec<_>>();
    assert!((radii[0] - 0.2).abs() < 1e-6 && radii[2] == 0.0, "{radii:?}");
    assert_eq!(long.vertices[2].color.w, 0.5);
    assert_eq!(scene.materials[long.material as usize].shape, Shape::Capsule);
    assert!(gobo_scene::Summary::of(&scene).to_string().contains("strands    2\n"));
}

#[test]
fn a_file_without_ids_is_one_trail_and_bad_rows_are_counted() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
               property float z\nend_header\n\
               0 0 0\n0 nan 0\n1 0 0\n2 1 0\n";
    let scene = of_file("trail.ply", ply, "radius = 0.25\n");
    assert_eq!(scene.strands.len(), 1);
    assert_eq!(scene.strands[0].vertices.len(), 3);
    assert_eq!(scene.strands[0].vertices[0].radius, 0.25);
    assert_eq!(scene.skipped.get("not finite"), Some(&1));
    let lone = of_file("lone.csv", "x,y,z\n0,0,0\n", "");
    assert_eq!(lone.skipped.get("strand shorter than two vertices"), Some(&1));
}

#[test]
fn fur_grows_from_a_shape() {
    let toml = format!(
        "{HAIR}[[shape]]\nkind = \"sphere\"\nname = \"ball\"\nmaterial = \"hair\"\n[[strands]]\n\
         material = \"hair\"\n\
         generate = {{ kind = \"fur\", on = \"ball\", count = 200, segments = 4, length = 0.2, root = \
         [1, 0, 0, 1] }}\n"
    );
    let scene = read(&toml).unwrap();
    assert_eq!(scene.strands.len(), 200);
    for strand in &scene.strands {
        assert_eq!(strand.vertices.len(), 5);
        let away = strand.vertices[0].position.length();
        assert!((0.45..=0.501).contains(&away), "{away}");
        assert!(strand.vertices[4].position.length() > away + 0.1);
        assert_eq!(strand.vertices[4].radius, 0.0);
    }
    assert_eq!(read(&toml).unwrap().strands, scene.strands);
}

#[test]
fn strands_follow_keys() {
    let csv = "x,y,z,radius,id\n0,0,0,0.1,7\n1,0,0,0.1,7\n0,0,0,0.1,8\n0,1e3,0,0.1,8\n";
    let key = |target: &str, values: &str| {
        format!("[[animate]]\ntarget = \"strands.{target}\"\ntimes = [0, 2]\nvalues = {values}\n")
    };
    let keys = "name = \"hair\"\n".to_owned()
        + &key("hair.rotation", "[[0, 0, 0], [0, 0, 90]]")
        + &key("0.scale", "[[1, 1, 1], [2e4, 2e4, 2e4]]");
    let mut scene = of_file("hair.csv", csv, &keys);
    let before = scene.strands.clone();
    scene.set_time(2.0);
    let apart = |found: Vec3, expected: Vec3| (found - (expected - scene.origin)).length();
    assert!(apart(scene.strands[0].vertices[1].position, Vec3::new(0.0, 2e4, 0.0)) < 0.1);
    assert!((scene.strands[0].vertices[1].radius - 2e3).abs() < 0.1);
    // The other would reach too far.
    assert_eq!(scene.strands[1].vertices[1].position, before[1].vertices[1].position);
    assert_eq!(scene.strands[1].vertices[1].color.w, 0.0);
    assert_eq!(scene.skipped.get("strand moved too far"), Some(&1));
    assert!(apart(before[0].vertices[1].position, Vec3::X) < 1e-3);
    scene.set_time(0.0);
    assert_eq!(scene.strands, before);
    let unknown = key("none.scale", "[[1, 1, 1], [1, 1, 1]]");
    assert!(refused(&format!("{HAIR}{unknown}")).contains("there is no strands `none`"));
}

#[test]
fn wrong_strands_are_refused_with_a_remedy() {
    let with = |keys: &str| refused(&format!("{HAIR}[[strands]]\nmaterial = \"hair\"\n{keys}"));
    for (keys, message) in [
        ("", "strands need either a file or generate; give one of the two"),
        ("generate = { kind = \"fur\", on = \"ball\" }", "no shape or mesh is named `ball`"),
        (
            "generate = { kind = \"fur\", on = \"ball\", lenght = 1 }",
            "there is no key `lenght` here",
        ),
        ("fil = \"x.ply\"", "there is no key `fil` here"),
        ("generate = { kind = \"fur\", on = \"a\", count = 0 }", "count is 0"),
        ("radius = 0.1\ngenerate = { kind = \"fur\", on = \"a\" }", "radius beside generate"),
    ] {
        let found = with(keys);
        assert!(found.contains(message), "{keys}: {found}");
    }
}
