//! Results beside the picture: curves as arrays, linear light, exposure, no ground.
use super::commands::{Folder, files, npy};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene as scene;
use std::fs;

/// Two panes under a sun straight down: red at 3/4 of the light, blue at 1/2, a floor below.
pub(super) const PANES: &str = r#"
[camera]
eye = [0, 2, 4]
target = [0, 0, 0]
size = [24, 16]
[shadow]
size = 16
nodes = 4
[[light]]
name = "sun"
kind = "directional"
direction = [0, -1, 0]
near = 0
far = 4
[[material]]
name = "floor"
transfer = "opaque"
[[material]]
name = "red"
tint = [1, 0.25, 0.25, 1]
[[material]]
name = "blue"
tint = [0.5, 0.5, 1, 1]
[[shape]]
kind = "plane"
material = "floor"
scale = [4, 1, 4]
[[shape]]
kind = "plane"
material = "red"
translation = [0, 2, 0]
scale = [4, 1, 4]
[[shape]]
kind = "plane"
material = "blue"
translation = [0, 1, 0]
scale = [4, 1, 4]
"#;

pub(super) fn scene_folder(name: &str, toml: &str) -> Folder {
    let folder = Folder::new(name);
    fs::write(folder.0.join("scene.toml"), toml).unwrap();
    folder
}

/// Light at depth `z` of a texel's nodes (start, end, r, g, b): docs/curves.md in Rust.
fn light_at(nodes: &[[f32; 5]], z: f32) -> [f32; 3] {
    let (mut behind, mut here, mut rest) = ([1f32; 3], [1f32; 3], [1f32; 3]);
    for &[start, end, r, g, b] in nodes.iter().filter(|node| node[0] < z) {
        let share = ((z - start) / (end - start).max(1e-9)).clamp(0.0, 1.0);
        for (i, light) in [r, g, b].into_iter().enumerate() {
            rest[i] *= if behind[i] > 0.0 { here[i] / behind[i] } else { 1.0 };
            here[i] = behind[i] + (light - behind[i]) * share;
            behind[i] = light;
        }
    }
    [0, 1, 2].map(|i| rest[i] * here[i])
}

#[test]
fn curves_are_written_as_arrays() {
    for backend in ["cpu", "vulkan"] {
        let folder = scene_folder(&format!("curves-{backend}"), PANES);
        folder.run(&["render", "scene.toml", "-o", "o", "--maps", "--backend", backend]);
        let stem = folder.0.join("o/maps/frame_0000/sun.0.curve");
        let (shape, values) = npy(&stem.with_extension("curve.npy")).unwrap();
        assert_eq!(shape, [16, 16, 4, 5]);
        let image = image::open(stem.with_extension("curve.png")).unwrap();
        assert_eq!((image.width(), image.height()), (16, 16));
        let views = fs::read_to_string(folder.0.join("o/maps/frame_0000/views.json")).unwrap();
        let views: serde_json::Value = serde_json::from_str(&views).unwrap();
        assert_eq!(views[0]["nodes"], 4);
        let (near, far) = (views[0]["near"].as_f64().unwrap(), views[0]["far"].as_f64().unwrap());
        assert_eq!((near, far), (0.0, 4.0));
        let nodes: Vec<[f32; 5]> = values.chunks(5).map(|node| node.try_into().unwrap()).collect();
        let texel = &nodes[(8 * 16 + 8) * 4..][..4];
        // A sun's near plane lies just above the highest pane: a step of 1 m is 1/4 of 4 m.
        let [red, blue, unused @ ..] = texel else { panic!() };
        assert!((blue[0] - red[0] - 0.25).abs() < 1e-4, "{texel:?}");
        assert_eq!((red[0], blue[0]), (red[1], blue[1]), "a pane is a step");
        let near = |found: &[f32], want: [f32; 3]| {
            found.iter().zip(want).all(|(a, b)| (a - b).abs() < 1.0 / 4095.0)
        };
        assert!(near(&red[2..], [1.0, 0.25, 0.25]), "{red:?}");
        assert!(near(&blue[2..], [0.5, 0.125, 0.25]), "{blue:?}");
        assert!(unused.iter().all(|node| node[0] == 2.0 && node[1] == 2.0), "{unused:?}");
        assert!(near(&light_at(texel, red[0] * 0.5), [1.0; 3]));
        assert!(near(&light_at(texel, (red[0] + blue[0]) * 0.5), [1.0, 0.25, 0.25]));
        assert!(near(&light_at(texel, 1.0), [0.5, 0.125, 0.25]));
    }
}

