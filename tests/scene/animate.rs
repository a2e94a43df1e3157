//! Keys of scene files.
use crate::common::files::read;
use gobo::{
    glam::{DVec3, Vec3, Vec4},
    model::LightKind,
};
use gobo_scene::{
    Scene,
    track::{Mode, Track},
};

const STAGE: &str = "[camera]\neye = [0, 1, 5]\ntarget = [0, 0, 0]\n[air]\ndensity = 0.1\n\
    [[light]]\nname = 'lamp'\nkind = 'spot'\nposition = [0, 3, 0]\ndirection = [0, -1, 0]\n\
    [[light]]\nname = 'day'\nkind = 'directional'\ndirection = [0, -1, 0]\n\
    [[material]]\nname = 'glass'\n[[material]]\nname = 'amber'\nattenuation_distance = 1\n\
    attenuation_color = [0.9, 0.5, 0.1]\n\
    [[shape]]\nname = 'crate'\nkind = 'box'\nmaterial = 'glass'\ntranslation = [1, 2, 3]\nscale = [1, 2, 1]\n\
    [[shape]]\nname = 'ball'\nkind = 'sphere'\nmaterial = 'amber'\n\
    [[shape]]\nname = 'cloud'\nkind = 'sphere'\nmaterial = 'glass'\ndisplace = { amplitude = 0.3 }\n";

fn animated(keys: &str) -> Scene {
    read(&format!("{STAGE}{keys}")).unwrap_or_else(|error| panic!("{error}"))
}

fn at(mut scene: Scene, seconds: f64) -> Scene {
    scene.set_time(seconds);
    scene
}

fn track(times: &[f32], values: &[f32], mode: Mode) -> Track {
    let values = values.iter().map(|&v| Vec4::splat(v)).collect();
    Track::new(times.to_vec(), values, mode).expect("keys in order")
}

#[test]
fn values_between_keys_are_those_of_the_mode() {
    let times = [1.0, 2.0, 4.0, 5.0];
    let values = [0.0, 1.0, 4.0, -1.0];
    let [step, linear, smooth] =
        [Mode::Step, Mode::Linear, Mode::Smooth].map(|mode| track(&times, &values, mode));
    for track in [&step, &linear, &smooth] {
        for (time, value) in times.iter().zip(values) {
            assert_eq!(track.at(f64::from(*time)).x, value);
        }
        assert_eq!((track.at(-9.0).x, track.at(99.0).x), (0.0, -1.0));
    }
    assert_eq!((step.at(1.999).x, step.at(2.0).x, step.at(3.999).x), (0.0, 1.0, 1.0));
    assert_eq!((linear.at(1.25).x, linear.at(3.0).x, linear.at(4.5).x), (0.25, 2.5, 1.5));
    // Uniform motion stays uniform for any spacing of the keys.
    let even = track(&[0.0, 1.0, 5.0, 7.0], &[0.0, 2.0, 10.0, 14.0], Mode::Smooth);
    for i in 0..70 {
        let seconds = f64::from(i) * 0.1;
        assert!((even.at(seconds).x - 0.2 * i as f32).abs() < 1e-5, "{seconds}");
    }
    // The slope at a key is the same from both sides: that between its neighbours, (4 - 0) / 3.
    let slope = |from: f64| (smooth.at(from + 1e-3).x - smooth.at(from).x) / 1e-3;
    let off = [slope(2.0), slope(2.0 - 1e-3)].map(|slope| (slope - 4.0 / 3.0).abs());
    assert!(off.iter().all(|off| *off < 5e-3), "{off:?}");
}

/// glTF 2.0, appendix C: value, and slopes times the interval between the keys.
#[test]
fn cubics_have_the_slopes_that_they_say() {
    let keys = track(&[0.0, 2.0], &[9.0, 1.0, 3.0, -2.0, 4.0, 9.0], Mode::Cubic);
    for i in 0..=20 {
        let t = i as f32 / 20.0;
        let (t2, t3) = (t * t, t * t * t);
        let exact = (2.0 * t3 - 3.0 * t2 + 1.0) * 1.0
            + 2.0 * (t3 - 2.0 * t2 + t) * 3.0
            + (3.0 * t2 - 2.0 * t3) * 4.0
            + 2.0 * (t3 - t2) * -2.0;
        assert!((keys.at(f64::from(2.0 * t)).x - exact).abs() < 1e-5, "{t}");
    }
}

