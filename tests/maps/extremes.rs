//! Scenes at the limits of validity: every scene that is read keeps the promises of [`Scene`] about its
//! numbers, and every view can project.
use crate::common::{
    Tier,
    files::{Folder, read, read_with},
    map_frame,
    scenes::Chance,
    tiers,
};
use gobo::{
    glam::Vec3,
    model::{LightKind, View},
    view::shadow_views,
};
use gobo_scene::{Scene, load};

const BASE: &str = r#"[camera]
eye = [0, 2, 4]
target = [0, 0, 0]
fov_y = 45
size = [32, 16]

[shadow]
size = 64

[[light]]
name = "sun"
kind = "directional"
direction = [0, -1, 0]
near = -1
far = 9

[[light]]
name = "spot"
kind = "spot"
position = [0, 3, 0]
direction = [0, -1, 0]
angle = 40

[[material]]
name = "smoke"
tint = [0.5, 0.5, 0.5, 0.5]

[[particles]]
generate = { kind = "smoke", count = 20, radius = 0.1 }
material = "smoke"

[[shape]]
kind = "plane"
material = "smoke"
scale = [4, 1, 4]
"#;

/// Error that names the number out of range.
fn sound(scene: &Scene) -> Result<(), String> {
    let check = |is_sound: bool, what: &dyn std::fmt::Debug| {
        if is_sound { Ok(()) } else { Err(format!("{what:?}")) }
    };
    let near = |p: Vec3, reach: f32| p.is_finite() && p.abs().max_element() <= reach;
    for p in &scene.particles {
        let most = scene.materials[p.material as usize].transfer.max_color();
        let color = p.color.truncate();
        check(near(p.center, 1e7) && p.radius > 0.0 && p.radius <= 1e7, p)?;
        check(p.rotation.is_finite() && (0.0..=1.0).contains(&p.color.w), p)?;
        check(color.min_element() >= 0.0 && color.max_element() <= most, p)?;
    }
    for t in &scene.triangles {
        // The floor of a bare file is wider than the file's contents.
        check(t.positions.into_iter().all(|p| near(p, 1e8)), t)?;
        check(t.normals.into_iter().all(|n| near(n, 1.0 + 1e-5)), t)?;
        check((t.material as usize) < scene.materials.len(), t)?;
    }
    for light in &scene.lights {
        let (position, direction) = match light.kind {
            LightKind::Directional { direction } => (Vec3::ZERO, direction),
            LightKind::Spot { position, direction, .. } => (position, direction),
            LightKind::Point { position } => (position, Vec3::X),
        };
        check(near(position, 1e7) && direction.is_normalized(), light)?;
        check(light.intensity.is_finite() && light.color.is_finite(), light)?;
    }
    let camera = View::from_camera(&scene.camera, &scene.bounds());
    for view in shadow_views(scene).iter().chain([&camera]) {
        check(view.near < view.far && view.near.is_finite() && view.far.is_finite(), view)?;
        check(view.scale.is_finite() && view.scale > 0.0, view)?;
        check(view.clip_from_world().is_finite(), view)?;
    }
    Ok(())
}

#[track_caller]
fn assert_sound(scene: &Scene, what: &str) {
    if let Err(problem) = sound(scene) {
        panic!("{what}\n{problem}");
    }
}

#[test]
fn unsound_scenes_are_noticed() {
    let breakers: [fn(&mut Scene); 7] = [
        |scene| scene.particles[3].center.y = 1.1e7,
        |scene| scene.particles[3].color.x = 1.5,
        |scene| scene.particles[3].radius = 0.0,
        |scene| scene.triangles[1].normals[2].x = f32::NAN,
        |scene| scene.triangles[1].material = 9,
        |scene| scene.lights[0].far = Some(-2.0),
        |scene| scene.camera.fov_y = 0.0,
    ];
    for (number, breaker) in breakers.into_iter().enumerate() {
        let mut scene = read(BASE).unwrap();
        assert_sound(&scene, "base");
        breaker(&mut scene);
        assert!(sound(&scene).is_err(), "breaker {number}");
    }
}

