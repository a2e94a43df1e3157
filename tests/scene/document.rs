//! Scene files, and values that the command line replaces.
use crate::common::files::{Folder, read, read_with};
use gobo::{
    glam::{UVec2, Vec2, Vec3, Vec4},
    model::{Bounds, ClusterSettings, LightKind, Profile, Receiver, Shape, Transfer},
    view,
};
use gobo_scene as scene;
use gobo_scene::generate::uniform_discs;
use std::{fs, path::Path};

const FULL: &str = r#"
[camera]
eye = [4, 3, 6]
target = [0, 1, 0]
fov_y = 60
size = [96, 54]
[shadow]
size = 64
receiver = "nearest"
nodes = 4
bias = 0.02
normal_bias = 2
pair_budget = 1000
curve_budget = 5000000000
[environment]
ambient = [0.1, 0.2, 0.3]
background = [0.4, 0.5, 0.6]
[[light]]
name = "sun"
kind = "directional"
direction = [0, -2, 0]
color = [1, 0.9, 0.8]
intensity = 2.5
cascades = 3
[[light]]
name = "lamp"
kind = "spot"
position = [0, 5, 0]
direction = [0, -1, 0]
angle = 40
near = 0.5
far = 20
size = 128
[[light]]
kind = "point"
position = [1, 2, 3]
casts = false
[[material]]
name = "smoke"
transfer = "smoke"
shape = "puff"
profile = "flat"
tint = [0.6, 0.5, 0.4, 0.1]
radius = 0.05
reflectivity = 0.2
texture = "image.png"
cutoff = 0.3
emission = [2, 1, 0]
transmission = 0.5
roughness = 0.4
receives = "others"
visible = false
casts = false
[[material]]
name = "ground"
transfer = "opaque"
[[particles]]
generate = { kind = "dust", count = 5, min = [-1, 0, -1], max = [1, 1, 1] }
material = "smoke"
[[particles]]
generate = { kind = "cloud", count = 5 }
material = "smoke"
[[shape]]
kind = "plane"
material = "ground"
translation = [0, 1, 0]
rotation = [0, 90, 0]
scale = [4, 1, 2]
"#;

