//! `source` and `filter` of a light: valid values, and errors.
use crate::common::files::read;
use gobo::{
    glam::Vec3,
    model::{LookUp, MaskSettings, ShadowFilter, Source},
};
use gobo_scene::{Scene, SceneError};

const SPOT: &str =
    "[[light]]\nkind = \"spot\"\nposition = [0, 2, 0]\ndirection = [0, -2, 0]\nsource = ";
const LAMP: &str = "[[light]]\nkind = \"point\"\nposition = [0, 2, 0]\nsource = ";
const SUN: &str = "[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0]\nsource = ";

fn light_of(head: &str, source: &str) -> Result<Scene, SceneError> {
    read(&format!("{head}{source}\n"))
}

#[test]
fn sources_are_read() {
    let down = Vec3::NEG_Y;
    let rect = Source::Rect { width: 0.4, height: 0.2, direction: down };
    for (head, source, expected) in [
        (SPOT, "{ kind = \"sphere\", radius = 0.1 }", Source::Sphere { radius: 0.1 }),
        (SPOT, "{ kind = \"disc\", radius = 0.1 }", Source::Disc { radius: 0.1, direction: down }),
        (SPOT, "{ kind = \"rect\", width = 0.4, height = 0.2 }", rect),
        (LAMP, "{ kind = \"sphere\", radius = 0 }", Source::Sphere { radius: 0.0 }),
        (LAMP, "{ kind = \"rect\", width = 0.4, height = 0.2 }\ndirection = [0, -3, 0]", rect),
        (SUN, "{ kind = \"sun\", angle = 2 }", Source::Sun { angle: 2f32.to_radians() }),
        (SUN, "{ kind = \"sun\" }", Source::Sun { angle: 0.53f32.to_radians() }),
    ] {
        let scene = light_of(head, source).unwrap_or_else(|error| panic!("{source}: {error}"));
        assert_eq!(scene.lights[0].source, Some(expected), "{source}");
        assert!(scene.lights[0].check(0).is_ok());
    }
    let none = read(&SUN[..SUN.len() - "source = ".len()]).unwrap();
    assert_eq!(none.lights[0].source, None);
}

#[test]
fn what_is_no_source_is_refused_with_a_remedy() {
    for (head, source, said) in [
        (SPOT, "{ kind = \"spere\", radius = 0.1 }", "sphere"),
        (SPOT, "{ kind = \"disc\", radios = 0.1 }", "radius"),
        (SPOT, "{ kind = \"disc\" }", "radius"),
        (SPOT, "{ kind = \"disc\", radius = -0.1 }", "0 to 1e4"),
        (SPOT, "{ kind = \"disc\", radius = inf }", "0 to 1e4"),
        (SPOT, "{ kind = \"rect\", width = nan, height = 1 }", "0 to 1e4"),
        (SPOT, "{ kind = \"rect\", width = 1, height = 2e4 }", "0 to 1e4"),
        (SPOT, "{ kind = \"sun\", angle = 1 }", "sphere"),
        (SUN, "{ kind = \"sphere\", radius = 1 }", "sun"),
        (SUN, "{ kind = \"sun\", angle = -1 }", "0 to 60"),
        (SUN, "{ kind = \"sun\", angle = 61 }", "0 to 60"),
        (SUN, "0.53", "table"),
        (LAMP, "{ kind = \"disc\", radius = 0.1 }", "direction"),
        (LAMP, "{ kind = \"sphere\", radius = 0.1 }\ndirection = [0, -1, 0]", "direction"),
    ] {
        match light_of(head, source) {
            Err(SceneError::Document { message, help, line, .. }) => {
                let help = help.unwrap_or_default();
                assert!(!help.is_empty() && line > 0, "{source}: {message}");
                assert!((message.clone() + &help).contains(said), "{source}: {message}; {help}");
            }
            other => panic!("{source}: {:?}", other.map(|scene| scene.lights)),
        }
    }
}