#[test]
fn valid_extremes() {
    for (usual, extreme) in [
        ("angle = 40", "angle = 0.01"),
        ("angle = 40", "angle = 179.9"),
        ("fov_y = 45", "fov_y = 0.01"),
        ("fov_y = 45", "fov_y = 179.9"),
        ("near = -1\nfar = 9", "near = 1e6"),
        ("angle = 40", "near = 1e6"),
        ("angle = 40", "far = 1e-6"),
        ("position = [0, 3, 0]", "position = [0, -3000, 0]"),
        ("position = [0, 3, 0]", "position = [1e7, 1e7, 1e7]"),
        ("scale = [4, 1, 4]", "scale = [1e-30, 1e-30, 1e-30]"),
        ("scale = [4, 1, 4]", "scale = [1e7, 1e-30, 1e-7]"),
        ("scale = [4, 1, 4]", "translation = [1e7, 0, 1e7]\nscale = [1e-3, 1, 1e-3]"),
        ("radius = 0.1", "base = [1e7, 1e7, 1e7]"),
        ("radius = 0.1", "height = 1e7, spread = 1e7, radius = 1e7"),
        ("direction = [0, -1, 0]", "direction = [0, -1e-30, 0]"),
        ("direction = [0, -1, 0]", "direction = [1e7, -1e7, 0]"),
    ] {
        assert!(BASE.contains(usual), "{usual}");
        let scene = read(&BASE.replacen(usual, extreme, 1));
        assert_sound(&scene.unwrap_or_else(|error| panic!("{extreme}: {error}")), extreme);
    }
    let far = BASE.replace("radius = 0.1", "base = [1e7, 0, 0], spread = 1");
    let scene = read(&far).unwrap();
    let skipped = scene.skipped["too far"];
    assert!(skipped > 0 && skipped + scene.particles.len() as u64 == 20, "{skipped}");
    let beyond = BASE.replace("scale = [4, 1, 4]", "translation = [1e7, 0, 0]\nscale = [9, 1, 9]");
    assert!(read(&beyond).unwrap_err().to_string().contains("beyond 1e7 m"));
}

/// Planes in front of all casters change depths, and nothing else.
#[test]
fn the_first_plane_of_a_sun_may_be_behind_its_light() {
    let scene = read(BASE).unwrap();
    let planes: Vec<_> = shadow_views(&scene).iter().map(|view| (view.near, view.far)).collect();
    assert_eq!(planes[0], (-1.0, 9.0));
    let from_zero = read(&BASE.replace("near = -1", "near = 0")).unwrap();
    for tier in tiers(Tier::Core) {
        let maps = &map_frame(tier, &scene).maps[0];
        let expected = &map_frame(tier, &from_zero).maps[0];
        let mut hits = 0;
        for i in 0..maps.filter.len() {
            let apart = (0..3).map(|c| (maps.filter[i][c] - expected.filter[i][c]).abs());
            assert!(apart.fold(0.0, f32::max) <= 1e-3, "{i}: {:?}", maps.filter[i]);
            if expected.nearest[i] < 1.0 {
                let depth = (expected.nearest[i] * 9.0 + 1.0) / 10.0;
                assert!((maps.nearest[i] - depth).abs() <= 1e-5, "{i}: {depth}");
                hits += 1;
            }
        }
        assert!(hits > 1000, "{hits}");
    }
}

#[test]
fn empty_scenes_have_views() {
    assert_sound(&read("").unwrap(), "empty");
    let folder = Folder::new();
    for rows in ["", "nan,0,0\n", "1,2,3\n", "1e7,1e7,1e7\n-1e7,-1e7,-1e7\n", "0,0,0\n0,0,1e-30\n"]
    {
        let file = folder.write("rows.csv", format!("x,y,z\n{rows}"));
        assert_sound(&load(&file).unwrap(), rows);
    }
}