/// The array equals the library's own look-up, even where ramps were merged and overlap.
#[test]
fn arrays_are_the_curves_that_receivers_read() {
    let smoke = PANES.replace(
        "[[shape]]\nkind = \"plane\"\nmaterial = \"red\"",
        "[[material]]\nname = \"smoke\"\nshape = \"puff\"\ntint = [0.2, 0.5, 0.9, 0.4]\n[[particles]]\n\
         material = \"smoke\"\ngenerate = { kind = \"dust\", count = 300, min = [-1, 0.5, -1], \
         max = [1, 2, 1], radius = 0.3 }\n[[shape]]\nkind = \"plane\"\nmaterial = \"red\"",
    );
    let folder = scene_folder("smoke-curves", &smoke);
    folder.run(&["render", "scene.toml", "-o", "o", "--maps", "--backend", "cpu"]);
    let path = folder.0.join("o/maps/frame_0000/sun.0.curve.npy");
    let (_, values) = npy(&path).unwrap();
    let nodes: Vec<[f32; 5]> = values.chunks(5).map(|node| node.try_into().unwrap()).collect();
    let scene = scene::load(&folder.0.join("scene.toml")).unwrap();
    let options = RenderOptions { maps: true, ..RenderOptions::default() };
    let maps = Renderer::on_cpu().render(&scene, &options).unwrap().maps;
    let curve = maps[0].curve.as_ref().unwrap();
    let mut merged = 0;
    for texel in 0..16 * 16 {
        let own = &nodes[texel * 4..][..4];
        merged += own.iter().filter(|node| node[1] > node[0]).count();
        assert!(own.is_sorted_by_key(|node| node[0] == 2.0), "unused ones come last: {own:?}");
        for step in 0..64 {
            let z = (step as f32 + 0.5) / 64.0;
            let want = curve.light_at(texel, z).to_array();
            for (found, want) in light_at(own, z).into_iter().zip(want) {
                assert!((found - want).abs() < 1e-4, "texel {texel}, depth {z}: {found} {want}");
            }
        }
    }
    assert!(merged > 100, "{merged} ramps: no test of ramps");
}

/// Khronos PBR Neutral with a desaturation of 0.01, then sRGB: docs/scene.md in Rust.
fn shown(light: [f32; 3]) -> [u8; 3] {
    let least = light.into_iter().fold(f32::INFINITY, f32::min);
    let toe = if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let color = light.map(|v| v - toe);
    let peak = color.into_iter().fold(0.0, f32::max);
    let color = if peak < 0.76 {
        color
    } else {
        let new_peak = 1.0 - 0.24 * 0.24 / (peak + 0.24 - 0.76);
        let share = 1.0 - 1.0 / (0.01 * (peak - new_peak) + 1.0);
        color.map(|v| v * new_peak / peak * (1.0 - share) + new_peak * share)
    };
    color.map(|v| {
        let v = v.clamp(0.0, 1.0);
        let v = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
        (255.0 * v).round() as u8
    })
}

fn read_exr(path: &std::path::Path) -> (usize, usize, Vec<[f32; 3]>) {
    use exr::prelude::{ReadChannels as _, ReadLayers as _, read};
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0f32; 3]; size.area()]),
            |(width, pixels), at, (r, g, b): (f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .unwrap();
    let size = image.layer_data.size;
    let (red, green, blue) = image.layer_data.channel_data.channels.clone();
    for channel in [red, green, blue] {
        assert_eq!(channel.sample_type, exr::prelude::SampleType::F16);
    }
    (size.width(), size.height(), image.layer_data.channel_data.pixels.1)
}