#[test]
fn every_target_follows_its_keys() {
    let moved = |target: &str, values: [&str; 2]| {
        let [from, to] = values;
        let keys =
            format!("[[animate]]\ntarget = '{target}'\ntimes = [1, 3]\nvalues = [{from}, {to}]\n");
        at(animated(&keys), 2.0)
    };
    let vector = |target: &str| moved(target, ["[0, 1, 2]", "[2, 3, 6]"]);
    let middle = Vec3::new(1.0, 2.0, 4.0);
    assert_eq!(vector("camera.eye").camera.eye, middle);
    assert_eq!(vector("camera.target").camera.target, middle);
    assert_eq!(vector("camera.up").camera.up, middle.normalize());
    assert_eq!(moved("camera.fov_y", ["20", "40"]).camera.fov_y, 30f32.to_radians());
    assert_eq!(moved("camera.exposure", ["-2", "1"]).exposure, -0.5);
    let LightKind::Spot { position, .. } = vector("light.lamp.position").lights[0].kind else {
        panic!()
    };
    assert_eq!(position, middle);
    let LightKind::Spot { direction, .. } = vector("light.0.direction").lights[0].kind else {
        panic!()
    };
    assert_eq!(direction, middle.normalize());
    let LightKind::Spot { angle, .. } = moved("light.lamp.angle", ["20", "[40]"]).lights[0].kind
    else {
        panic!()
    };
    assert_eq!(angle, 30f32.to_radians());
    assert_eq!(vector("light.day.color").lights[1].color, middle);
    assert_eq!(moved("light.day.intensity", ["2", "4"]).lights[1].intensity, 3.0);
    let tint = moved("material.glass.tint", ["[0, 1, 0, 0]", "[1, 0, 0, 1]"]).materials[0].tint;
    assert_eq!(tint, Vec4::new(0.5, 0.5, 0.0, 0.5));
    assert_eq!(vector("material.glass.emission").materials[0].emission, middle);
    for (field, get) in [
        ("reflectivity", (|m| m.reflectivity) as fn(&gobo::model::Material) -> f32),
        ("cutoff", |m| m.cutoff),
        ("transmission", |m| m.transmission),
        ("roughness", |m| m.roughness),
        ("metallic", |m| m.metallic),
    ] {
        let scene = moved(&format!("material.amber.{field}"), ["0.25", "0.75"]);
        assert_eq!(get(&scene.materials[1]), 0.5, "{field}");
    }
    let air = moved("air.scattering", ["0", "[1, 2, 3]"]).air.unwrap();
    assert_eq!((air.scattering, air.extinction), (Vec3::new(0.5, 1.0, 1.5), Vec3::splat(0.1)));
    assert_eq!(moved("air.extinction", ["0", "1"]).air.unwrap().extinction, Vec3::splat(0.5));
    // The default sun of a scene without lights.
    let sun = read(
        "[[animate]]\ntarget = 'light.sun.direction'\ntimes = [0, 2]\nvalues = [[1, -1, 0], [-1, -1, 0]]\n",
    );
    assert_eq!(
        at(sun.unwrap(), 1.0).lights[0].kind,
        LightKind::Directional { direction: Vec3::NEG_Y }
    );
}

/// At any time, a shape with keys has the triangles of a static shape there, to the last bit.
#[test]
fn shapes_are_where_their_keys_say() {
    let keys = "[[animate]]\ntarget = 'shape.crate.translation'\ntimes = [0, 2]\n\
        values = [[0, 0, 0], [4, 2, 0]]\n\
        [[animate]]\ntarget = 'shape.crate.rotation'\ntimes = [0, 2]\nvalues = [[0, 0, 0], [0, 60, 40]]\n\
        [[animate]]\ntarget = 'shape.1.scale'\ntimes = [0, 2]\nvalues = [[1, 1, 1], [-1, 2, 3]]\n\
        mode = 'step'\n";
    let still = "[[material]]\nname = 'glass'\n[[material]]\nname = 'amber'\nattenuation_distance = 1\n\
        attenuation_color = [0.9, 0.5, 0.1]\n\
        [[shape]]\nkind = 'box'\nmaterial = 'glass'\ntranslation = [2, 1, 0]\nrotation = [0, 30, 20]\n\
        scale = [1, 2, 1]\n\
        [[shape]]\nkind = 'sphere'\nmaterial = 'amber'\n";
    let scene = at(animated(keys), 1.0);
    let expected = read(still).unwrap();
    let count = expected.triangles.len();
    assert_eq!(scene.triangles[..count], expected.triangles[..]);
    // A mirrored body still has its inside inside.
    let mirrored = at(scene, 2.0);
    let expected = read(&still.replace("'amber'\n", "'amber'\nscale = [-1, 2, 3]\n").replacen(
        "scale = [-1, 2, 3]\nattenuation",
        "attenuation",
        1,
    ))
    .unwrap();
    assert_eq!(mirrored.triangles[12..count], expected.triangles[12..]);
    // Time may run backwards.
    let back = at(at(animated(keys), 2.0), 1.0);
    assert_eq!(back.triangles, at(animated(keys), 1.0).triangles);
}

