//! `gobo relight`: splats in, the same splats out with the light of a scene in their colours.
use super::commands::Folder;
use crate::common::splats::{SPLATS, Stored, bare, ply};
use gobo::glam::Vec3;
use gobo_scene::{load_harmonics, load_splats, splats::SplatCloud};
use std::fs;

/// The sun alone, without ambient light.
const SUN: &str = "[environment]\nambient = [0, 0, 0]\nbackground = [0, 0, 0]\n[shadow]\nsize = 128\n\
    [[light]]\nname = 'sun'\nkind = 'directional'\ndirection = [0, -1, 0]\n";

/// A pane above the origin that covers half, with (1, 0.2, 0.1).
const GLASS: &str = "[[material]]\nname = 'glass'\ntint = [1, 0.2, 0.1, 0.5]\n\
    [[shape]]\nkind = 'pane'\nmaterial = 'glass'\ntranslation = [0, 3, 0]\nrotation = [90, 0, 0]\n\
    scale = [4, 4, 1]\n";

/// Light left behind it.
const BEHIND: Vec3 = Vec3::new(1.0, 0.6, 0.55);

/// Tolerance of light in 12 bits, after two hits.
const LIGHT: f32 = 1e-3;

/// Needles, pancakes and a ball, rotated in all directions.
fn shapes() -> Vec<Stored> {
    let sigmas = [[0.5, 0.01, 0.01], [0.3, 0.3, 0.005], [0.1, 0.1, 0.1], [0.001, 0.4, 0.02]];
    let turns = [[0.9, 0.3, 0.2, -0.2], [0.5, -0.5, 0.6, 0.3], [0.1, 0.9, 0.1, 0.4]];
    let all = sigmas.iter().flat_map(|&sigma| turns.map(|rotation| (sigma, rotation)));
    all.map(|(sigma, rotation)| Stored { sigma, rotation, opacity: 0.95, ..SPLATS[0] }).collect()
}

fn relit(folder: &Folder, scene: &str, out: &str, more: &[&str]) -> SplatCloud {
    fs::write(folder.0.join("lit.toml"), scene).unwrap();
    let arguments = ["relight", "in.ply", "--scene", "lit.toml", "-o", out, "--backend", "cpu"];
    assert_eq!(folder.run(&[&arguments, more].concat()), format!("{out}\n"));
    load_splats(&folder.0.join(out)).unwrap()
}

fn put(folder: &Folder, stored: &[Stored]) -> SplatCloud {
    let path = folder.0.join("in.ply");
    fs::write(&path, ply("binary_little_endian", stored, 0)).unwrap();
    load_splats(&path).unwrap()
}

/// A colour and its coefficient are a few roundings apart.
fn assert_colors(read: &SplatCloud, wanted: impl Fn(usize) -> Vec3, most: f32) {
    for (i, splat) in read.splats.iter().enumerate() {
        let far = (splat.color - wanted(i)).abs().max_element();
        assert!(far <= most, "splat {i}: {}, wanted {}", splat.color, wanted(i));
    }
}

#[test]
fn a_lone_splat_keeps_its_colour() {
    let folder = Folder::new("relight-lone");
    let sun = SUN.replace("[0, -1, 0]", "[-0.4, -1, 0.7]");
    let spot = SUN.replace("'directional'", "'spot'\nposition = [0.3, 4, 1]");
    let point =
        SUN.replace("'directional'\ndirection = [0, -1, 0]", "'point'\nposition = [1, 2, 0.5]");
    for stored in shapes() {
        let before = put(&folder, &[stored]);
        for scene in [&sun, &spot, &point] {
            let after = relit(&folder, scene, "out.ply", &[]);
            assert_colors(&after, |i| before.splats[i].color, 1e-6);
            assert_eq!(after.splats[0].sigma, before.splats[0].sigma);
        }
    }
}

#[test]
fn glass_and_walls_colour_splats() {
    let folder = Folder::new("relight-glass");
    let mut stored = SPLATS.to_vec();
    // Two under the glass, so far apart that neither shades the other, and one outside.
    stored[1].center = [1.0, 0.0, 0.5];
    stored[2].center = [6.0, 0.0, 0.0];
    let before = put(&folder, &stored);
    let share = |i: usize| if i == 2 { Vec3::ONE } else { BEHIND };
    let scene = format!("{SUN}{GLASS}");
    for (out, most) in [("out.ply", LIGHT), ("out.spz", 0.015)] {
        let after = relit(&folder, &scene, out, &[]);
        assert_colors(&after, |i| before.splats[i].color * share(i), most);
    }
    // As much ambient light as sunlight, for a particle: half of the share.
    let around = ["--set", "environment.ambient=[0.2387325, 0.2387325, 0.2387325]"];
    let after = relit(&folder, &scene, "out.ply", &around);
    assert_colors(&after, |i| before.splats[i].color * (share(i) + 1.0) * 0.5, LIGHT);
    // A second lamp, red, which no glass shades: two thirds of red light are the sun's.
    let lamp = "[[light]]\nname = 'red'\nkind = 'directional'\ndirection = [0, 1, 0]\n\
        color = [0, 1, 0]\nintensity = 1.5\n";
    let after = relit(&folder, &(SUN.to_owned() + lamp + GLASS), "out.ply", &[]);
    let mixed = |i: usize| Vec3::new(share(i).x, (share(i).y * 2.0 + 1.0) / 3.0, share(i).z);
    assert_colors(&after, |i| before.splats[i].color * mixed(i), LIGHT);
    let wall = scene.replace("tint = [1, 0.2, 0.1, 0.5]", "transfer = 'opaque'");
    let after = relit(&folder, &wall, "out.ply", &[]);
    assert_colors(&after, |i| if i == 2 { before.splats[i].color } else { Vec3::ZERO }, LIGHT);
}