#[test]
fn every_key_is_heard() {
    let folder = Folder::new();
    let path = folder.write("scene.toml", FULL);
    let image = image::RgbaImage::from_fn(3, 2, |x, y| image::Rgba([x as u8, y as u8, 7, 200]));
    image.save(folder.0.join("image.png")).unwrap();
    let scene = scene::load(&path).unwrap();

    assert_eq!((scene.camera.eye, scene.camera.target), (Vec3::new(4.0, 3.0, 6.0), Vec3::Y));
    assert_eq!(scene.camera.size, UVec2::new(96, 54));
    assert!((scene.camera.fov_y - 60f32.to_radians()).abs() < 1e-6);
    let shadow = scene.shadow;
    assert_eq!((shadow.size, shadow.receiver, shadow.nodes), (64, Receiver::Nearest, 4));
    assert_eq!((shadow.bias, shadow.normal_bias, shadow.pair_budget), (Some(0.02), 2.0, 1000));
    assert_eq!(shadow.curve_budget, 5_000_000_000);
    assert_eq!(scene.ambient, Vec3::new(0.1, 0.2, 0.3));
    assert_eq!(scene.background, Vec3::new(0.4, 0.5, 0.6));

    let [sun, lamp, bulb] = &scene.lights[..] else { panic!("{:?}", scene.lights) };
    assert_eq!(sun.kind, LightKind::Directional { direction: Vec3::NEG_Y });
    assert_eq!((sun.color, sun.intensity), (Vec3::new(1.0, 0.9, 0.8), 2.5));
    let cascades = sun.cascades.map(|c| (c.count, c.lambda, c.fade, c.range));
    assert_eq!(cascades, Some((3, 0.8, 0.1, None)));
    assert_eq!((sun.near, sun.far, sun.size), (None, None, None));
    let LightKind::Spot { position, direction, angle } = lamp.kind else { panic!("{lamp:?}") };
    assert_eq!((position, direction), (Vec3::Y * 5.0, Vec3::NEG_Y));
    assert!((angle - 40f32.to_radians()).abs() < 1e-6);
    assert_eq!((lamp.near, lamp.far, lamp.size), (Some(0.5), Some(20.0), Some(128)));
    assert_eq!(bulb.kind, LightKind::Point { position: Vec3::new(1.0, 2.0, 3.0) });
    assert_eq!((bulb.casts, lamp.casts), (false, true));

    let smoke = &scene.materials[0];
    assert_eq!(
        (smoke.transfer, smoke.shape, smoke.profile),
        (Transfer::Smoke, Shape::Puff, Profile::Flat)
    );
    assert_eq!(smoke.tint, Vec4::new(0.6, 0.5, 0.4, 0.1));
    assert_eq!((smoke.reflectivity, smoke.cutoff), (0.2, 0.3));
    assert_eq!(smoke.emission, Vec3::new(2.0, 1.0, 0.0));
    assert_eq!((smoke.transmission, smoke.roughness, smoke.texture), (0.5, 0.4, Some(0)));
    assert!(!smoke.visible && !smoke.casts);
    assert_eq!(smoke.receives, gobo::model::Receives::Others);
    assert_eq!(scene.textures.len(), 1);
    let texture = &scene.textures[0];
    assert_eq!((texture.width, texture.height), (3, 2));
    assert_eq!(texture.rgba, image.into_raw());

    let ids: Vec<_> = scene.particles.iter().map(|p| p.id).collect();
    assert_eq!(ids, (0..10).collect::<Vec<_>>());
    let triangles = scene.triangles.iter().flat_map(|t| t.positions);
    let bounds = triangles.fold(Bounds::EMPTY, |b, p| b.with_sphere(p, 0.0));
    assert!(bounds.min.abs_diff_eq(Vec3::new(-1.0, 1.0, -2.0), 1e-5), "{bounds:?}");
    assert!(bounds.max.abs_diff_eq(Vec3::new(1.0, 1.0, 2.0), 1e-5), "{bounds:?}");

    let summary = gobo_scene::Summary::of(&scene);
    assert_eq!((summary.particles, summary.triangles, summary.materials), (10, 2, 2));
    assert_eq!((summary.lights, summary.textures), (3, 1));
    assert_eq!(summary.views, view::shadow_views(&scene).len());
}

/// Unit shapes: bounds, closed or flat, and normals equal to those of their faces.
#[test]
fn shapes_are_of_unit_size() {
    let half = Vec3::splat(0.5);
    for (kind, extent, count) in [
        ("plane", Vec3::new(0.5, 0.0, 0.5), 2),
        ("pane", Vec3::new(0.5, 0.5, 0.0), 2),
        ("box", half, 12),
        ("sphere", half, 1280),
    ] {
        let scene = read(&format!(
            "[[material]]\nname = \"m\"\n[[shape]]\nkind = \"{kind}\"\nmaterial = \"m\""
        ))
        .unwrap();
        let bounds = scene.bounds();
        // The corners of an icosahedron are off the axes.
        assert!(bounds.max.abs_diff_eq(extent, 5e-3), "{kind}: {bounds:?}");
        assert!(bounds.min.abs_diff_eq(-extent, 5e-3), "{kind}: {bounds:?}");
        assert_eq!(scene.triangles.len(), count, "{kind}");
        for t in &scene.triangles {
            let [a, b, c] = t.positions;
            let face = (b - a).cross(c - a).normalize();
            for n in t.normals {
                assert!((n.length() - 1.0).abs() < 1e-5, "{kind}: {n}");
                assert!(n.dot(face) > 0.98, "{kind}: {n} of a face that looks along {face}");
            }
            assert!(t.uvs.iter().all(|uv| uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all()));
        }
        let facing = |n| scene.triangles.iter().all(|t| t.normals == [n; 3]);
        assert_eq!(facing(Vec3::Y), kind == "plane");
        assert_eq!(facing(Vec3::Z), kind == "pane");
    }
}