#[test]
fn far_scenes_move_as_near_ones() {
    let far = |x: f64| {
        let place = |y: f64| format!("[{x}, {y}, 0]");
        let toml = format!(
            "[camera]\neye = [{}, 2, 9]\ntarget = {}\n[[light]]\nname = 'lamp'\nkind = 'point'\n\
             position = {}\n\
             [[material]]\nname = 'm'\nradius = 0.01\n[[shape]]\nname = 'b'\nkind = 'box'\n\
             material = 'm'\ntranslation = {}\n\
             [[animate]]\ntarget = 'shape.b.translation'\ntimes = [0, 1]\nvalues = [{}, {}]\n\
             [[animate]]\ntarget = 'camera.eye'\ntimes = [0, 1]\nvalues = [{}, {}]\n\
             [[animate]]\ntarget = 'light.lamp.position'\ntimes = [0, 1]\nvalues = [{}, {}]\n",
            x + 1.0,
            place(0.0),
            place(3.0),
            place(0.0),
            place(0.0),
            place(1.0),
            place(2.0),
            place(4.0),
            place(3.0),
            place(5.0),
        );
        at(read(&toml).unwrap(), 0.5)
    };
    let (near, far) = (far(0.0), far(1_048_576.0));
    assert_ne!(far.origin, Vec3::ZERO);
    let place = |scene: &Scene| {
        let LightKind::Point { position } = scene.lights[0].kind else { panic!() };
        let of_scene = [scene.triangles[0].positions[0], scene.camera.eye, position];
        of_scene.map(|p| p.as_dvec3() + scene.origin.as_dvec3())
    };
    for (near, far) in place(&near).into_iter().zip(place(&far)) {
        assert!((far - near - DVec3::X * 1_048_576.0).length() < 0.1, "{near} {far}");
    }
}

