//! C sees the same values as Rust, and wrong calls return codes.
use crate::{
    fault::gobo_message,
    frame::{
        CMap, CPicture, gobo_frame_free, gobo_frame_map, gobo_frame_map_count, gobo_frame_picture,
    },
    render::{gobo_light_points, gobo_render, gobo_renderer_free, gobo_renderer_open},
    scene::{
        CCamera, CLight, gobo_light_default, gobo_scene_add_light, gobo_scene_add_particles,
        gobo_scene_add_triangles, gobo_scene_free, gobo_scene_from_text, gobo_scene_light_count,
        gobo_scene_set_camera, gobo_scene_set_time,
    },
};
use std::{
    ffi::CStr,
    fmt::Write as _,
    fs,
    mem::offset_of,
    path::Path,
    process::Command,
    ptr::{null, null_mut},
};

const SCENE: &CStr = cr#"
[camera]
eye = [0, 3, 4]
target = [0, 0, 0]
size = [32, 20]
[shadow]
size = 32
receiver = "curve"
[[material]]
name = "ground"
transfer = "opaque"
[[material]]
name = "glass"
transfer = "filter"
tint = [1, 0.25, 0.25, 1]
[[shape]]
kind = "plane"
material = "ground"
scale = [4, 1, 4]
"#;

fn message() -> String {
    // SAFETY: it ends with a zero and stays until the next failure of this thread.
    unsafe { CStr::from_ptr(gobo_message()) }.to_str().unwrap().to_owned()
}

