//! glTF images as textures of casters: base colour, with transmission and metal multiplied in.
use super::{diffuse::Diffuse, file::GltfFile};
use crate::{SceneError, images, limits::Limit, particles::linear_from_srgb};
use ::gltf::{Document, Image, Material, material::AlphaMode, texture::Info};
use gobo::model::Texture;
use image::{Rgba32FImage, RgbaImage, imageops::FilterType};
use std::collections::HashMap;

/// Longest side of an image \[texels\].
pub(crate) const MAX_SIDE: u32 = 16384;

/// A texture as a product of images.
#[derive(Clone, Default)]
pub(crate) struct Product<'a> {
    pub(crate) base: Option<Image<'a>>,
    /// Image whose red channel multiplies the colour.
    pub(crate) transmission: Option<Image<'a>>,
    /// Image whose blue channel, times the factor, is the metallic share; metal transmits nothing.
    pub(crate) metal: Option<(Image<'a>, f32)>,
    /// Image whose alpha is the share of diffuse transmission.
    pub(crate) spreads: Option<(Image<'a>, Spreads)>,
    /// Image whose alpha is the product's.
    pub(crate) covers: Option<(Image<'a>, Covers)>,
    /// Whether alpha is one.
    pub(crate) is_opaque: bool,
    /// Whether the texture belongs to one of a body's two faces: it has the square root of the colour.
    pub(crate) is_face: bool,
}

/// Share of the light that a product takes from a texture of diffuse transmission.
#[derive(Clone, Copy)]
pub(crate) enum Spreads {
    /// The transmitted share.
    Passes,
    /// The rest; the factor multiplies the transmitted share.
    Stays(f32),
}

/// Coverage of a product by the alpha of another image.
#[derive(Clone, Copy)]
pub(crate) enum Covers {
    AsItIs,
    /// Covered where alpha is at least this.
    From(f32),
}

/// Images of a product.
pub(crate) const IMAGES: usize = 5;

/// Images that are data, and the bits of the numbers that go with them.
type DataKey = ([Option<usize>; 2], [u32; 3]);
/// Images, and the bits of their numbers and choices.
type Key = ([Option<usize>; IMAGES], [u32; 3], bool, bool);

impl<'a> Product<'a> {
    /// The texture of a material's colour and, if it `transmits`, transmission.
    pub(crate) fn of(source: &Material<'a>, transmits: bool, is_face: bool) -> Self {
        let image = |info: Info<'a>| info.texture().source();
        let surface = source.pbr_metallic_roughness();
        let transmission = source.transmission().filter(|_| transmits);
        let factor = share(surface.metallic_factor());
        let metal = surface.metallic_roughness_texture().filter(|_| transmits && factor > 0.0);
        Self {
            base: surface.base_color_texture().map(image),
            transmission: transmission.and_then(|t| t.transmission_texture()).map(image),
            metal: metal.map(|info| (image(info), factor)),
            is_opaque: source.alpha_mode() == AlphaMode::Opaque,
            is_face,
            ..Self::default()
        }
    }

    /// `self`, the texture of a near side, without the light of diffuse transmission.
    pub(crate) fn near(self, document: &'a Document, diffuse: &Diffuse) -> Self {
        let passes = image(document, diffuse.share);
        Self { spreads: passes.map(|image| (image, Spreads::Stays(diffuse.factor))), ..self }
    }

    /// The texture of diffuse transmission, and of its coverage.
    pub(crate) fn far(document: &'a Document, diffuse: &Diffuse, source: &Material<'a>) -> Self {
        let surface = source.pbr_metallic_roughness();
        let [.., alpha] = surface.base_color_factor();
        let covers = surface.base_color_texture();
        let covers = covers.filter(|_| source.alpha_mode() != AlphaMode::Opaque);
        Self {
            base: image(document, diffuse.tint),
            spreads: image(document, diffuse.share).map(|image| (image, Spreads::Passes)),
            covers: covers.map(|info| {
                let covers = match source.alpha_mode() {
                    AlphaMode::Mask => Covers::From(source.alpha_cutoff().unwrap_or(0.5) / alpha),
                    _ => Covers::AsItIs,
                };
                (info.texture().source(), covers)
            }),
            is_opaque: source.alpha_mode() == AlphaMode::Opaque,
            ..Self::default()
        }
    }

    /// Its images; the stored texture has the size of the largest.
    pub(crate) fn images(&self) -> [Option<&Image<'a>>; IMAGES] {
        let metal = self.metal.as_ref().map(|(image, _)| image);
        let spreads = self.spreads.as_ref().map(|(image, _)| image);
        let covers = self.covers.as_ref().map(|(image, _)| image);
        [self.base.as_ref(), self.transmission.as_ref(), metal, spreads, covers]
    }

    fn key(&self) -> Key {
        let metal = self.metal.as_ref().map_or(0, |(_, factor)| factor.to_bits());
        let spreads = self.spreads.as_ref().map_or(0, |(_, spreads)| match spreads {
            Spreads::Passes => u32::MAX,
            Spreads::Stays(factor) => factor.to_bits(),
        });
        let covers = self.covers.as_ref().map_or(0, |(_, covers)| match covers {
            Covers::AsItIs => u32::MAX,
            Covers::From(cutoff) => cutoff.to_bits(),
        });
        let images = self.images().map(|image| image.map(Image::index));
        (images, [metal, spreads, covers], self.is_opaque, self.is_face)
    }
}

pub(super) fn image(document: &Document, texture: Option<usize>) -> Option<Image<'_>> {
    document.textures().nth(texture?).map(|texture| texture.source())
}

#[derive(Debug)]
pub(crate) struct Textures<'a> {
    file: &'a GltfFile,
    pub(crate) textures: Vec<Texture>,
    known: HashMap<Key, u32>,
    known_data: HashMap<DataKey, u32>,
    means: HashMap<usize, [f32; 4]>,
    /// Number of the scene's textures before this file.
    earlier: usize,
    /// Texels of all textures of the scene.
    texels: u64,
}