#[test]
fn filters_are_read() {
    let pcf = ShadowFilter::Pcf { taps: 5 };
    for (text, expected) in [
        ("{ kind = \"none\" }", ShadowFilter::None),
        ("{ kind = \"bilinear\" }", ShadowFilter::Bilinear),
        ("{ kind = \"spline\" }", ShadowFilter::Spline),
        ("{ kind = \"pcf\" }", pcf),
        ("{ kind = \"pcf\", taps = 11 }", ShadowFilter::Pcf { taps: 11 }),
        ("{ kind = \"vogel\" }", ShadowFilter::Vogel { taps: 16, radius: 2.5 }),
        (
            "{ kind = \"vogel\", taps = 64, radius = 32 }",
            ShadowFilter::Vogel { taps: 64, radius: 32.0 },
        ),
    ] {
        let scene = read(&format!("[shadow]\nfilter = {text}\n")).unwrap();
        assert_eq!(scene.shadow.filter, expected, "{text}");
    }
    let sun = SUN.trim_end_matches("source = ");
    let keys = "filter = { kind = \"pcf\" }\nbias = 0.5\nslope_bias = 2\nnormal_bias = 3\n";
    let scene = read(&format!("[shadow]\nslope_bias = 1\n{sun}{keys}")).unwrap();
    assert_eq!((scene.shadow.filter, scene.shadow.slope_bias), (ShadowFilter::Spline, 1.0));
    let own = LookUp {
        filter: Some(pcf),
        bias: Some(0.5),
        slope_bias: Some(2.0),
        normal_bias: Some(3.0),
    };
    assert_eq!(scene.lights[0].look_up, own);
}

#[test]
fn what_is_no_filter_is_refused_with_a_remedy() {
    for (filter, said) in [
        ("\"pcf\"", "table"),
        ("{ kind = \"pfc\" }", "pcf"),
        ("{ kind = \"pcf\", tabs = 1 }", "taps"),
        ("{ kind = \"pcf\", taps = 1 }", "2 to 11"),
        ("{ kind = \"pcf\", taps = 12 }", "2 to 11"),
        ("{ kind = \"vogel\", taps = 0 }", "1 to 64"),
        ("{ kind = \"vogel\", taps = 65 }", "1 to 64"),
        ("{ kind = \"vogel\", radius = nan }", "0 to 32"),
        ("{ kind = \"vogel\", radius = 33 }", "0 to 32"),
    ] {
        let lit = SUN.trim_end_matches("source = ");
        for head in ["[shadow]\n", lit] {
            match read(&format!("{head}filter = {filter}\n")) {
                Err(SceneError::Document { message, help, line, .. }) => {
                    let said_all = message + &help.unwrap_or_default();
                    assert!(line > 0 && said_all.contains(said), "{filter}: {said_all}");
                }
                other => panic!("{filter}: {:?}", other.map(|scene| scene.lights)),
            }
        }
    }
}

#[test]
fn samples_are_1_to_64() {
    for samples in [1, 64] {
        assert_eq!(read(&format!("[camera]\nsamples = {samples}\n")).unwrap().samples, samples);
    }
    assert_eq!(read("[camera]\n").unwrap().samples, 4);
    assert_eq!(read("").unwrap().samples, 4);
    for wrong in [0, 65] {
        let error = read(&format!("[camera]\nsamples = {wrong}\n")).unwrap_err().to_string();
        assert!(error.contains("samples is"), "{error}");
    }
}

#[test]
fn masks_are_read() {
    assert_eq!(read("[camera]\n").unwrap().mask, None);
    let usual = MaskSettings::default();
    assert_eq!(read("[mask]\n").unwrap().mask, Some(usual));
    let text = "[mask]\nhalf = true\ntaps = 11\ndepth_scale = 4\nanisotropic = true\nsensitivity = 50\n\
        limit = 3\n";
    let own = MaskSettings {
        half: true,
        taps: 11,
        depth_scale: 4.0,
        anisotropic: true,
        sensitivity: 50.0,
        limit: 3,
    };
    assert_eq!(read(text).unwrap().mask, Some(own));
    for wrong in ["taps = 2", "taps = 17", "taps = 0", "limit = 0", "limit = 65", "half = 2"] {
        assert!(read(&format!("[mask]\n{wrong}\n")).is_err(), "{wrong}");
    }
    let error = read("[mask]\ntaps = 1\nanisotropic = true\n").unwrap_err().to_string();
    assert!(error.contains("there is no blur: taps is 1"), "{error}");
    assert!(read("[mask]\nanisotropic = 1\n").is_err());
    for wrong in ["sensitivity = -1", "depth_scale = nan", "depth_scale = 2e6"] {
        assert!(read(&format!("[mask]\n{wrong}\n")).is_err(), "{wrong}");
    }
}