#[test]
fn noise_is_skipped_or_sound() {
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\n\
        property float y\nproperty float z\nproperty uchar red\nproperty float radius\nend_header\n";
    let folder = Folder::new();
    let mut chance = Chance::new(9);
    for round in 0..2000 {
        let body = (0..4 * 17).map(|_| chance.below(256) as u8);
        let bytes: Vec<u8> = header.bytes().chain(body).collect();
        let scene = load(&folder.write("noise.ply", bytes)).unwrap();
        assert_eq!(scene.particles.len() as u64 + scene.skipped.values().sum::<u64>(), 4);
        assert_sound(&scene, &format!("round {round}"));
    }
}

#[test]
fn digits_changed_at_random() {
    let mut chance = Chance::new(3);
    let mut whole = 0;
    for _ in 0..2000 {
        let mut bytes = BASE.as_bytes().to_vec();
        let digits: Vec<usize> = (0..bytes.len()).filter(|i| bytes[*i].is_ascii_digit()).collect();
        for _ in 0..=chance.below(4) {
            bytes[digits[chance.below(digits.len())]] = b"0123456789-e."[chance.below(13)];
        }
        let text = String::from_utf8(bytes).unwrap();
        if let Ok(scene) = read(&text) {
            assert_sound(&scene, &text);
            whole += 1;
        }
    }
    assert!((500..1950).contains(&whole), "{whole}");
}

#[test]
fn settings_changed_at_random() {
    let keys = ["shadow.size", "light.sun.near", "light.1.angle", "particles.0.generate.count"];
    let mut chance = Chance::new(5);
    for _ in 0..2000 {
        let mut noise = |text: &str| {
            let mut bytes = text.as_bytes().to_vec();
            for _ in 0..chance.below(3) {
                let at = chance.below(bytes.len() + 1);
                bytes.insert(at, b"0123.,'\"[]{}=#\n-+einfa \\"[chance.below(24)]);
            }
            String::from_utf8(bytes).unwrap()
        };
        let set: Vec<_> = keys.iter().map(|key| (noise(key), noise("32"))).collect();
        let set: Vec<_> = set.iter().map(|(key, value)| (key.as_str(), value.as_str())).collect();
        if let Ok(scene) = read_with(BASE, &set) {
            assert_sound(&scene, &format!("{set:?}"));
        }
    }
}

#[test]
fn deep_and_long_documents() {
    for open in ["[", "{ a = "] {
        assert!(read(&format!("x = {}", open.repeat(100_000))).is_err());
    }
    assert!(read(&format!("{}a = 1", "a.".repeat(5_000))).is_err());
    assert!(read_with(BASE, &[("shadow.size", &"[".repeat(100_000))]).is_err());
    assert!(read_with(BASE, &[(&"a.".repeat(100_000), "1")]).is_err());
}

#[test]
fn textures_that_lie() {
    let mut png = std::io::Cursor::new(Vec::new());
    image::GrayImage::new(8, 8).write_to(&mut png, image::ImageFormat::Png).unwrap();
    let png = png.into_inner();
    let folder = Folder::new();
    let with = |bytes: &[u8]| {
        folder.write("lies.png", bytes);
        let text = "[[material]]\nname = 'a'\ntexture = 'lies.png'\n";
        load(&folder.write("scene.toml", text))
    };
    assert_eq!(with(&png).unwrap().textures[0].rgba.len(), 8 * 8 * 4);
    let mut huge = png.clone();
    // Width and height of a PNG, and their checksum, which readers may check first or last.
    huge[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
    for bytes in [&huge[..], &png[..png.len() / 2], &png[..8], b"", b"no image at all"] {
        assert!(with(bytes).unwrap_err().to_string().contains("lies.png"));
    }
}
