//! Layers for compositors.
use super::results::{PANES, scene_folder};
use std::{collections::BTreeMap, fs, path::Path};

/// Channels by name, pixels in order.
fn read_channels(path: &Path) -> BTreeMap<String, Vec<f32>> {
    let image = exr::prelude::read_first_flat_layer_from_file(path).unwrap();
    let channels = image.layer_data.channel_data.list;
    channels
        .iter()
        .map(|channel| (channel.name.to_string(), channel.sample_data.values_as_f32().collect()))
        .collect()
}

#[test]
fn light_is_the_sum_of_its_layers() {
    // The floor's shadows are those of both lights together.
    let caught = PANES.replace("transfer = \"opaque\"", "transfer = \"opaque\"\ncatcher = true");
    assert_ne!(caught, PANES);
    for (name, text) in [("layers", PANES), ("layers-caught", &caught)] {
        assert_layers_add_up(name, text);
    }
}

fn assert_layers_add_up(name: &str, text: &str) {
    let folder = scene_folder(name, text);
    let lamp =
        "\n[[light]]\nname = 'lamp'\nkind = 'point'\nposition = [0.5, 2, 1]\ncolor = [1, 0, 0]\n";
    let path = folder.0.join("scene.toml");
    let text = fs::read_to_string(&path).unwrap() + lamp;
    fs::write(&path, &text).unwrap();
    let render = ["render", "scene.toml", "-o", "o", "--exr", "--layers", "--set"];
    folder.run(&[&render[..], &["camera.samples=1"]].concat());
    let channels = read_channels(&folder.0.join("o/frame_0000.exr"));
    let lights = ["sun", "lamp", "rest"];
    for name in ["R", "G", "B"] {
        for (i, &whole) in channels[name].iter().enumerate() {
            let sum: f32 = lights.iter().map(|light| channels[&format!("{light}.{name}")][i]).sum();
            // Steps of half floats, one for each layer.
            assert!(
                (sum - whole).abs() <= 4.0 * 2f32.powi(-11) * whole.max(0.25),
                "{sum}, {whole}"
            );
        }
    }
    let most = |name: &str| channels[name].iter().copied().map(f32::abs).fold(0.0, f32::max);
    assert!(most("lamp.R") > 0.02 && most("lamp.G") < 1e-3, "a red lamp");
    // A catcher shows its background, which lights darken.
    let catches = text.contains("catcher = true");
    assert!(catches || most("rest.R") < most("R") + 1e-3);
    let stderr = folder.fail(&[&render[..], &["camera.shutter=0.5"]].concat(), 2);
    assert!(stderr.contains("shutter"), "{stderr}");
    folder.fail(&["render", "scene.toml", "--layers"], 2);
}

/// Seen from 8 m above: a floor, a pane half a metre beside a box that moves, and two suns.
const ABOVE: &str = r#"
[camera]
eye = [0, 8, 0]
target = [0, 0, 0]
up = [0, 0, -1]
size = [96, 72]
[shadow]
size = 256
[[light]]
name = "sun"
kind = "directional"
direction = [0, -1, 0]
[[light]]
name = "depth"
kind = "directional"
direction = [1, -1, 0]
[[material]]
name = "pane"
tint = [0.25, 1, 0.5, 1]
[[material]]
name = "floor"
transfer = "opaque"
tint = [0.5, 0.25, 0.125, 1]
[[material]]
name = "box"
transfer = "opaque"
tint = [0.75, 0.5, 1, 1]
[[shape]]
kind = "plane"
material = "floor"
scale = [7.1, 1, 5]
[[shape]]
kind = "plane"
material = "pane"
translation = [-2, 3, 0]
scale = [2, 1, 4]
[[shape]]
name = "box"
kind = "box"
material = "box"
translation = [2, 0.5, 0]
[[animate]]
target = "shape.box.translation"
times = [0, 1]
values = [[2, 0.5, 0], [5, 0.5, -6]]
"#;

