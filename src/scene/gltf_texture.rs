//! glTF images as the textures that casters sample: base colour, with transmission multiplied in.
use super::{SceneError, gltf_file::File, particles::linear_from_srgb};
use crate::model::Texture;
use image::{ImageReader, RgbaImage, imageops::FilterType};
use std::{collections::HashMap, io::Cursor};

/// Longest side of an image [texels].
const MAX_SIDE: u32 = 16384;

/// Base colour, transmission, opaque, square root.
type Key = (Option<usize>, Option<usize>, bool, bool);

#[derive(Debug)]
pub(super) struct Textures<'a> {
    file: &'a File,
    pub(super) textures: Vec<Texture>,
    known: HashMap<Key, u32>,
    images: HashMap<usize, RgbaImage>,
}

impl<'a> Textures<'a> {
    pub(super) fn new(file: &'a File) -> Self {
        Self { file, textures: Vec::new(), known: HashMap::new(), images: HashMap::new() }
    }

    /// Index of the product of `base` and the red of `transmission`. `is_opaque` sets alpha to one;
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
        let name = first.name().map_or_else(|| format!("image {}", first.index()), str::to_owned);
        let base = base.map(|image| self.decode(&image)).transpose()?;
        let filter = transmission.map(|image| self.decode(&image)).transpose()?;
        let mut pixels = match (base, filter) {
            (Some(base), Some(filter)) => multiply(base, filter),
            (Some(base), None) => base,
            (None, Some(filter)) => {
                let white = image::Rgba([255; 4]);
                let base = RgbaImage::from_pixel(filter.width(), filter.height(), white);
                multiply(base, filter)
            }
            (None, None) => return Ok(None),
        };
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
        Ok(Some(id))
    }

    /// 0..=1.
    pub(super) fn mean_green(&mut self, image: &gltf::Image<'_>) -> Result<f32, SceneError> {
        let pixels = self.decode(image)?;
        let sum: f64 = pixels.pixels().map(|pixel| f64::from(pixel.0[1])).sum();
        Ok((sum / 255.0 / f64::from(pixels.width()) / f64::from(pixels.height())) as f32)
    }

    fn decode(&mut self, image: &gltf::Image<'_>) -> Result<RgbaImage, SceneError> {
        if let Some(pixels) = self.images.get(&image.index()) {
            return Ok(pixels.clone());
        }
        let bad = |problem: String| {
            let message = format!("image {}: {problem}", image.index());
            self.file.invalid(message, "use a PNG or JPEG of at most 16384 texels a side")
        };
        // Not `Image::source`, which panics where the file gives neither a type nor a place.
        let document = &self.file.document;
        let json = &document.as_json().images[image.index()];
        let view = json.buffer_view.and_then(|index| document.views().nth(index.value()));
        let bytes = match (view, &json.uri) {
            (Some(view), _) => self.file.view(&view)?.to_vec(),
            (None, Some(uri)) => self.file.read_uri(uri)?,
            (None, None) => return Err(bad("has neither a bufferView nor a uri".to_owned())),
        };
        let mut reader = ImageReader::new(Cursor::new(bytes))
            .with_guessed_format()
            .map_err(|error| bad(error.to_string()))?;
        let mut limits = image::Limits::default();
        limits.max_image_width = Some(MAX_SIDE);
        limits.max_image_height = Some(MAX_SIDE);
        reader.limits(limits);
        let pixels = reader.decode().map_err(|error| bad(error.to_string()))?.into_rgba8();
        if pixels.is_empty() {
            return Err(bad("has no texels".to_owned()));
        }
        self.images.insert(image.index(), pixels.clone());
        Ok(pixels)
    }
}

/// `base` times the red of `filter`, at the larger size. `base` is sRGB, `filter` linear.
fn multiply(base: RgbaImage, filter: RgbaImage) -> RgbaImage {
    let width = base.width().max(filter.width());
    let height = base.height().max(filter.height());
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
