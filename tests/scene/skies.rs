//! Environment images: `OpenEXR`, written after its description, byte by byte, and Radiance.
use crate::common::files::Folder;
use gobo::glam::Vec3;
use gobo_scene as scene;
use gobo_scene::{Scene, SceneError};

/// Texels of 8 x 4, in eighths, which both formats can express.
fn texel(x: usize, y: usize) -> [f32; 3] {
    [1.0 + x as f32 / 8.0, 1.0 + y as f32 / 8.0, 1.5]
}

/// Version 2 with scan lines of uncompressed floats.
fn exr() -> Vec<u8> {
    let mut file = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        file.extend(format!("{name}\0{kind}\0").bytes());
        file.extend((value.len() as u32).to_le_bytes());
        file.extend(value);
    };
    let mut channels = Vec::new();
    for name in ["B", "G", "R"] {
        channels.extend(format!("{name}\0").bytes());
        channels.extend([2_u32, 0, 1, 1].iter().flat_map(|word| word.to_le_bytes()));
    }
    channels.push(0);
    let window: Vec<u8> = [0_u32, 0, 7, 3].iter().flat_map(|word| word.to_le_bytes()).collect();
    attribute("channels", "chlist", &channels);
    attribute("compression", "compression", &[0]);
    attribute("dataWindow", "box2i", &window);
    attribute("displayWindow", "box2i", &window);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1_f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1_f32.to_le_bytes());
    file.push(0);
    let (line, start) = (8 + 8 * 12, file.len() + 4 * 8);
    file.extend((0..4).flat_map(|y| ((start + y * line) as u64).to_le_bytes()));
    for y in 0..4 {
        file.extend((y as u32).to_le_bytes());
        file.extend((8 * 12_u32).to_le_bytes());
        for channel in [2, 1, 0] {
            file.extend((0..8).flat_map(|x| texel(x, y)[channel].to_le_bytes()));
        }
    }
    file
}

/// Mantissas of 8 bits with an exponent of 1: steps of a 128th.
fn hdr() -> Vec<u8> {
    let mut file = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    for y in 0..4 {
        // Without runs, for which only widths below 8 are too short.
        file.extend([2, 2, 0, 8]);
        for channel in 0..3 {
            file.push(8);
            file.extend((0..8).map(|x| (texel(x, y)[channel] * 64.0) as u8));
        }
        file.push(8);
        file.extend([130; 8]);
    }
    file
}

fn load(name: &str, image: &[u8]) -> Result<Scene, SceneError> {
    let folder = Folder::new();
    folder.write(name, image);
    let text = format!(
        "[environment]\nfile = \"{name}\"\n[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\n"
    );
    scene::load(&folder.write("s.toml", text))
}

#[test]
fn both_formats_give_the_same_light() {
    let [a, b] =
        [("e.exr", exr()), ("e.hdr", hdr())].map(|(name, image)| load(name, &image).unwrap());
    let (a, b) = (a.mean_ambient(), b.mean_ambient());
    assert!((a - b).length() < 1e-5, "{a} {b}");
    // Weighted by area the rows are symmetric: the mean of y is 1.5 rows.
    assert!((a.y - (1.0 + 1.5 / 8.0)).abs() < 0.02 && (a.z - 1.5).abs() < 0.02, "{a}");
}

#[test]
fn what_is_no_light_is_none() {
    let mut image = exr();
    let last = image.len() - 4;
    for value in [f32::NAN, -5.0, f32::NEG_INFINITY] {
        image[last..].copy_from_slice(&value.to_le_bytes());
        let mean = load("e.exr", &image).unwrap().mean_ambient();
        assert!(mean.is_finite() && mean.cmpgt(Vec3::ZERO).all(), "{value}: {mean}");
    }
}

#[test]
fn damaged_images_are_refused() {
    let image = exr();
    for length in (0..image.len()).step_by(3) {
        let error = load("e.exr", &image[..length]).unwrap_err();
        assert!(error.help().is_some(), "{error}");
    }
    let at = image.windows(4).position(|word| word == 7_u32.to_le_bytes()).unwrap();
    let mut wide = image;
    wide[at..at + 4].copy_from_slice(&0x7fff_fff0_u32.to_le_bytes());
    assert!(load("e.exr", &wide).is_err());
}