#[test]
fn linear_light_is_written_before_exposure_and_tone_curve() {
    let mut lights = vec![];
    for backend in ["cpu", "vulkan"] {
        let folder = scene_folder(&format!("exr-{backend}"), PANES);
        let run = |out: &str, more: &[&str]| {
            let arguments = ["render", "scene.toml", "-o", out, "--exr", "--backend", backend];
            folder.run(&[&arguments[..], more, &["--set", "camera.samples=1"]].concat());
            let picture =
                image::open(folder.0.join(out).join("frame_0000.png")).unwrap().into_rgb8();
            (read_exr(&folder.0.join(out).join("frame_0000.exr")), picture)
        };
        let ((width, height, light), brighter) = run("b", &["--set", "camera.exposure=2"]);
        assert_eq!((width, height), (24, 16));
        assert!(light.iter().flatten().any(|&v| v > 0.5), "{light:?}");
        let mut pictures = vec![(4.0, brighter)];
        if backend == "cpu" {
            let ((.., again), picture) = run("o", &[]);
            assert_eq!(light, again, "exposure does not change the light");
            pictures.push((1.0, picture));
        }
        for (stops, picture) in pictures {
            for (i, pixel) in picture.pixels().enumerate() {
                let want = shown(light[i].map(|v| v * stops));
                for (found, want) in pixel.0.into_iter().zip(want) {
                    assert!(found.abs_diff(want) <= 1, "pixel {i}: {pixel:?} is not {want}");
                }
            }
        }
        lights.push(light);
    }
    let [cpu, kernels] = &lights[..] else { panic!() };
    for (a, b) in cpu.iter().flatten().zip(kernels.iter().flatten()) {
        // Four steps of half floats, as both backends round.
        assert!((a - b).abs() <= 4.0 * 2f32.powi(-11) * a.max(0.125), "{a} is not {b}");
    }
}

#[test]
fn exposure_is_checked() {
    let folder = scene_folder("exposure", PANES);
    for wrong in ["nan", "inf", "33", "-33"] {
        let set = format!("camera.exposure={wrong}");
        let stderr = folder.fail(&["render", "scene.toml", "--backend", "cpu", "--set", &set], 2);
        assert!(stderr.contains("exposure"), "{stderr}");
    }
}

#[test]
fn the_ground_can_be_left_out() {
    let folder = Folder::new("ground");
    fs::write(folder.0.join("dots.csv"), "x,y,z,radius\n0,1,0,0.3\n1,1,0,0.3\n").unwrap();
    let run = |out: &str, more: &[&str]| {
        let arguments = ["render", "dots.csv", "-o", out, "--backend", "cpu", "--json"];
        let small = ["--set", "camera.size=[48,27]", "--set", "shadow.size=32"];
        let line = folder.run(&[&arguments[..], more, &small].concat());
        serde_json::from_str::<serde_json::Value>(&line).unwrap()["casters"].as_u64().unwrap()
    };
    assert!(run("with", &[]) > 2);
    assert_eq!(run("without", &["--no-ground"]), 2);
    assert_eq!(files(&folder.0.join("without")), ["frame_0000.png"]);
    // A scene file has its own ground.
    folder.fail(&["render", "scene.toml", "--no-ground", "--backend", "cpu"], 2);
}

/// Commands say that the curves of a file that states neither receiver nor nodes have fewer than 8 nodes, and
/// have those.
#[test]
fn curves_past_their_budget_are_reported() {
    let folder = Folder::new("curve-budget");
    // A map of 16 x 16 takes 64 x 16 texels of its atlas, with 8 nodes of 8 bytes 65,536 bytes.
    for (budget, dropped, message) in [
        (65_536, 0, ""),
        (65_535, 4, "curves have 4 nodes instead of 8"),
        (32_767, 8, "receivers read nearest depths"),
    ] {
        let keys = format!("curve_budget = {budget}\ndetail = false\n");
        fs::write(folder.0.join("panes.toml"), PANES.replace("nodes = 4\n", &keys)).unwrap();
        let out = format!("o{budget}");
        let part = format!("{out}.gobo");
        let said = |arguments: &[&str]| {
            let output = folder.gobo(arguments);
            let errors = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{errors}");
            assert!(
                errors.contains(message) && errors.contains("curve_budget") == (dropped > 0),
                "{arguments:?}: {errors}"
            );
            output.stdout
        };
        said(&["check", "panes.toml"]);
        said(&["maps", "panes.toml", "--casters", "0/1", "-o", &part]);
        let report = said(&["render", "panes.toml", "-o", &out, "--maps", "--json"]);
        let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
        assert_eq!(report["nodes_dropped"], dropped);
        let path = folder.0.join(format!("{out}/maps/frame_0000/sun.0.curve.npy"));
        let shape = path.exists().then(|| npy(&path).unwrap().0);
        assert_eq!(shape, (dropped < 8).then(|| vec![16, 16, 8 - dropped as usize, 5]), "{budget}");
    }
}
