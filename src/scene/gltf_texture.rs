//! glTF images as textures of casters: base colour, with transmission multiplied in.
use super::{SceneError, gltf_file::File, images, limits::Limit, particles::linear_from_srgb};
use crate::model::Texture;
use image::{RgbaImage, imageops::FilterType};
use std::collections::HashMap;

/// Longest side of an image [texels].
pub(super) const MAX_SIDE: u32 = 16384;

/// Image of the base colour, image of the transmission, opaque, square root.
type Key = (Option<usize>, Option<usize>, bool, bool);

#[derive(Debug)]
pub(super) struct Textures<'a> {
    file: &'a File,
    pub(super) textures: Vec<Texture>,
    known: HashMap<Key, u32>,
    means: HashMap<usize, [f32; 4]>,
    /// Textures that the scene had before.
    earlier: usize,
    /// Texels of all textures of the scene.
    texels: u64,
}

impl<'a> Textures<'a> {
    /// `earlier` and `texels`: textures that the scene has already.
    pub(super) fn new(file: &'a File, earlier: usize, texels: u64) -> Self {
        let (textures, known, means) = (Vec::new(), HashMap::new(), HashMap::new());
        Self { file, textures, known, means, earlier, texels }
    }

    /// Index of the product of `base` and the red channel of `transmission`. `is_opaque` sets alpha to one;
    /// `is_face` takes the square root of the colour, for one of the two faces of a body.
    pub(super) fn add(
        &mut self,
        base: Option<gltf::Image<'_>>,
        transmission: Option<gltf::Image<'_>>,
        is_opaque: bool,
        is_face: bool,
    ) -> Result<Option<u32>, SceneError> {
        let Some(first) = base.as_ref().or(transmission.as_ref()) else { return Ok(None) };
        let index = |image: &gltf::Image<'_>| image.index();
        let key = (base.as_ref().map(index), transmission.as_ref().map(index), is_opaque, is_face);
        if let Some(known) = self.known.get(&key) {
            return Ok(Some(*known));
        }
        let count = (self.earlier + self.textures.len()) as u64;
        Limit::Textures.grown_in(&self.file.path, count, 1)?;
        let name = first.name().map_or_else(|| format!("image {}", first.index()), str::to_owned);
        let before = self.texels;
        let base = base.map(|image| self.decode(&image)).transpose()?;
        let filter = transmission.map(|image| self.decode(&image)).transpose()?;
        let mut pixels = match (base, filter) {
            (Some(base), Some(filter)) => {
                let (width, height) = common_size(&base, &filter);
                let texels = u64::from(width) * u64::from(height);
                self.texels = Limit::Texels.grown_in(&self.file.path, before, texels)?;
                multiply(base, filter)
            }
            (Some(base), None) => base,
            (None, Some(filter)) => {
                let white = image::Rgba([255; 4]);
                let base = RgbaImage::from_pixel(filter.width(), filter.height(), white);
                multiply(base, filter)
            }
            (None, None) => return Ok(None),
        };
        let is_solid = pixels.pixels().all(|pixel| pixel.0[3] == 255);
        let roots: [u8; 256] =
            std::array::from_fn(|c| srgb_byte(linear_from_srgb(c as f32 / 255.0).sqrt()));
        for pixel in pixels.pixels_mut() {
            if is_face {
                for channel in &mut pixel.0[..3] {
                    *channel = roots[usize::from(*channel)];
                }
            }
            if is_opaque {
                pixel.0[3] = 255;
            }
        }
        let (width, height) = pixels.dimensions();
        let id = self.textures.len() as u32;
        self.textures.push(Texture { name, width, height, rgba: pixels.into_raw() });
        self.known.insert(key, id);
        if is_solid {
            let (base, transmission, _, is_face) = key;
            self.known.insert((base, transmission, !is_opaque, is_face), id);
        }
        Ok(Some(id))
    }

    /// Mean of each channel as stored, 0..=1.
    pub(super) fn means(&mut self, image: &gltf::Image<'_>) -> Result<[f32; 4], SceneError> {
        if let Some(known) = self.means.get(&image.index()) {
            return Ok(*known);
        }
        let before = self.texels;
        let pixels = self.decode(image)?;
        // The image is not kept.
        self.texels = before;
        let mut sums = [0.0; 4];
        for pixel in pixels.pixels() {
            for (sum, channel) in sums.iter_mut().zip(pixel.0) {
                *sum += f64::from(channel);
            }
        }
        let texels = f64::from(pixels.width()) * f64::from(pixels.height());
        let means = sums.map(|sum| (sum / 255.0 / texels) as f32);
        self.means.insert(image.index(), means);
        Ok(means)
    }

    fn decode(&mut self, image: &gltf::Image<'_>) -> Result<RgbaImage, SceneError> {
        let bad = |problem: &str, help: &str| {
            self.file.invalid(format!("image {}: {problem}", image.index()), help)
        };
        let bytes = self.file.image(image)?;
        images::decode(&bytes, MAX_SIDE, &mut self.texels)
            .map_err(|(problem, help)| bad(&problem, &help))
    }
}

fn common_size(a: &RgbaImage, b: &RgbaImage) -> (u32, u32) {
    (a.width().max(b.width()), a.height().max(b.height()))
}

/// Multiplies `base` by the red channel of `filter`, at the larger size. `base` is sRGB, `filter` linear.
fn multiply(base: RgbaImage, filter: RgbaImage) -> RgbaImage {
    let (width, height) = common_size(&base, &filter);
    let fit = |image: RgbaImage| {
        if image.dimensions() == (width, height) {
            return image;
        }
        image::imageops::resize(&image, width, height, FilterType::Triangle)
    };
    let (mut base, filter) = (fit(base), fit(filter));
    for (pixel, filter) in base.pixels_mut().zip(filter.pixels()) {
        let factor = f32::from(filter.0[0]) / 255.0;
        for channel in &mut pixel.0[..3] {
            *channel = srgb_byte(linear_from_srgb(f32::from(*channel) / 255.0) * factor);
        }
    }
    base
}

fn srgb_byte(c: f32) -> u8 {
    let srgb = if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (srgb * 255.0).round() as u8
}