impl<'a> Textures<'a> {
    /// `earlier` and `texels`: textures that the scene has already.
    pub(crate) fn new(file: &'a GltfFile, earlier: usize, texels: u64) -> Self {
        let (known, known_data, means) = (HashMap::new(), HashMap::new(), HashMap::new());
        Self { file, textures: Vec::new(), known, known_data, means, earlier, texels }
    }

    /// Index of a product's texture; `None` without images.
    pub(crate) fn add(&mut self, product: &Product<'_>) -> Result<Option<u32>, SceneError> {
        let Some(first) = product.images().into_iter().flatten().next() else { return Ok(None) };
        let key = product.key();
        if let Some(known) = self.known.get(&key) {
            return Ok(Some(*known));
        }
        let count = (self.earlier + self.textures.len()) as u64;
        Limit::Textures.grown_in(&self.file.path, count, 1)?;
        let name = first.name().map_or_else(|| format!("image {}", first.index()), str::to_owned);
        let mut pixels = self.multiplied(product)?;
        let is_solid = pixels.pixels().all(|pixel| pixel.0[3] == 255);
        let roots: [u8; 256] =
            std::array::from_fn(|c| srgb_byte(linear_from_srgb(c as f32 / 255.0).sqrt()));
        for pixel in pixels.pixels_mut() {
            if product.is_face {
                for channel in &mut pixel.0[..3] {
                    *channel = roots[usize::from(*channel)];
                }
            }
            if product.is_opaque {
                pixel.0[3] = 255;
            }
        }
        let (width, height) = pixels.dimensions();
        let id = self.textures.len() as u32;
        self.textures.push(Texture { name, width, height, rgba: pixels.into_raw() });
        self.known.insert(key, id);
        if is_solid {
            let (images, numbers, is_opaque, is_face) = key;
            self.known.insert((images, numbers, !is_opaque, is_face), id);
        }
        Ok(Some(id))
    }