/// Each coefficient is multiplied by the light of its channel, in every format.
#[test]
fn harmonics_are_lit_with_the_colour() {
    let folder = Folder::new("relight-harmonics");
    let mut stored = SPLATS.to_vec();
    stored[1].center = [1.0, 0.0, 0.5];
    stored[2].center = [6.0, 0.0, 0.0];
    fs::write(folder.0.join("in.ply"), ply("binary_little_endian", &stored, 24)).unwrap();
    let before = load_splats(&folder.0.join("in.ply")).unwrap();
    let share = |i: usize| if i == 2 { Vec3::ONE } else { BEHIND };
    for (out, most) in [("out.ply", LIGHT), ("out.spz", 0.015), ("out.sog", LIGHT)] {
        let after = relit(&folder, &format!("{SUN}{GLASS}"), out, &[]);
        assert_colors(&after, |i| before.splats[i].color * share(i), most);
        let harmonics = load_harmonics(&folder.0.join(out)).unwrap().unwrap();
        assert_eq!(harmonics.count, 8);
        for (i, rgb) in (0..3).flat_map(|i| harmonics.of(i).iter().map(move |rgb| (i, rgb))) {
            let far = (Vec3::from_array(*rgb) - 0.125 * share(i)).abs().max_element();
            assert!(far <= most, "{out}, splat {i}: {rgb:?}");
        }
    }
}

/// A splat shades one below it by its alpha; the scene places both.
#[test]
fn splats_shade_each_other_where_the_scene_places_them() {
    let folder = Folder::new("relight-self");
    let ball = Stored { sigma: [0.2; 3], opacity: 0.6, ..SPLATS[0] };
    let lower = Stored { center: [0.0, 0.0, 3.0], ..ball };
    let before = put(&folder, &[ball, lower]);
    // Unchanged, side by side.
    let after = relit(&folder, SUN, "out.ply", &[]);
    assert_colors(&after, |i| before.splats[i].color, 1e-6);
    // Turned about x, the second is 3 m below.
    let table = "[[splats]]\nfile = 'in.ply'\nrotation = [90, 0, 0]\n";
    let after = relit(&folder, &format!("{SUN}{table}"), "out.ply", &[]);
    // Within a texel of the upper one's centre.
    let wanted = |i: usize| before.splats[i].color * if i == 1 { 0.4 } else { 1.0 };
    assert_colors(&after, wanted, 0.01);
    assert_eq!(after.splats[1].center, before.splats[1].center, "written as in the file");
    // Splats that cast nothing shade nothing.
    let silent = table.replace("rotation", "cast = 'none'\nrotation");
    let after = relit(&folder, &format!("{SUN}{silent}"), "out.ply", &[]);
    assert_colors(&after, |i| before.splats[i].color, 1e-6);
}

#[test]
fn what_cannot_be_written_is_refused_before_any_work() {
    let folder = Folder::new("relight-refused");
    put(&folder, &SPLATS);
    fs::write(folder.0.join("lit.toml"), SUN).unwrap();
    let refused = |splats: &str, scene: &str, out: &str, words: &str| {
        let output =
            folder.gobo(&["relight", splats, "--scene", scene, "-o", out, "--backend", "cpu"]);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains(words) && text.contains("help:"), "{text}");
        assert!(!folder.0.join(out).exists(), "{out} was written");
    };
    refused("in.ply", "lit.toml", "out.splat", ".ply, .spz or .sog");
    refused("in.ply", "lit.toml", "out", ".ply, .spz or .sog");
    refused("none.ply", "lit.toml", "out.ply", "none.ply");
    refused("lit.toml", "lit.toml", "out.ply", "no splats");
    fs::write(folder.0.join("cut.splat"), &bare(&SPLATS)[..40]).unwrap();
    refused("cut.splat", "lit.toml", "out.ply", "cut.splat");
    fs::write(folder.0.join("bad.toml"), "[[splats]]\nfile = 'cut.splat'\n").unwrap();
    refused("in.ply", "bad.toml", "out.ply", "bad.toml:2");
}
