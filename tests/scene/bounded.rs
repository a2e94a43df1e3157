//! Work and counts that are bounded before anything is allocated.
use super::emitters::emitting;
use crate::common::files::{Folder, read};
use gobo::glam::Mat4;
use gobo_scene as scene;
use gobo_scene::{SceneError, load_model};
use std::time::{Duration, Instant};

/// Line and message of a refusal with a remedy.
fn refused(toml: &str) -> (usize, String) {
    match read(toml) {
        Err(SceneError::Document { line, message, help, .. }) => {
            assert!(help.is_some(), "{message}");
            (line, message)
        }
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("read without an error: {toml}"),
    }
}

const MATERIAL: &str = "[[material]]\nname = \"m\"\n";

#[test]
fn lights_with_a_source_are_as_many_as_devices_evaluate() {
    let lamp = "[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\n\
        source = { kind = \"sphere\", radius = 0.1 }\n";
    let (line, message) = refused(&lamp.repeat(65));
    assert_eq!(line, 64 * 4 + 4, "{message}");
    assert!(message.contains("65 viewpoints of sources") && message.contains("64"), "{message}");
    // A light without shadows or without a size has no source.
    let others = [lamp.replace("0.1", "0"), lamp.to_owned() + "casts = false\n"].concat();
    assert_eq!(read(&(lamp.repeat(64) + &others.repeat(2))).unwrap().lights.len(), 68);
}

#[test]
fn steps_of_all_emitters_are_summed_up() {
    // 60,100 particles for 36,000 steps each.
    let emitter = "[[emitter]]\nmaterial = \"m\"\nrate = 100\nlifetime = 600\nstart = -600\n";
    let camera = "[camera]\neye = [0, 1, 5]\ntarget = [0, 0, 0]\n";
    let folder = Folder::new();
    let clock = Instant::now();
    let fits = folder.write("one.toml", format!("{MATERIAL}{camera}{emitter}"));
    let steps = gobo_scene::Summary::of(&scene::check(&fits).unwrap()).steps;
    assert!((2_150_000_000..2_180_000_000).contains(&steps), "{steps}");
    // Even if the camera would be placed to frame the contents.
    scene::check(&folder.write("unplaced.toml", format!("{MATERIAL}{emitter}"))).unwrap();
    let (line, message) = refused(&format!("{MATERIAL}{}", emitter.repeat(2)));
    assert_eq!(line, 2 + 5 + 4, "{message}");
    assert!(message.contains("steps of particles"), "{message}");
    // A fluid visits many neighbours per step, from its start on.
    let fluid = "[[emitter]]\nmaterial = \"m\"\nrate = 900\nlifetime = 10\nstart = -600\n\
        fluid = { spacing = 0.1 }\n";
    let (line, message) = refused(&format!("{MATERIAL}{fluid}"));
    assert_eq!(line, 2 + 4, "{message}");
    read(&format!("{MATERIAL}{camera}{}", fluid.replace("-600", "-1"))).unwrap();
    assert!(clock.elapsed() < Duration::from_secs(20), "{:?}", clock.elapsed());
}

#[test]
fn long_headers_take_no_longer_than_their_length() {
    let folder = Folder::new();
    let clock = Instant::now();
    let elements: String =
        (0..100_000).map(|i| format!("element e{i} 1\nproperty uchar v\n")).collect();
    let head = format!("ply\nformat binary_little_endian 1.0\n{elements}end_header\n");
    let path = folder.write("many.ply", [head.as_bytes(), &[0; 100_000]].concat());
    let error = scene::check(&path).unwrap_err().to_string();
    assert!(error.contains("vertex"), "{error}");
    let names: Vec<_> = (0..100_000).map(|i| format!("c{i}")).collect();
    let row = ",1".repeat(100_000);
    let csv = format!("x,y,z,{}\n0,0,0{row}\n1,0,0{row}\n", names.join(","));
    assert_eq!(scene::check(&folder.write("wide.csv", csv)).unwrap().particles.len(), 2);
    assert!(clock.elapsed() < Duration::from_secs(20), "{:?}", clock.elapsed());
}

/// 268 million texels, whose noise takes minutes.
#[test]
fn textures_are_not_made_to_be_checked() {
    let folder = Folder::new();
    let texture = |i| {
        format!(
            "[[material]]\nname = \"m{i}\"\ntexture = {{ generate = \"noise\", size = 2048, evolve = 1 }}\n"
        )
    };
    let toml = |count: usize| (0..count).map(texture).collect::<String>();
    let clock = Instant::now();
    let scene = scene::check(&folder.write("noise.toml", toml(64))).unwrap();
    assert_eq!(gobo_scene::Summary::of(&scene).textures, 64);
    let error = scene::check(&folder.write("more.toml", toml(65))).unwrap_err().to_string();
    assert!(error.contains("texels"), "{error}");
    assert!(clock.elapsed() < Duration::from_secs(20), "{:?}", clock.elapsed());
}

#[test]
fn names_are_found_without_looking_through_all() {
    let folder = Folder::new();
    let shape = |i: u32| format!("[[shape]]\nname='s{i}'\nkind='plane'\nmaterial='m'\n");
    let keys = |i: u32| {
        format!("[[animate]]\ntarget='shape.s{i}.translation'\ntimes=[0]\nvalues=[[0,{i},0]]\n")
    };
    let count = 30_000;
    let tables: String = (0..count).map(shape).chain((0..count).map(keys)).collect();
    let clock = Instant::now();
    let path = folder.write("names.toml", format!("{MATERIAL}{tables}"));
    let scene = scene::check(&path).unwrap();
    assert_eq!(scene.triangles[2 * 700].positions[0].y, 700.0);
    let twice = folder.write("twice.toml", format!("{MATERIAL}{tables}{}", shape(29_999)));
    let error = scene::check(&twice).unwrap_err().to_string();
    assert!(error.contains("a second shape named `s29999`"), "{error}");
    assert!(clock.elapsed() < Duration::from_secs(40), "{:?}", clock.elapsed());
}

