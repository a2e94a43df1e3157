//! Scenes far from the origin, where positions lose precision.
use crate::common::{
    files::Folder,
    scenes::{empty, material, particle, triangle},
};
use gobo::{
    glam::{Vec3, Vec4},
    model::{LightKind, Transfer},
    view::shadow_views,
};
use gobo_reference as reference;
use gobo_scene as scene;
use gobo_scene::{Scene, recentre, rounding_warning};

fn smoke_at(away: f32, radius: f32) -> Scene {
    let mut scene = empty(vec![material(Transfer::Filter)]);
    let center = Vec3::new(away, 0.0, 0.0);
    scene.particles = vec![particle(center, radius, Vec4::ONE)];
    scene
}

#[test]
fn smoke_far_from_the_origin_is_warned_of() {
    assert_eq!(rounding_warning(&smoke_at(100.0, 0.1)), None);
    assert_eq!(rounding_warning(&smoke_at(10_000.0, 10.0)), None);
    let warning = rounding_warning(&smoke_at(10_000.0, 0.1)).expect("a warning");
    assert!(warning.contains("10000 m") && warning.contains("1.19 mm"), "{warning}");
}

#[test]
fn triangles_far_from_the_origin_are_warned_of() {
    let pane = |at: Vec3| {
        let mut scene = empty(vec![material(Transfer::Filter)]);
        scene.triangles = vec![triangle([at, at + Vec3::X, at + Vec3::Y], 0)];
        scene
    };
    assert_eq!(rounding_warning(&pane(Vec3::X * 100.0)), None);
    assert!(rounding_warning(&pane(Vec3::X * 1e5)).is_some());
    assert_eq!(rounding_warning(&empty(Vec::new())), None);
}

/// A scene at an offset `away` from the origin [m]. Its numbers have few digits, so that they are exact there
/// as well.
fn load_at(away: [f32; 3]) -> Scene {
    let at =
        |x: f32, y: f32, z: f32| format!("[{}, {}, {}]", x + away[0], y + away[1], z + away[2]);
    let toml = format!(
        "[camera]\neye = {}\ntarget = {}\nsize = [32, 32]\n[shadow]\nsize = 64\n\
         [[light]]\nkind = \"spot\"\nposition = {}\ndirection = [-1, -2, -0.5]\n\
         [[light]]\nkind = \"directional\"\ndirection = [0.5, -1, 0.25]\n\
         [[material]]\nname = \"gel\"\ntint = [0.9, 0.4, 0.2, 0.5]\n\
         [[particles]]\nfile = \"dust.csv\"\nmaterial = \"gel\"\n\
         [[shape]]\nkind = \"sphere\"\nmaterial = \"gel\"\ntranslation = {}\n\
         displace = {{ amplitude = 0.5, speed = 1 }}\n",
        at(4.0, 3.0, 6.0),
        at(0.0, 0.0, 0.0),
        at(1.0, 2.0, 0.5),
        at(0.5, 0.25, -0.5),
    );
    let mut csv = String::from("x,y,z,radius\n");
    for i in 0..200_i32 {
        let place = [i * 37 % 101, i * 61 % 97, i * 29 % 89].map(|v| v as f32 / 64.0 - 0.75);
        let [x, y, z]: [f32; 3] = std::array::from_fn(|axis| place[axis] + away[axis]);
        csv += &format!("{x},{y},{z},0.03125\n");
    }
    let folder = Folder::new();
    folder.write("dust.csv", csv);
    scene::load(&folder.write("scene.toml", toml)).unwrap_or_else(|error| panic!("{error}"))
}

/// A translated scene has the same shadows. Its positions are exact at that offset, but sums of them are not.
#[test]
fn a_scene_far_away_has_the_shadows_of_one_at_the_origin() {
    let near = load_at([0.0; 3]);
    assert_eq!(near.origin, Vec3::ZERO);
    let away = [8192.0, 0.0, -16384.0];
    let far = load_at(away);
    assert_eq!(far.origin, Vec3::from(away));
    assert!(rounding_warning(&far).is_none());
    assert_eq!((near.camera, &near.particles), (far.camera, &far.particles));
    let position = |scene: &Scene| match scene.lights[0].kind {
        LightKind::Spot { position, .. } => position,
        _ => unreachable!(),
    };
    assert_eq!(position(&near), position(&far));
    assert_eq!(near.triangles, far.triangles);
    let [mut near, mut far] = [near, far];
    near.set_time(1.0);
    far.set_time(1.0);
    assert_eq!(near.triangles, far.triangles);
    let views = shadow_views(&near);
    assert_eq!(views, shadow_views(&far));
    let [a, b] = [&near, &far].map(|scene| reference::render_maps(scene, &views).0);
    for (a, b) in a.iter().zip(&b) {
        assert!(a.filter == b.filter && a.nearest == b.nearest && a.opaque == b.opaque);
        assert!(a.filter.iter().any(|f| f[0] < 0.9));
    }
}

