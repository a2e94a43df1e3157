//! Picture of the window.
use crate::{failure::Failure, maps, output};
use eframe::egui::{Color32, ColorImage};
use image::{DynamicImage, RgbImage};
use std::{collections::BTreeSet, path::Path};

/// Least number of colours in a picture of a scene.
const FEWEST_COLORS: usize = 64;

fn rgb(pixel: Color32) -> [u8; 3] {
    [pixel.r(), pixel.g(), pixel.b()]
}

pub(super) fn save(path: &Path, image: &ColorImage) -> Result<(), Failure> {
    let [width, height] = image.size.map(|edge| edge as u32);
    let bytes: Vec<u8> = image.pixels.iter().flat_map(|&pixel| rgb(pixel)).collect();
    let image = RgbImage::from_raw(width, height, bytes);
    let image = DynamicImage::from(image.expect("a picture has all its pixels"));
    output::write(path, &maps::png(&image))
}

/// Checks that a picture of a scene is not blank.
pub(super) fn check(name: &str, image: &ColorImage) -> Result<(), Failure> {
    let colors: BTreeSet<_> = image.pixels.iter().map(|&pixel| rgb(pixel)).collect();
    match colors.len() {
        count @ 0..FEWEST_COLORS => {
            Err(Failure::Wrong(format!("{name} is flat: it has {count} colours")))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_picture_is_refused_and_a_ramp_is_not() {
        let flat = ColorImage::new([16, 16], vec![Color32::GRAY; 256]);
        assert!(check("it", &flat).is_err());
        let ramp = (0..=255).map(Color32::from_gray).collect();
        assert!(check("it", &ColorImage::new([16, 16], ramp)).is_ok());
    }
}