#[test]
fn wrong_keys_are_named_with_line_and_remedy() {
    let head = "[[animate]]\ntarget = 'camera.eye'\n";
    let first = STAGE.lines().count();
    for (keys, line, message, help) in [
        (
            "[[animate]]\ntarget = 'camra.eye'\ntimes = [0]\nvalues = [1]",
            2,
            "nothing that keys",
            "camera.eye",
        ),
        ("[[animate]]\ntarget = 'camera.eyes'\ntimes = [0]\nvalues = [1]", 2, "eyes", "`eye`"),
        (
            "[[animate]]\ntarget = 'light.lmp.color'\ntimes = [0]\nvalues = [1]",
            2,
            "no light",
            "`lamp`",
        ),
        (
            "[[animate]]\ntarget = 'light.day.position'\ntimes = [0]\nvalues = [1]",
            2,
            "no position",
            "kind",
        ),
        (
            "[[animate]]\ntarget = 'material.glas.tint'\ntimes = [0]\nvalues = [1]",
            2,
            "no material",
            "`glass`",
        ),
        (
            "[[animate]]\ntarget = 'material.glass.tnit'\ntimes = [0]\nvalues = [1]",
            2,
            "tnit",
            "`tint`",
        ),
        (
            "[[animate]]\ntarget = 'shape.crat.scale'\ntimes = [0]\nvalues = [1]",
            2,
            "no shape",
            "`crate`",
        ),
        ("[[animate]]\ntarget = 'shape.crate.size'\ntimes = [0]\nvalues = [1]", 2, "size", "scale"),
        (
            "[[animate]]\ntarget = 'shape.cloud.scale'\ntimes = [0]\nvalues = [[1, 1, 1]]",
            2,
            "displaced",
            "drift",
        ),
        (
            "[[animate]]\ntarget = 'mesh.0.scale'\ntimes = [0]\nvalues = [[1, 1, 1]]",
            2,
            "no mesh",
            "name",
        ),
        (
            "[[animate]]\ntarget = 'shape.crate.scale'\ntimes = [0]\nvalues = [[1, 0, 1]]",
            4,
            "0",
            "flatten",
        ),
        (
            &format!("{head}times = [0, 1]\nvalues = [[0, 0, 1]]"),
            4,
            "2 times and 1 values",
            "each time",
        ),
        (&format!("{head}times = []\nvalues = []"), 4, "0 times", "one at least"),
        (
            &format!("{head}times = [1, 0]\nvalues = [[0, 0, 1], [0, 0, 2]]"),
            3,
            "ascend",
            "in order",
        ),
        (&format!("{head}times = [nan]\nvalues = [[0, 0, 1]]"), 3, "ascend", "in order"),
        (&format!("{head}times = [0]\nvalues = [[0, 1]]"), 4, "2 numbers", "3"),
        (&format!("{head}times = [0]\nvalues = [[0, 1, inf]]"), 4, "inf", "from"),
        (&format!("{head}times = [0]\nvalues = ['here']"), 4, "here", ""),
        (
            &format!("{head}times = [0]\nvalues = [[0, 0, 1]]\nmode = 'smoth'"),
            5,
            "smoth",
            "`smooth`",
        ),
        (&format!("{head}times = [0]\nvalues = [[0, 0, 1]]\nmodes = 'step'"), 5, "modes", "`mode`"),
        (
            "[[animate]]\ntarget = 'material.glass.tint'\ntimes = [0]\nvalues = [[0, 0, 2, 1]]",
            4,
            "2",
            "from 0",
        ),
        (
            &format!(
                "{head}times = [0]\nvalues = [[0, 0, 1]]\n{head}times = [0]\nvalues = [[0, 0, 1]]"
            ),
            6,
            "second",
            "one table",
        ),
    ] {
        let error = read(&format!("{STAGE}{keys}\n")).unwrap_err();
        let text = error.to_string();
        assert!(text.contains(&format!(":{}:", first + line)), "{keys}: {text}");
        assert!(text.contains(message), "{keys}: {text}");
        assert!(error.help().unwrap_or_default().contains(help), "{keys}: {:?}", error.help());
    }
    let twice = "[[shape]]\nname = 'crate'\nkind = 'box'\nmaterial = 'glass'\n";
    assert!(read(&format!("{STAGE}{twice}")).unwrap_err().to_string().contains("second shape"));
}

/// A rectangular light that swings through the vertical in the middle keeps its axes.
#[test]
fn rectangles_of_light_do_not_jump() {
    for [x, z] in [[0.3, 0.0], [0.0, 0.3], [0.2, -0.2], [0.3, 0.01]] {
        let mut scene = animated(&format!(
            "[[light]]\nname = 'panel'\nkind = 'spot'\nposition = [0, 3, 0]\ndirection = [0, -1, 0]\n\
             source = {{ kind = 'rect', width = 0.6, height = 0.2 }}\n\
             [[animate]]\ntarget = 'light.panel.direction'\ntimes = [0, 1]\n\
             values = [[{}, -1, {}], [{x}, -1, {z}]]\n",
            -x, -z
        ));
        let mut axes = |step: u32| {
            scene.set_time(f64::from(step) / 128.0);
            scene.lights[2].source.unwrap().half_axes().map(Vec3::normalize)
        };
        let all: Vec<_> = (0..=128).map(&mut axes).collect();
        for pair in all.windows(2) {
            let turned = (0..2).map(|i| pair[0][i].dot(pair[1][i]).abs()).fold(1.0, f32::min);
            assert!(turned > 3f32.to_radians().cos(), "{x} {z}: {pair:?}");
        }
        // It faces its direction at the end, too.
        let [along, across] = all[128];
        let facing = Vec3::new(x, -1.0, z).normalize();
        assert!(facing.dot(along).abs() < 1e-5 && facing.dot(across).abs() < 1e-5);
    }
}