/// A pane, a rigid body, a model and its light, all without motion.
fn still_at(away: [f32; 3]) -> Scene {
    let at =
        |x: f32, y: f32, z: f32| format!("[{}, {}, {}]", x + away[0], y + away[1], z + away[2]);
    let corners: Vec<u8> = [0.0, 0.0, 0.1, 1.3, 0.0, 0.0, 0.0, 0.7, 0.0f32]
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect();
    // The model's own node places it.
    let gltf = format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["KHR_lights_punctual"],
        "extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"point","intensity":5}}]}}}},
        "scenes":[{{"nodes":[0]}}],"nodes":[{{"translation":{},"children":[1]}},{{"mesh":0,
          "rotation":[0.6,0,0,0.8],"translation":[0.3,0.1,0],
          "extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],
        "max":[1.3,0.7,0.1]}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],
        "buffers":[{{"byteLength":36,"uri":"corners.bin"}}]}}"#,
        at(0.5, 1.0, 0.5),
    );
    let place = format!("material = \"gel\"\ntranslation = {}\n", at(0.0, 1.0, 0.0));
    let toml = format!(
        "[camera]\neye = {}\ntarget = {}\n[shadow]\nsize = 64\n\
         [[light]]\nkind = \"spot\"\nposition = {}\ndirection = [-1, -4, -1]\n\
         [[material]]\nname = \"gel\"\ntint = [0.9, 0.4, 0.2, 0.8]\n\
         [[shape]]\nkind = \"pane\"\n{place}rotation = [-70, 10, 0]\nscale = [1.7, 1.3, 1]\n\
         [[shape]]\nkind = \"sphere\"\nlevel = 2\n{place}displace = {{ amplitude = 0.3 }}\n\
         [[mesh]]\nfile = \"model.gltf\"\n",
        at(3.0, 2.0, 4.0),
        at(0.0, 0.5, 0.0),
        at(1.0, 4.0, 1.0),
    );
    let folder = Folder::new();
    folder.write("corners.bin", corners);
    folder.write("model.gltf", gltf);
    scene::load(&folder.write("scene.toml", toml)).unwrap_or_else(|error| panic!("{error}"))
}

/// Neighbouring numbers are 6 and 12 cm apart there.
#[test]
fn what_stands_still_a_thousand_kilometres_away_keeps_its_corners() {
    let (near, far) = (still_at([0.0; 3]), still_at([1_048_576.0, 0.0, -1_500_000.0]));
    assert_eq!(near.origin, Vec3::ZERO);
    assert_ne!(far.origin, Vec3::ZERO);
    assert_eq!(near.triangles.len(), far.triangles.len());
    let home = far.origin - Vec3::new(1_048_576.0, 0.0, -1_500_000.0);
    for (i, (a, b)) in near.triangles.iter().zip(&far.triangles).enumerate() {
        for c in 0..3 {
            let apart = (b.positions[c] + home).distance(a.positions[c]);
            assert!(apart < 1e-6, "triangle {i}: {apart} m");
            assert!(a.normals[c].distance(b.normals[c]) < 1e-5, "triangle {i}");
        }
    }
    let place = |scene: &Scene| match scene.lights[1].kind {
        LightKind::Point { position } => position,
        _ => unreachable!(),
    };
    assert!((place(&far) + home).distance(place(&near)) < 1e-6);
    assert!(far.skipped.is_empty(), "{:?}", far.skipped);
}

#[test]
fn what_is_near_or_large_enough_stays_where_it_is() {
    let mut scene = smoke_at(10_000.0, 10.0);
    recentre(&mut scene);
    assert_eq!((scene.origin, scene.particles[0].center.x), (Vec3::ZERO, 10_000.0));
    let mut scene = smoke_at(3.0, 1e-4);
    scene.particles.push(particle(Vec3::NEG_X * 3.0, 1e-4, Vec4::ONE));
    recentre(&mut scene);
    assert_eq!(scene.origin, Vec3::ZERO);
}