/// Surfaces computed by hand.
#[test]
fn surfaces_have_layers_of_their_own() {
    const SIZE: [usize; 2] = [96, 72];
    for backend in ["cpu", "vulkan"] {
        let folder = scene_folder(&format!("surfaces-{backend}"), ABOVE);
        let render = ["render", "scene.toml", "-o", "o", "--exr", "--layers", "--frame", "2"];
        folder.run(&[&render[..], &["--backend", backend]].concat());
        let channels = read_channels(&folder.0.join("o/frame_0002.exr"));
        // Pixel that shows the point (x, y, z), away from edges.
        let pixel = 36.0 / (22.5f32.to_radians()).tan();
        let place = |[x, y, z]: [f32; 3]| {
            let of = |along: f32, size: usize| (along / (8.0 - y) * pixel) as i32 + size as i32 / 2;
            (of(z, SIZE[1]) as usize) * SIZE[0] + of(x, SIZE[0]) as usize
        };
        let near = |layer: &str, names: [&str; 3], point: [f32; 3], want: [f32; 3], within: f32| {
            let found = names.map(|name| channels[&format!("{layer}.{name}")][place(point)]);
            let is_near =
                found.iter().zip(want).all(|(found, want)| (found - want).abs() <= within);
            assert!(is_near, "{backend}: {layer} is {found:?}, not {want:?}");
        };
        let value = |name: &str, point| channels[name][place(point)];
        let (rgb, xyz) = (["R", "G", "B"], ["X", "Y", "Z"]);
        // At frame 2 the box is a quarter of a metre farther along, and half a metre farther up the picture.
        let (floor, top, sky) = ([0.0, 0.0, 1.0], [2.25, 1.0, -0.5], [-4.2, 0.0, 0.0]);
        near("albedo", rgb, floor, [0.5, 0.25, 0.125], 1e-3);
        near("albedo", rgb, top, [0.75, 0.5, 1.0], 1e-3);
        near("albedo", rgb, sky, [0.0; 3], 0.0);
        for point in [floor, top] {
            near("normal", xyz, point, [0.0, 1.0, 0.0], 1e-4);
        }
        near("normal", xyz, sky, [0.0; 3], 0.0);
        for (point, depth) in [(floor, 8.0), (top, 7.0), (sky, 1e10)] {
            // A light has the layer's plain name.
            let found = value("depth_.Z", point);
            assert!((found - depth).abs() <= 1e-3 * depth, "{backend}: {found} is not {depth}");
        }
        // Three metres to the right and six up in a second.
        let step = pixel / 7.0 / 24.0;
        for (point, [x, y]) in [(floor, [0.0; 2]), (top, [3.0 * step, 6.0 * step]), (sky, [0.0; 2])]
        {
            let found = ["motion.X", "motion.Y"].map(|name| value(name, point));
            let is_near = (found[0] - x).abs() <= 1e-3 && (found[1] - y).abs() <= 1e-3;
            assert!(is_near, "{backend}: {found:?} is not {:?}", [x, y]);
        }
        assert_eq!([floor, top, sky].map(|point| value("material.X", point)), [2.0, 3.0, 0.0]);
        let objects = [floor, top, sky].map(|point| value("object.X", point));
        assert!(objects[0] > 0.0 && objects[1] > objects[0] && objects[2] == 0.0, "{objects:?}");
        let glass = [0.25, 1.0, 0.5];
        // Under the pane, and where the slanted sun shines through it: three metres to the right.
        let (under, beside) = ([-2.0, 0.0, 0.0], [0.75, 0.0, 0.0]);
        near("shadow.sun", rgb, under, glass, 0.01);
        near("shadow.sun", rgb, beside, [1.0; 3], 0.01);
        near("shadow.depth", rgb, under, [1.0; 3], 0.01);
        near("shadow.depth", rgb, beside, glass, 0.01);
        near("shadow.sun", rgb, sky, [1.0; 3], 0.0);
        // The box's own shadow, to the right of it.
        near("shadow.depth", rgb, [3.4, 0.0, -0.5], [0.0; 3], 0.01);
        // Pixels at edges are means of samples; object numbers are those of the first sample.
        let is_between = |&&red: &&f32| red > 0.01 && red < 0.49;
        assert!(channels["albedo.R"].iter().filter(is_between).count() > 20);
        assert!(channels["material.X"].iter().all(|number| number.fract() == 0.0));
    }
}

/// Nothing moves in a scene without keys; still surfaces move against a camera with keys.
#[test]
fn motion_is_the_cameras_too() {
    let still = ABOVE.split("[[animate]]").next().unwrap();
    let keys = "[[animate]]\ntarget = \"camera.eye\"\ntimes = [0, 1]\nvalues = [[0, 8, 0], [24, 8, 0]]\n\
                [[animate]]\ntarget = \"camera.target\"\ntimes = [0, 1]\nvalues = [[0, 0, 0], [24, 0, 0]]\n";
    let render = ["render", "scene.toml", "-o", "o", "--exr", "--layers", "--backend", "cpu"];
    let folder = scene_folder("motion-none", still);
    folder.run(&render);
    let channels = read_channels(&folder.0.join("o/frame_0000.exr"));
    assert!(!channels.contains_key("motion.X") && channels.contains_key("normal.X"));
    let folder = scene_folder("motion-camera", &format!("{still}{keys}"));
    folder.run(&render);
    let channels = read_channels(&folder.0.join("o/frame_0000.exr"));
    let middle = 36 * 96 + 48;
    // A metre of the floor in the picture, to the left.
    let metre = 36.0 / (22.5f32.to_radians()).tan() / 8.0;
    let found = channels["motion.X"][middle];
    assert!((found + metre).abs() < 1e-2, "{found} is not {}", -metre);
    folder.fail(&[&render[..], &["--simulation", "device"]].concat(), 2);
}
