//! Screenshot of the window.
use eframe::egui::ColorImage;
use std::{collections::BTreeSet, fs::File, io::BufWriter, path::Path};

/// Least number of colours in a picture of a scene.
const FEWEST_COLORS: usize = 64;

pub fn save(path: &Path, image: &ColorImage) -> Result<(), String> {
    let text = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let file = BufWriter::new(File::create(path).map_err(|error| text(&error))?);
    let [width, height] = image.size.map(|edge| edge as u32);
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    let rgb: Vec<[u8; 3]> = image.pixels.iter().map(|&pixel| rgb(pixel)).collect();
    let mut writer = encoder.write_header().map_err(|error| text(&error))?;
    writer.write_image_data(rgb.as_flattened()).map_err(|error| text(&error))?;
    writer.finish().map_err(|error| text(&error))
}

fn rgb(pixel: eframe::egui::Color32) -> [u8; 3] {
    [pixel.r(), pixel.g(), pixel.b()]
}

/// Checks that a picture of a scene is not blank.
pub fn check(name: &str, image: &ColorImage) -> Result<(), String> {
    let colors: BTreeSet<_> = image.pixels.iter().map(|&pixel| rgb(pixel)).collect();
    match colors.len() {
        0..FEWEST_COLORS => Err(format!("{name} is flat: it has {} colours", colors.len())),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::Color32;

    #[test]
    fn a_flat_picture_is_refused_and_a_ramp_is_not() {
        let flat = ColorImage::new([16, 16], vec![Color32::GRAY; 256]);
        assert!(check("it", &flat).is_err());
        let ramp = (0..=255).map(Color32::from_gray).collect();
        assert_eq!(check("it", &ColorImage::new([16, 16], ramp)), Ok(()));
    }
}