/// Instances of a mesh without primitives, and morph targets without a weight.
#[test]
fn steps_that_make_nothing_are_counted() {
    let folder = Folder::new();
    folder.write("zeros.bin", vec![0; 12 * 500_000]);
    let load = |nodes: usize, node: &str, mesh: &str| {
        let (all, nodes) = (vec![node; nodes].join(","), (0..nodes).collect::<Vec<_>>());
        let text = format!(
            r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["EXT_mesh_gpu_instancing"],
            "scenes":[{{"nodes":{nodes:?}}}],
            "nodes":[{all}],"meshes":[{{"primitives":[{mesh}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":500000,"type":"VEC3"}},
              {{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[0,0,0]}}],
            "bufferViews":[{{"buffer":0,"byteLength":6000000}}],
            "buffers":[{{"byteLength":6000000,"uri":"zeros.bin"}}]}}"#
        );
        load_model(&folder.write("many.gltf", text), Mat4::IDENTITY)
    };
    let instances =
        r#"{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":0}}}}"#;
    let clock = Instant::now();
    load(2, instances, "").unwrap();
    let error = load(1000, instances, "").unwrap_err().to_string();
    assert!(error.contains("nodes of a glTF file"), "{error}");
    let targets = vec![r#"{"POSITION":1}"#; 2000].join(",");
    let mesh = format!(r#"{{"attributes":{{"POSITION":1}},"targets":[{targets}]}}"#);
    load(5, r#"{"mesh":0}"#, &mesh).unwrap();
    let error = load(6000, r#"{"mesh":0}"#, &mesh).unwrap_err().to_string();
    assert!(error.contains("keys and morphed triangles"), "{error}");
    assert!(clock.elapsed() < Duration::from_secs(40), "{:?}", clock.elapsed());
}

#[test]
fn what_has_no_meaning_is_refused() {
    let sun = "[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0]\n";
    for (toml, key) in [
        ("[shadow]\nfilter = { kind = \"none\", taps = 3 }\n".to_owned(), "taps"),
        ("[shadow]\nfilter = { kind = \"spline\", radius = 3 }\n".to_owned(), "radius"),
        (format!("{sun}filter = {{ kind = \"bilinear\", taps = 3 }}\n"), "taps"),
        ("[shadow]\nbias = 1e30\n".to_owned(), "bias"),
        (format!("{sun}normal_bias = 1e30\n"), "normal_bias"),
        (
            format!(
                "{MATERIAL}[[particles]]\nmaterial = \"m\"\ngenerate = {{ kind = \"smoke\", count = 0 }}\n"
            ),
            "count",
        ),
    ] {
        let (line, message) = refused(&toml);
        assert_eq!(line, toml.lines().count(), "{message}");
        assert!(message.contains(key), "{message}");
    }
}

#[test]
fn particles_that_fly_too_far_are_counted() {
    let mut scene = emitting("rate = 60\nlifetime = 10\nvelocity = [6e6, 0, 0]\n");
    let far = "particle moved too far";
    scene.set_time(1.0);
    assert_eq!(scene.skipped.get(far), None);
    scene.set_time(5.0);
    let (count, left) = (scene.skipped[far], scene.particles.len());
    assert!(count > 150 && left > 50, "{count} are left out, {left} are not");
    scene.set_time(1.0);
    assert_eq!(scene.skipped.get(far), None, "they are counted as long as they are there");
}

#[test]
fn instances_are_numbers() {
    let folder = Folder::new();
    let load = |instance: f32| {
        let corners = [0f32, 0., 0., 1., 0., 0., 0., 1., 0., instance, 0., 0.];
        folder.write("at.bin", corners.map(f32::to_le_bytes).concat());
        let text = r#"{"asset":{"version":"2.0"},"extensionsUsed":["EXT_mesh_gpu_instancing"],
        "scenes":[{"nodes":[0]}],
            "nodes":[{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":1}}}}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],
            "max":[1,1,0]},
              {"bufferView":1,"componentType":5126,"count":1,"type":"VEC3"}],
            "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":12}],
            "buffers":[{"byteLength":48,"uri":"at.bin"}]}"#;
        load_model(&folder.write("instances.gltf", text), Mat4::IDENTITY)
    };
    assert_eq!(load(2.0).unwrap().triangles[0].positions[0].x, 2.0);
    for wrong in [f32::NAN, f32::NEG_INFINITY] {
        let error = load(wrong).unwrap_err().to_string();
        assert!(error.contains("instances of node 0: number 0 is not finite"), "{error}");
    }
}

/// Accessors without data are zeros: three corners at one point.
#[test]
fn accessors_may_lack_bytes() {
    let folder = Folder::new();
    let load = |count: usize| {
        let text = format!(
            r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
            "accessors":[{{"componentType":5126,"count":{count},"type":"VEC3","min":[0,0,0],
            "max":[0,0,0]}}]}}"#
        );
        load_model(&folder.write("zeros.gltf", text), Mat4::IDENTITY)
    };
    let model = load(3).unwrap();
    assert_eq!(model.skipped.get("triangle without area"), Some(&1));
    assert!(load(1 << 24).unwrap_err().to_string().contains("more items"));
}