    /// Index of the texture that is made of images which are data.
    pub(super) fn add_data(
        &mut self,
        images: [Option<&Image<'_>>; 2],
        numbers: [f32; 3],
        make: impl FnOnce([Option<RgbaImage>; 2]) -> RgbaImage,
    ) -> Result<u32, SceneError> {
        let key = (images.map(|image| image.map(Image::index)), numbers.map(f32::to_bits));
        if let Some(known) = self.known_data.get(&key) {
            return Ok(*known);
        }
        let count = (self.earlier + self.textures.len()) as u64;
        Limit::Textures.grown_in(&self.file.path, count, 1)?;
        let before = self.texels;
        let [first, second] = images.map(|image| image.map(|image| self.decode(image)).transpose());
        let pixels = make([first?, second?]);
        let (width, height) = pixels.dimensions();
        let texels = u64::from(width) * u64::from(height);
        self.texels = Limit::Texels.grown_in(&self.file.path, before, texels)?;
        let first = images.iter().flatten().next();
        let name = first.map_or_else(String::new, |image| format!("image {}", image.index()));
        let id = self.textures.len() as u32;
        self.textures.push(Texture { name, width, height, rgba: pixels.into_raw() });
        self.known_data.insert(key, id);
        Ok(id)
    }

    /// Product of the images, at the largest size.
    fn multiplied(&mut self, product: &Product<'_>) -> Result<RgbaImage, SceneError> {
        let before = self.texels;
        let images = product.images();
        let mut decoded = [const { None }; IMAGES];
        for (decoded, image) in decoded.iter_mut().zip(images) {
            *decoded = image.map(|image| self.decode(image)).transpose()?;
        }
        let sizes = decoded.iter().flatten().map(RgbaImage::dimensions);
        let (width, height) = sizes.fold((0, 0), |a, b| (a.0.max(b.0), a.1.max(b.1)));
        let texels = u64::from(width) * u64::from(height);
        self.texels = Limit::Texels.grown_in(&self.file.path, before, texels)?;
        let [base, transmission, metal, spreads, covers] = decoded;
        let white = || RgbaImage::from_pixel(width, height, image::Rgba([255; 4]));
        let mut base = base.map_or_else(white, |base| resized_color(base, width, height));
        let factor = product.metal.as_ref().map_or(0.0, |(_, factor)| *factor);
        if let Some(filter) = transmission {
            multiply(&mut base, filter, |texel| f32::from(texel[0]) / 255.0);
        }
        if let Some(metal) = metal {
            multiply(&mut base, metal, |texel| 1.0 - factor * (f32::from(texel[2]) / 255.0));
        }
        if let (Some(image), Some((_, spreads))) = (spreads, &product.spreads) {
            let passes = |texel: [u8; 4]| f32::from(texel[3]) / 255.0;
            match *spreads {
                Spreads::Passes => multiply(&mut base, image, passes),
                Spreads::Stays(factor) => {
                    multiply(&mut base, image, |texel| 1.0 - factor * passes(texel));
                }
            }
        }
        if let (Some(image), Some((_, covers))) = (covers, &product.covers) {
            let image = resized_color(image, width, height);
            for (pixel, alpha) in base.pixels_mut().zip(image.pixels().map(|pixel| pixel.0[3])) {
                pixel.0[3] = match *covers {
                    Covers::AsItIs => alpha,
                    Covers::From(cutoff) if f32::from(alpha) / 255.0 >= cutoff => 255,
                    Covers::From(_) => 0,
                };
            }
        }
        Ok(base)
    }

    /// Mean of each channel as stored, 0..=1.
    pub(crate) fn means(&mut self, image: &Image<'_>) -> Result<[f32; 4], SceneError> {
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

    fn decode(&mut self, image: &Image<'_>) -> Result<RgbaImage, SceneError> {
        let bad = |problem: &str, help: &str| {
            self.file.invalid(format!("image {}: {problem}", image.index()), help)
        };
        let bytes = self.file.image(image)?;
        images::decode(&bytes, MAX_SIDE, &mut self.texels)
            .map_err(|(problem, help)| bad(&problem, &help))
    }
}

/// A colour at another size. Linear light is weighted by alpha, so that transparent texels add no colour.
fn resized_color(image: RgbaImage, width: u32, height: u32) -> RgbaImage {
    if image.dimensions() == (width, height) {
        return image;
    }
    let mut weighted = Rgba32FImage::new(image.width(), image.height());
    for (to, from) in weighted.pixels_mut().zip(image.pixels()) {
        let [red, green, blue, alpha] = from.0.map(|byte| f32::from(byte) / 255.0);
        let [red, green, blue] = [red, green, blue].map(|c| linear_from_srgb(c) * alpha);
        to.0 = [red, green, blue, alpha];
    }
    let weighted = image::imageops::resize(&weighted, width, height, FilterType::Triangle);
    let mut resized = RgbaImage::new(width, height);
    for (to, from) in resized.pixels_mut().zip(weighted.pixels()) {
        let [red, green, blue, alpha] = from.0;
        let [red, green, blue] =
            [red, green, blue].map(|c| srgb_byte((c / alpha.max(1e-6)).clamp(0.0, 1.0)));
        to.0 = [red, green, blue, (alpha * 255.0).round() as u8];
    }
    resized
}

/// Multiplies the colour of `base`, in sRGB, by a factor of each texel of `filter`, at the size of `base`.
fn multiply(base: &mut RgbaImage, filter: RgbaImage, factor: impl Fn([u8; 4]) -> f32) {
    let (width, height) = base.dimensions();
    let filter = match filter.dimensions() == (width, height) {
        true => filter,
        false => image::imageops::resize(&filter, width, height, FilterType::Triangle),
    };
    for (pixel, filter) in base.pixels_mut().zip(filter.pixels()) {
        let factor = factor(filter.0);
        for channel in &mut pixel.0[..3] {
            *channel = srgb_byte(linear_from_srgb(f32::from(*channel) / 255.0) * factor);
        }
    }
}

pub(super) fn srgb_byte(c: f32) -> u8 {
    let srgb = if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (srgb * 255.0).round() as u8
}

/// Transmitted share of light without textures. Metal transmits nothing; where a texture holds the metallic
/// share, the texture is multiplied instead.
pub(crate) fn transmission(source: &Material<'_>) -> f32 {
    let surface = source.pbr_metallic_roughness();
    let metal = match surface.metallic_roughness_texture() {
        Some(_) => 0.0,
        None => share(surface.metallic_factor()),
    };
    source.transmission().map_or(0.0, |t| t.transmission_factor().clamp(0.0, 1.0) * (1.0 - metal))
}

/// A factor of 0 to 1; 1 if it is not finite.
pub(crate) fn share(factor: f32) -> f32 {
    if factor.is_finite() { factor.clamp(0.0, 1.0) } else { 1.0 }
}