#[test]
fn the_top_of_a_pane_is_the_top_of_its_image() {
    let scene =
        read("[[material]]\nname = \"m\"\n[[shape]]\nkind = \"pane\"\nmaterial = \"m\"").unwrap();
    for t in &scene.triangles {
        for (p, uv) in t.positions.iter().zip(t.uvs) {
            assert_eq!(uv, Vec2::new(p.x + 0.5, 0.5 - p.y));
        }
    }
}

/// Rotation about z comes first, then y, then x; normals follow a non-uniform scale.
#[test]
fn shapes_are_turned_and_scaled() {
    let shape = |kind: &str, keys: &str| {
        let head = format!("[[material]]\nname = \"m\"\n[[shape]]\nkind = \"{kind}\"\n");
        read(&format!("{head}material = \"m\"\n{keys}")).unwrap().triangles
    };
    let normal = |keys| shape("plane", keys)[0].normals[0];
    let assert_near = |a: Vec3, b: Vec3| assert!(a.abs_diff_eq(b, 1e-6), "{a} is not {b}");
    assert_near(normal("rotation = [90, 0, 0]"), Vec3::Z);
    assert_near(normal("rotation = [0, 0, 90]"), Vec3::NEG_X);
    assert_near(normal("rotation = [90, 90, 0]\nscale = [2, 3, 4]"), Vec3::Z);
    assert_near(normal("rotation = [0, 90, 90]"), Vec3::Z);
    for t in shape("sphere", "rotation = [10, 20, 30]\nscale = [1, 4, 1]") {
        let [a, b, c] = t.positions;
        let face = (b - a).cross(c - a).normalize();
        for n in t.normals {
            assert!(n.dot(face) > 0.9, "{n} of a face that looks along {face}");
        }
    }
}

#[test]
fn the_command_line_wins() {
    let file = r#"
[[light]]
name = "key"
kind = "point"
position = [0, 1, 0]
[[material]]
name = "glass"
"#;
    let set = [
        ("shadow.size", "512"),
        ("shadow.receiver", "nearest"),
        ("camera.size", "[320, 180]"),
        ("light.key.intensity", "7"),
        ("light.0.size", "256"),
        ("material.glass.tint", "[0.1, 0.2, 0.3, 0.4]"),
        ("material.glass.transfer", "\"stain\""),
        ("shadow.bias", "0.5"),
        ("shadow.bias", "0.25"),
    ];
    let scene = read_with(file, &set).unwrap();
    assert_eq!((scene.shadow.size, scene.shadow.receiver), (512, Receiver::Nearest));
    assert_eq!(scene.shadow.bias, Some(0.25), "the last one holds");
    assert_eq!(scene.camera.size, UVec2::new(320, 180));
    assert_eq!((scene.lights[0].intensity, scene.lights[0].size), (7.0, Some(256)));
    assert_eq!(scene.materials[0].tint, Vec4::new(0.1, 0.2, 0.3, 0.4));
    assert_eq!(scene.materials[0].transfer, Transfer::Stain);
    // The default light of a file without lights.
    let sun = read_with("", &[("light.sun.size", "64")]).unwrap();
    assert_eq!((sun.lights.len(), sun.lights[0].size), (1, Some(64)));
    assert_eq!(sun.lights[0].kind, read("").unwrap().lights[0].kind);
}

