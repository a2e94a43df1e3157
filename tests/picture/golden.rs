//! The lit picture: kernels against the CPU reference, and both against reviewed pictures.
use crate::common::{TIERS, Tier, files::read, reference_picture, render, tiers};
use gobo::records::Picture;
use gobo_scene as scene;
use gobo_scene::Scene;
use nv_flip::{FlipImageRgb8, FlipPool};
use std::path::PathBuf;

const SCENES: [&str; 5] = ["smoke", "glass", "box", "mixed", "cascades"];

/// Mean FLIP error (Andersson et al. 2020) below which two pictures look the same; a different driver rounds
/// a few channels differently, which stays below a tenth of it.
const LOOKS_THE_SAME: f32 = 0.01;

/// Largest difference between CPU reference and kernel by rounding, in steps of 8 bits.
const ROUNDED: u8 = 4;
/// Share of the channels that may differ by more: pixels whose ray grazes an edge.
const GRAZED: f64 = 1e-3;

fn file(path: &str) -> PathBuf {
    crate::common::root().join(path)
}

/// Small, so that the CPU reference is fast.
fn small(name: &str) -> Scene {
    let set = [("camera.size", "[240, 135]"), ("camera.samples", "1"), ("shadow.size", "256")]
        .map(|(key, value)| (key.to_owned(), value.to_owned()));
    scene::load_with(&file(&format!("data/{name}.toml")), &set)
        .unwrap_or_else(|error| panic!("{error}"))
}

fn share_apart(a: &Picture, b: &Picture) -> f64 {
    assert_eq!(a.size, b.size);
    let channels = a.rgb.iter().flatten().zip(b.rgb.iter().flatten());
    let apart = channels.filter(|(a, b)| a.abs_diff(**b) > ROUNDED).count();
    apart as f64 / (3 * a.rgb.len()) as f64
}

fn flip(a: &Picture, b: &Picture) -> f32 {
    let image = |picture: &Picture| {
        let bytes: Vec<u8> = picture.rgb.iter().flatten().copied().collect();
        FlipImageRgb8::with_data(picture.size.x, picture.size.y, &bytes)
    };
    let errors = nv_flip::flip(image(a), image(b), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    FlipPool::from_image(&errors).mean()
}

fn golden(name: &str) -> Picture {
    let path = file(&format!("tests/picture/golden/{name}.png"));
    let image = image::open(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let image = image.into_rgb8();
    let size = image.dimensions().into();
    Picture { size, rgb: image.pixels().map(|pixel| pixel.0).collect(), light: Vec::new() }
}

#[test]
fn kernels_match_the_reference() {
    for name in SCENES {
        let scene = small(name);
        let expected = reference_picture(&scene);
        for tier in TIERS {
            let apart = share_apart(&render(tier, &scene).picture, &expected);
            assert!(apart <= GRAZED, "{name}, {tier:?}: {apart} of the channels");
        }
    }
}

#[test]
fn pictures_look_as_they_did() {
    for name in SCENES {
        let error = flip(&render(TIERS[1], &small(name)).picture, &golden(name));
        assert!(error < LOOKS_THE_SAME, "{name}: FLIP {error}");
    }
}

/// A lamp in a closed box: the faces of its cube meet without a gap.
#[test]
fn no_light_leaks_through_seams() {
    let lamp = "[camera]\neye = [0.1, 9, 4]\ntarget = [0, 0, 0]\nsize = [240, 135]\n\
        [shadow]\nsize = 64\n[environment]\nambient = [0, 0, 0]\nbackground = [0, 0, 0]\n\
        [[light]]\nkind = 'point'\nposition = [0, 1, 0]\nintensity = 100\n\
        [[material]]\nname = 'iron'\ntransfer = 'opaque'\n\
        [[shape]]\nkind = 'plane'\nmaterial = 'iron'\nscale = [10, 1, 10]\n";
    let closed =
        format!("{lamp}[[shape]]\nkind = 'box'\nmaterial = 'iron'\ntranslation = [0, 1, 0]\n");
    let brightest = |picture: &Picture| picture.rgb.iter().flatten().copied().max();
    let (open, closed) = (read(lamp).unwrap(), read(&closed).unwrap());
    assert!(brightest(&reference_picture(&open)) > Some(99));
    assert_eq!(brightest(&reference_picture(&closed)), Some(0));
    for tier in tiers(Tier::Native) {
        assert_eq!(brightest(&render(tier, &closed).picture), Some(0), "{tier:?}");
    }
}

#[test]
fn a_missing_light_is_noticed() {
    let whole = small("mixed");
    let mut darker = whole.clone();
    darker.lights.truncate(1);
    let picture = render(TIERS[1], &darker).picture;
    assert!(share_apart(&picture, &reference_picture(&whole)) > GRAZED);
    assert!(flip(&picture, &golden("mixed")) > LOOKS_THE_SAME);
}

#[test]
fn a_missing_pane_is_noticed() {
    let mut fewer = small("glass");
    let red = fewer.materials.iter().position(|m| m.name == "red").expect("red glass") as u32;
    fewer.triangles.retain(|triangle| triangle.material != red);
    let picture = render(TIERS[1], &fewer).picture;
    assert!(flip(&picture, &golden("glass")) > LOOKS_THE_SAME);
}