/// A C++ compiler lays out the header's structs like this crate's.
#[test]
fn the_header_has_the_layout_of_the_structs() {
    let mut source = "#include <cstdio>\n#include \"gobo.h\"\nint main() {\n".to_owned();
    let mut expected = String::new();
    macro_rules! has {
        ($c:literal, $rust:ty, $($field:ident)*) => {
            writeln!(source, "std::printf(\"{} %zu\\n\", sizeof({}));", $c, $c).unwrap();
            writeln!(expected, "{} {}", $c, size_of::<$rust>()).unwrap();
            $(
                let field = stringify!($field);
                writeln!(source, "std::printf(\"{field} %zu\\n\", offsetof({}, {field}));", $c).unwrap();
                writeln!(expected, "{field} {}", offset_of!($rust, $field)).unwrap();
            )*
        };
    }
    has!("gobo_light", CLight, kind position direction angle color intensity map_size);
    has!("gobo_camera", CCamera, eye target up fov_y size);
    has!("gobo_picture", CPicture, size srgb light);
    has!("gobo_map", CMap, light view size nodes near_plane far_plane filter nearest opaque colored
        curve clip_from_world view_from_world);
    source += "}\n";
    let folder = std::env::temp_dir().join(format!("gobo-c-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("layout.cpp"), source).unwrap();
    let include = Path::new(env!("CARGO_MANIFEST_DIR")).join("include");
    let mut compile = Command::new("c++");
    compile.args([
        "-std=c++17",
        "-Wall",
        "-Werror",
        "-Wno-invalid-offsetof",
        "-o",
        "layout",
        "layout.cpp",
        "-I",
    ]);
    assert!(compile.arg(include).current_dir(&folder).status().unwrap().success());
    let found = Command::new(folder.join("layout")).output().unwrap().stdout;
    let _ = fs::remove_dir_all(&folder);
    assert_eq!(String::from_utf8(found).unwrap(), expected);
}

/// The header and this crate have the same functions.
#[test]
fn the_header_names_every_function() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let header = fs::read_to_string(root.join("include/gobo.h")).unwrap();
    let code: String = header.split("/*").map(|part| part.rsplit("*/").next().unwrap()).collect();
    let words = |text: &str| -> Vec<String> {
        let words = text
            .split('(')
            .filter_map(|part| part.rsplit(|c: char| !(c.is_alphanumeric() || c == '_')).next());
        let mut names: Vec<_> =
            words.filter(|word| word.starts_with("gobo_")).map(str::to_owned).collect();
        names.sort();
        names
    };
    let mut exported = Vec::new();
    for file in ["lib.rs", "fault.rs", "frame.rs", "render.rs", "scene.rs"] {
        let text = fs::read_to_string(root.join("src").join(file)).unwrap();
        for part in text.split("#[unsafe(no_mangle)]").skip(1) {
            let name = part.split("fn ").nth(1).unwrap().split('(').next().unwrap();
            exported.push(name.to_owned());
        }
    }
    exported.sort();
    assert!(exported.len() > 15, "{exported:?}");
    assert_eq!(words(&code), exported);
}

/// A pane above the ground lets a quarter of green pass; the picture and the maps have the stated sizes.
#[test]
fn a_scene_of_arrays_is_rendered() {
    // SAFETY: pointers are of living objects, and arrays have the stated lengths.
    unsafe {
        let (mut scene, mut renderer, mut frame) = (null_mut(), null_mut(), null_mut());
        assert_eq!(gobo_scene_from_text(SCENE.as_ptr(), null(), &mut scene), 0, "{}", message());
        let sun = CLight { map_size: 32, ..gobo_light_default() };
        let lights = gobo_scene_light_count(scene);
        assert_eq!(gobo_scene_add_light(scene, &sun, c"sun".as_ptr()), 0, "{}", message());
        assert_eq!(gobo_scene_light_count(scene), lights + 1);
        let corners = [0.0_f32, 1.0, -9.0, 0.0, 1.0, 9.0, 9.0, 1.0, 0.0];
        let add = gobo_scene_add_triangles;
        assert_eq!(add(scene, 1, corners.as_ptr(), c"glass".as_ptr(), null_mut()), 0);
        let (centers, radii) = ([-1.0_f32, 0.5, 0.0, f32::NAN, 0.0, 0.0], [0.1_f32, 0.1]);
        let mut left_out = 9;
        let glass = c"glass".as_ptr();
        let (at, size) = (centers.as_ptr(), radii.as_ptr());
        let added = gobo_scene_add_particles(scene, 2, at, size, null(), glass, &mut left_out);
        assert_eq!((added, left_out), (0, 1));
        assert_eq!(gobo_scene_add_particles(scene, 2, at, size, null(), glass, null_mut()), 1);
        assert!(message().contains("particle 1"), "{}", message());

        assert_eq!(gobo_renderer_open(5, null(), &mut renderer), 0, "{}", message());
        assert_eq!(gobo_render(renderer, scene, 3, &mut frame), 0, "{}", message());
        let mut picture = CPicture { size: [0; 2], srgb: null(), light: null() };
        assert_eq!(gobo_frame_picture(frame, &mut picture), 0);
        assert_eq!(picture.size, [32, 20]);
        let rgb = std::slice::from_raw_parts(picture.srgb, 32 * 20 * 3);
        assert!(
            rgb.chunks(3).any(|rgb| u16::from(rgb[0]) > 2 * u16::from(rgb[1])),
            "nothing is red"
        );
        let count = gobo_frame_map_count(frame);
        let mut map = std::mem::zeroed::<CMap>();
        assert_eq!(gobo_frame_map(frame, count - 1, &mut map), 0);
        assert_eq!((map.size, map.light as usize), ([32, 32], lights));
        let filter = std::slice::from_raw_parts(map.filter, 32 * 32 * 3);
        assert!(filter.chunks(3).any(|rgb| rgb[0] > 0.99 && (rgb[1] - 0.25).abs() < 0.01));
        let curve = std::slice::from_raw_parts(map.curve, 32 * 32 * map.nodes as usize * 5);
        assert!(curve.chunks(5).any(|node| node[0] < 1.0) && curve.contains(&2.0));
        assert_eq!(gobo_frame_map(frame, count, &mut map), 1);
        gobo_frame_free(frame);

        let points = [1.0_f32, 0.0, 0.2, -1.5, 0.0, 0.2];
        let mut shares = vec![9.0_f32; 2 * (lights + 1) * 3];
        let asked =
            gobo_light_points(renderer, scene, 2, points.as_ptr(), null(), shares.as_mut_ptr());
        assert_eq!(asked, 0, "{}", message());
        let of_sun = |point: usize| &shares[(point * (lights + 1) + lights) * 3..][..3];
        assert!((of_sun(0)[1] - 0.25).abs() < 0.02 && of_sun(0)[0] > 0.99, "{shares:?}");
        assert!(of_sun(1).iter().all(|share| *share > 0.99), "{shares:?}");
        gobo_renderer_free(renderer);
        gobo_scene_free(scene);
    }
}

#[test]
fn wrong_calls_are_codes_with_messages() {
    // SAFETY: pointers are NULL or of living objects.
    unsafe {
        let (mut scene, mut frame) = (null_mut(), null_mut());
        let broken = c"[camera]\nsize = \"large\"\n";
        assert_eq!(gobo_scene_from_text(broken.as_ptr(), null(), &mut scene), 2);
        assert!(scene.is_null() && message().contains("scene.toml:2:8"), "{}", message());
        assert_eq!(gobo_scene_from_text(null(), null(), &mut scene), 1);
        assert_eq!(message(), "text is NULL");
        assert_eq!(gobo_scene_from_text(SCENE.as_ptr(), null(), null_mut()), 1);
        assert_eq!(gobo_scene_from_text(SCENE.as_ptr(), null(), &mut scene), 0);
        let sun = gobo_light_default();
        for bad in [
            CLight { kind: 3, ..sun },
            CLight { direction: [0.0; 3], ..sun },
            CLight { intensity: f32::NAN, ..sun },
            CLight { map_size: 7, ..sun },
        ] {
            assert_eq!(gobo_scene_add_light(scene, &bad, null()), 1, "{bad:?}");
        }
        let one = [0.0_f32; 9];
        let add = gobo_scene_add_triangles;
        assert_eq!(add(scene, 1, one.as_ptr(), c"wood".as_ptr(), null_mut()), 1);
        assert!(message().contains("ground, glass"), "{}", message());
        assert_eq!(add(scene, 1, one.as_ptr(), c"glass".as_ptr(), null_mut()), 1);
        assert_eq!(add(scene, usize::MAX, one.as_ptr(), c"glass".as_ptr(), null_mut()), 1);
        assert_eq!(add(scene, 1, null(), c"glass".as_ptr(), null_mut()), 1);
        assert_eq!(gobo_scene_set_time(scene, f64::NAN), 1);
        let camera = CCamera {
            eye: [0.0; 3],
            target: [0.0; 3],
            up: [0.0, 1.0, 0.0],
            fov_y: 1.0,
            size: [8, 8],
        };
        assert_eq!(gobo_scene_set_camera(scene, &camera), 1);
        assert_eq!(gobo_scene_set_camera(scene, &CCamera { eye: [1.0; 3], ..camera }), 0);
        let mut renderer = null_mut();
        assert_eq!(gobo_renderer_open(9, null(), &mut renderer), 1);
        assert_eq!(gobo_renderer_open(5, null(), &mut renderer), 0);
        assert_eq!(gobo_render(renderer, scene, 0, &mut frame), 1);
        assert_eq!(gobo_render(renderer, null(), 1, &mut frame), 1);
        assert!(frame.is_null());
        gobo_renderer_free(renderer);
        gobo_scene_free(scene);
        gobo_scene_free(null_mut());
        assert_eq!((gobo_scene_light_count(null()), gobo_frame_map_count(null())), (0, 0));
    }
}