#[test]
fn generators_repeat_and_heed_their_keys() {
    let smoke = |keys: &str| {
        let file = format!(
            "[[material]]\nname = \"m\"\n[[particles]]\nmaterial = \"m\"\ngenerate = {{ {keys} }}"
        );
        read(&file).unwrap().particles
    };
    for kind in [
        "kind = \"smoke\", count = 300",
        "kind = \"cloud\", count = 300",
        "kind = \"dust\", count = 300, min = [-2, 0, 1], max = [0, 1, 2]",
    ] {
        let first = smoke(&format!("{kind}, seed = 1"));
        assert_eq!(first.len(), 300);
        assert_eq!(first, smoke(&format!("{kind}, seed = 1")), "{kind}");
        assert_ne!(first, smoke(&format!("{kind}, seed = 2")), "{kind}");
        for p in &first {
            assert!(p.center.is_finite() && p.radius > 0.0, "{p:?}");
            assert!(p.color.cmpge(Vec4::ZERO).all() && p.color.cmple(Vec4::ONE).all(), "{p:?}");
        }
        assert!(first.iter().any(|p| p.color != first[0].color), "{kind}: colours vary");
    }
    for p in smoke("kind = \"dust\", count = 300, min = [-2, 0, 1], max = [0, 1, 2]") {
        assert!(p.center.cmpge(Vec3::new(-2.0, 0.0, 1.0)).all(), "{p:?}");
        assert!(p.center.cmple(Vec3::new(0.0, 1.0, 2.0)).all(), "{p:?}");
    }
    let high = smoke("kind = \"smoke\", count = 300, base = [9, 0, 0], height = 50");
    assert!(high.iter().any(|p| p.center.y > 40.0) && high.iter().all(|p| p.center.x > 5.0));
}

#[test]
fn discs_for_benches_fill_their_box() {
    let bounds = Bounds { min: Vec3::new(-1.0, 0.0, 2.0), max: Vec3::new(1.0, 3.0, 4.0) };
    let discs = uniform_discs(2000, bounds, 0.1..0.3, 0.5, 9);
    assert_eq!(discs, uniform_discs(2000, bounds, 0.1..0.3, 0.5, 9));
    let found = discs.iter().fold(Bounds::EMPTY, |b, d| b.with_sphere(d.center, 0.0));
    assert!(found.min.cmpge(bounds.min).all() && found.max.cmple(bounds.max).all());
    assert!((found.max - found.min).cmpgt((bounds.max - bounds.min) * 0.98).all(), "{found:?}");
    assert!(discs.iter().all(|d| (0.1..0.3).contains(&d.radius) && d.color.w == 0.5));
}

/// Scenes of the project.
#[test]
fn own_scenes_load() {
    let data = Path::new(crate::common::ROOT).join("data");
    let mut count = 0;
    for entry in fs::read_dir(data).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "toml") {
            let scene = scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
            let transfers = || scene.materials.iter().map(|m| m.transfer);
            // Scenes of opaque casters alone are about soft shadows, masks and bounced light.
            let mut lights = scene.lights.iter();
            let is_opaque = lights.any(|light| light.source.is_some() || light.bounce > 0);
            let casts =
                is_opaque || scene.mask.is_some() || transfers().any(|t| t != Transfer::Opaque);
            assert!(casts, "{}: no caster", path.display());
            assert!(transfers().any(|t| t == Transfer::Opaque), "{}: no receiver", path.display());
            assert!(scene.skipped.is_empty(), "{}", path.display());
            count += 1;
        }
    }
    assert!(count >= 4, "{count} scenes");
}

#[test]
fn clusters_are_as_the_file_says() {
    let scene = read("").unwrap();
    assert_eq!(scene.clusters, ClusterSettings::default());
    let scene = read("[clusters]\ntile = 48\nslices = 64\nnear = 0.5\nbudget = 0\n").unwrap();
    let expected = ClusterSettings { tile: 48, slices: 64, near: Some(0.5), budget: 0 };
    assert_eq!(scene.clusters, expected);
    for (key, value) in [
        ("tile", "8"),
        ("tile", "40"),
        ("tile", "272"),
        ("slices", "0"),
        ("slices", "65"),
        ("near", "0"),
        ("near", "nan"),
        ("budget", "16777217"),
    ] {
        let error = read(&format!("[clusters]\n{key} = {value}\n")).unwrap_err();
        assert!(error.to_string().contains(key), "{error}");
    }
    assert!(read("[clusters]\nslice = 4\n").is_err());
}
