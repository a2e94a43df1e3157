//! Keys of glTF nodes, skins and morph targets.
use crate::common::files::Folder;
use gobo::{
    glam::{EulerRot, Mat4, Quat, Vec3},
    model::LightKind,
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene as scene;
use gobo_scene::Scene;

/// A glTF file of a triangle below two nodes, the outer of which rotates about y, and a light at the inner
/// one.
fn windmill(interpolation: &str, keys: &[[f32; 4]]) -> String {
    let mut floats: Vec<f32> = vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    floats.extend([0.0, 2.0]);
    floats.extend(keys.as_flattened());
    let bytes: Vec<u8> = floats.iter().flat_map(|v| v.to_le_bytes()).collect();
    let uri = base64(&bytes);
    let (length, count, rotations) = (bytes.len(), keys.len(), 16 * keys.len());
    format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["KHR_lights_punctual"],
        "extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"point","intensity":5}}]}}}},
        "scenes":[{{"nodes":[0]}}],"nodes":[{{"children":[1],"translation":[0,0,1]}},
          {{"mesh":0,"translation":[3,0,0],"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "animations":[{{"channels":[{{"sampler":0,"target":{{"node":0,"path":"rotation"}}}}],
          "samplers":[{{"input":1,"output":2,"interpolation":"{interpolation}"}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
          {{"bufferView":1,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[2]}},
          {{"bufferView":2,"componentType":5126,"count":{count},"type":"VEC4"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":8}},
          {{"buffer":0,"byteOffset":44,"byteLength":{rotations}}}],
        "buffers":[{{"byteLength":{length},"uri":"data:application/octet-stream;base64,{uri}"}}]}}"#
    )
}

fn base64(bytes: &[u8]) -> String {
    use base64::{Engine as _, engine::general_purpose::STANDARD};
    STANDARD.encode(bytes)
}

#[test]
fn gltf_nodes_follow_their_keys() {
    let folder = Folder::new();
    let quarter = Quat::from_rotation_y(90f32.to_radians());
    let keys = [Quat::IDENTITY.to_array(), quarter.to_array()];
    let zero = [0.0; 4];
    for (interpolation, keys, turned) in [
        ("LINEAR", &keys[..], 45.0),
        ("STEP", &keys[..], 0.0),
        // With slopes of 0 the middle of a cubic is the middle.
        ("CUBICSPLINE", &[zero, keys[0], zero, zero, keys[1], zero][..], 45.0),
    ] {
        folder.write("mill.gltf", windmill(interpolation, keys));
        let toml = "[[mesh]]\nname = 'mill'\nfile = 'mill.gltf'\ntranslation = [0, 5, 0]\n\
            [[animate]]\ntarget = 'mesh.mill.rotation'\ntimes = [0, 2]\nvalues = [[0, 0, 0], [0, 0, 90]]\n";
        let mut scene = scene::load(&folder.write("scene.toml", toml)).unwrap();
        for (seconds, turned, whole) in [(0.0, 0.0, 0.0f32), (1.0, turned, 45.0), (2.0, 90.0, 90.0)]
        {
            scene.set_time(seconds);
            let world = Mat4::from_translation(Vec3::Y * 5.0)
                * Mat4::from_quat(Quat::from_euler(EulerRot::XYZ, 0.0, 0.0, whole.to_radians()))
                * Mat4::from_translation(Vec3::Z)
                * Mat4::from_rotation_y(f32::to_radians(turned))
                * Mat4::from_translation(Vec3::X * 3.0);
            let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| world.transform_point3(p));
            for (found, exact) in scene.triangles[0].positions.iter().zip(corners) {
                assert!(found.distance(exact) < 1e-5, "{interpolation} {seconds}: {found} {exact}");
            }
            let LightKind::Point { position } = scene.lights[0].kind else { panic!() };
            assert!(position.distance(corners[0]) < 1e-5);
        }
    }
    // Alone it moves as well, and damaged keys are refused.
    let path = folder.write("mill.gltf", windmill("LINEAR", &keys));
    let mut alone = scene::load(&path).unwrap();
    let first = alone.triangles[0].positions;
    alone.set_time(1.0);
    assert_ne!(alone.triangles[0].positions, first);
    for (from, to) in [
        (r#""output":2"#, r#""output":0"#),
        (r#""output":2"#, r#""output":77"#),
        (r#""sampler":0"#, r#""sampler":5"#),
        (r#""target":{"node":0"#, r#""target":{"node":2"#),
        (r#""target":{"node":0"#, r#""target":{"node":4294967295"#),
        (r#""byteOffset":36,"byteLength":8"#, r#""byteOffset":44,"byteLength":8"#),
        (r#""count":2,"type":"VEC4""#, r#""count":1,"type":"VEC4""#),
    ] {
        let text = windmill("LINEAR", &keys).replace(from, to);
        let error = scene::load(&folder.write("mill.gltf", text)).unwrap_err().to_string();
        assert!(error.contains("mill.gltf"), "{error}");
    }
}

/// The sum of the announced keys overflows, although no single accessor does.
#[test]
fn more_keys_than_numbers_count_are_refused() {
    let folder = Folder::new();
    let keys = [Quat::IDENTITY.to_array(); 2];
    for count in [u64::MAX, u64::MAX - 1, 1 << 63] {
        let text = windmill("LINEAR", &keys)
            .replace(r#""count":2,"type":"VEC4""#, &format!(r#""count":{count},"type":"VEC4""#));
        assert!(text.contains(&count.to_string()));
        let error = scene::check(&folder.write("mill.gltf", text)).unwrap_err();
        let all = count.saturating_add(2);
        assert!(error.to_string().contains(&format!("{all} keys")), "{error}");
        assert_eq!(error.help(), Some("use fewer keys or morph targets"));
    }
}

/// The file's camera turns with its node, unless the scene places it.
#[test]
fn the_camera_of_a_model_follows_its_node() {
    let folder = Folder::new();
    let keys = [Quat::IDENTITY, Quat::from_rotation_y(90f32.to_radians())].map(|q| q.to_array());
    let camera =
        r#""cameras":[{"type":"perspective","perspective":{"yfov":0.7,"znear":0.1}}],"scenes""#;
    let text = windmill("LINEAR", &keys)
        .replace(r#""scenes""#, camera)
        .replace(r#""mesh":0,"translation""#, r#""mesh":0,"camera":0,"translation""#);
    let path = folder.write("mill.gltf", text);
    let looks = |scene: &Scene| {
        let camera = &scene.camera;
        [camera.eye + scene.origin, (camera.target - camera.eye).normalize(), camera.up]
    };
    let pose = |scene: &mut Scene, seconds: f64, turned: f32, whole: Vec3| {
        scene.set_time(seconds);
        let turn = Quat::from_rotation_y(turned.to_radians());
        let exact = [whole + Vec3::Z + turn * Vec3::X * 3.0, turn * Vec3::NEG_Z, Vec3::Y];
        for (found, exact) in looks(scene).into_iter().zip(exact) {
            assert!(found.distance(exact) < 1e-5, "{seconds} s: {found} {exact}");
        }
        assert_eq!(scene.camera.fov_y, 0.7);
    };
    let mut alone = scene::load(&path).unwrap();
    let mesh = "[[mesh]]\nfile = 'mill.gltf'\ntranslation = [0, 5, 0]\n";
    let mut placed =
        scene::load(&folder.write("scene.toml", format!("[camera]\nsize = [64, 32]\n{mesh}")))
            .unwrap();
    for (seconds, turned) in [(0.0, 0.0), (1.0, 45.0), (2.0, 90.0), (0.5, 22.5)] {
        pose(&mut alone, seconds, turned, Vec3::ZERO);
        pose(&mut placed, seconds, turned, Vec3::Y * 5.0);
    }
    for own in [
        "[camera]\neye = [0, 1, 9]\n",
        "[[animate]]\ntarget = 'camera.eye'\ntimes = [0]\nvalues = [[0, 1, 9]]\n",
    ] {
        let mut scene = scene::load(&folder.write("scene.toml", format!("{own}{mesh}"))).unwrap();
        for seconds in [0.0, 1.0] {
            scene.set_time(seconds);
            assert_eq!(looks(&scene)[0], Vec3::new(0.0, 1.0, 9.0), "{own}");
        }
    }
}

/// A triangle with two corners on two joints, and the third on both; the second joint rotates about z. Its
/// second morph target lifts all corners.
fn bent(weights: &str) -> String {
    let mut floats: Vec<f32> = vec![0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 1.0, 0.0];
    // Weights of the corners, then inverse bind matrices: the second moves the joint's position, (1, 0, 0),
    // to its origin.
    floats.extend([1.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0]);
    floats.extend(Mat4::IDENTITY.to_cols_array());
    floats.extend(Mat4::from_translation(Vec3::NEG_X).to_cols_array());
    floats.extend([0.0, 2.0]);
    floats.extend(Quat::IDENTITY.to_array());
    floats.extend(Quat::from_rotation_z(90f32.to_radians()).to_array());
    // Targets: one that stays, and one that lifts; their weights at 0 s and 2 s.
    floats.extend([9.0; 9]);
    floats.extend([0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    floats.extend([0.0, 0.0, 0.0, 4.0]);
    let mut bytes: Vec<u8> = floats.iter().flat_map(|v| v.to_le_bytes()).collect();
    bytes.extend([0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0]);
    let (uri, length) = (base64(&bytes), bytes.len());
    let view = |offset: usize, length: usize| {
        format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length}}}"#)
    };
    let views = [
        (0, 36),
        (36, 48),
        (84, 128),
        (212, 8),
        (220, 32),
        (252, 36),
        (288, 36),
        (324, 16),
        (340, 12),
    ];
    let views = views.map(|(offset, length)| view(offset, length)).join(",");
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[2,0]}}],
        "nodes":[{{"children":[1]}},{{"translation":[1,0,0]}},{{"mesh":0,"skin":0,"translation":[50,0,0]}}],
        "skins":[{{"joints":[0,1],"inverseBindMatrices":2}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"WEIGHTS_0":1,"JOINTS_0":8}},
          "targets":[{{"POSITION":5}},{{"POSITION":6}}]}}]{weights}}}],
        "animations":[{{"channels":[{{"sampler":0,"target":{{"node":1,"path":"rotation"}}}},
            {{"sampler":1,"target":{{"node":2,"path":"weights"}}}}],
          "samplers":[{{"input":3,"output":4}},{{"input":3,"output":7}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[2,1,0]}},
          {{"bufferView":1,"componentType":5126,"count":3,"type":"VEC4"}},
          {{"bufferView":2,"componentType":5126,"count":2,"type":"MAT4"}},
          {{"bufferView":3,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[2]}},
          {{"bufferView":4,"componentType":5126,"count":2,"type":"VEC4"}},
          {{"bufferView":5,"componentType":5126,"count":3,"type":"VEC3","min":[9,9,9],"max":[9,9,9]}},
          {{"bufferView":6,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,1],"max":[0,0,1]}},
          {{"bufferView":7,"componentType":5126,"count":4,"type":"SCALAR"}},
          {{"bufferView":8,"componentType":5121,"count":3,"type":"VEC4"}}],
        "bufferViews":[{views}],
        "buffers":[{{"byteLength":{length},"uri":"data:application/octet-stream;base64,{uri}"}}]}}"#
    )
}

#[test]
fn skins_and_targets_move_corners_against_each_other() {
    let folder = Folder::new();
    let mut scene = scene::load(&folder.write("bent.gltf", bent(""))).unwrap();
    for (seconds, turned, lift) in [(0.0, 0.0f32, 0.0), (1.0, 45.0, 2.0), (2.0, 90.0, 4.0)] {
        scene.set_time(seconds);
        let turn = |p: Vec3| {
            let about = Quat::from_rotation_z(turned.to_radians());
            Vec3::X + about * (p - Vec3::X)
        };
        let lifted = |p: Vec3| p + Vec3::Z * lift;
        let middle = Vec3::new(1.0, 1.0, 0.0);
        let exact = [
            lifted(Vec3::ZERO),
            lifted(turn(Vec3::X * 2.0)),
            lifted((middle + turn(middle)) * 0.5),
        ];
        for (found, exact) in scene.triangles[0].positions.iter().zip(exact) {
            assert!(found.distance(exact) < 1e-5, "{seconds} s: {found} {exact}");
        }
    }
    assert!(!scene.skipped.keys().any(|reason| reason.contains("ignored")), "{:?}", scene.skipped);
    for (from, to) in [
        (r#""joints":[0,1]"#, r#""joints":[0]"#),
        (r#""nodes":[2,0]"#, r#""nodes":[2]"#),
        (r#""inverseBindMatrices":2"#, r#""inverseBindMatrices":1"#),
        (r#""JOINTS_0":8"#, r#""JOINTS_0":1"#),
        (r#"{"POSITION":6}"#, r#"{"POSITION":7}"#),
        (r#""count":4,"type":"SCALAR""#, r#""count":3,"type":"SCALAR""#),
    ] {
        assert!(bent("").contains(from), "{from}");
        let text = bent("").replace(from, to);
        let error = scene::load(&folder.write("bent.gltf", text)).unwrap_err().to_string();
        assert!(error.contains("bent.gltf"), "{error}");
    }
}

/// A number that is not finite is refused by name; one that is only too large moves a triangle too far away,
/// which is left out while it is there.
#[test]
fn damaged_rigs_are_refused_or_left_out() {
    let folder = Folder::new();
    let with = |from: f32, to: f32| {
        let text = bent("");
        let (head, rest) = text.split_once("base64,").unwrap();
        let (data, tail) = rest.split_once('"').unwrap();
        let mut bytes = decoded(data);
        // Only the second joint's matrix has this number.
        let at = bytes.chunks(4).position(|word| word == from.to_le_bytes()).unwrap();
        bytes[4 * at..][..4].copy_from_slice(&to.to_le_bytes());
        folder.write("bent.gltf", format!("{head}base64,{}\"{tail}", base64(&bytes)))
    };
    for wrong in [f32::NAN, f32::INFINITY] {
        let error = scene::check(&with(-1.0, wrong)).unwrap_err().to_string();
        assert!(error.contains("skin 0: the matrix of joint 1 is not finite"), "{error}");
    }
    let far = "triangle moved too far";
    let path = with(-1.0, 1e30);
    let floor = "[[material]]\nname = 'm'\n[[shape]]\nkind = 'box'\nmaterial = 'm'\n[[light]]\n\
                 kind = 'directional'\ndirection = [0, -1, 0]\n[camera]\nsize = [8, 4]\n[shadow]\n\
                 size = 16\n";
    let text = format!("{floor}[[mesh]]\nfile = 'bent.gltf'\n");
    let mut scene = scene::load(&folder.write("scene.toml", text)).unwrap();
    assert!(path.exists());
    assert_eq!(scene.skipped.get(far), Some(&1));
    assert!(scene.bounds().max.abs().max_element() <= 0.5, "{:?}", scene.bounds());
    let frame = Renderer::on_cpu().render(&scene, &RenderOptions::default()).unwrap();
    assert_eq!(frame.counters.skipped.get(far), Some(&1));
    // Only at the time when it is too far away.
    folder.write("bent.gltf", bent(""));
    let text = format!(
        "{floor}[[mesh]]\nname = 'bent'\nfile = 'bent.gltf'\n[[animate]]\ntarget = 'mesh.bent.scale'\n\
         times = [0, 1, 2]\nvalues = [[1, 1, 1], [1e7, 1e7, 1e7], [1, 1, 1]]\n"
    );
    scene = scene::load(&folder.write("scene.toml", text)).unwrap();
    for (seconds, count) in [(0.0, None), (1.0, Some(&1)), (1.0, Some(&1)), (2.0, None)] {
        scene.set_time(seconds);
        assert_eq!(scene.skipped.get(far), count, "{seconds} s");
    }
}

fn decoded(text: &str) -> Vec<u8> {
    use base64::{Engine as _, engine::general_purpose::STANDARD};
    STANDARD.decode(text).unwrap()
}

/// A light that moves too far lights nothing, and is counted.
#[test]
fn a_light_too_far_away_is_counted() {
    let folder = Folder::new();
    let keys = [Quat::IDENTITY.to_array(); 2];
    folder.write("mill.gltf", windmill("LINEAR", &keys));
    let toml = "[[mesh]]\nname = 'mill'\nfile = 'mill.gltf'\n[[animate]]\ntarget = 'mesh.mill.scale'\n\
                times = [0, 1]\nvalues = [[1, 1, 1], [1e7, 1e7, 1e7]]\n";
    let mut scene = scene::load(&folder.write("scene.toml", toml)).unwrap();
    assert!(scene.skipped.is_empty(), "{:?}", scene.skipped);
    scene.set_time(1.0);
    assert_eq!(scene.skipped.get("light or camera moved too far"), Some(&1));
    let LightKind::Point { position } = scene.lights[0].kind else { panic!() };
    assert!(position.is_finite() && position.abs().max_element() <= 1e7, "{position}");
}
