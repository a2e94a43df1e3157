//! glTF images that say what is solid is like texel by texel, as textures of a material of its details.
use super::texture::{Textures, share, srgb_byte};
use crate::SceneError;
use ::gltf::{Image, Material, material::AlphaMode};
use glam::Vec3;
use gobo::model;
use image::{RgbaImage, imageops::FilterType};

/// Images of a surface that are data and no colours.
#[derive(Clone)]
pub(super) struct SurfaceImages<'a> {
    /// Its green channel times the first factor is the roughness, blue times the second one metal.
    rough: Option<Image<'a>>,
    factors: [f32; 2],
    /// Its red channel is the share of ambient light that gets there, as far as the factor says.
    occlusion: Option<(Image<'a>, f32)>,
    /// Normals, of which x and y are times the factor.
    normals: Option<(Image<'a>, f32)>,
}

impl<'a> SurfaceImages<'a> {
    /// Properties that images give a solid, lit material; `None` without any.
    pub(super) fn of(source: &Material<'a>, transmits: bool) -> Option<Self> {
        if transmits || source.unlit() || source.alpha_mode() == AlphaMode::Blend {
            return None;
        }
        let surface = source.pbr_metallic_roughness();
        let rough = surface.metallic_roughness_texture().map(|info| info.texture().source());
        let occlusion = source.occlusion_texture();
        let normals = source.normal_texture();
        let all = Self {
            rough,
            factors: [share(surface.roughness_factor()), share(surface.metallic_factor())],
            occlusion: occlusion.map(|it| (it.texture().source(), share(it.strength()))),
            normals: normals.map(|it| (it.texture().source(), scale(it.scale()))),
        };
        (all.has_shares() || all.normals.is_some()).then_some(all)
    }

    fn has_shares(&self) -> bool {
        self.rough.is_some() || self.occlusion.is_some()
    }

    /// The material of its details.
    pub(super) fn details(
        &self,
        name: &str,
        textures: &mut Textures<'_>,
    ) -> Result<model::Material, SceneError> {
        let images = [self.rough.as_ref(), self.occlusion.as_ref().map(|(image, _)| image)];
        let numbers =
            [self.factors[0], self.factors[1], self.occlusion.as_ref().map_or(0.0, |it| it.1)];
        let texture = match self.has_shares() {
            true => Some(textures.add_data(images, numbers, |images| self.shares(images))?),
            false => None,
        };
        let emissive_texture = match &self.normals {
            Some((image, factor)) => Some(add_normals(textures, image, *factor)?),
            None => None,
        };
        Ok(model::Material {
            name: format!("{name} (details)"),
            texture,
            emissive_texture,
            ..model::Material::default()
        })
    }

    /// Shares of ambient light, roughness and metal.
    fn shares(&self, images: [Option<RgbaImage>; 2]) -> RgbaImage {
        let strength = self.occlusion.as_ref().map_or(0.0, |(_, strength)| *strength);
        data_image(images, |[rough, occlusion]| {
            let open = 1.0 - strength * (1.0 - occlusion[0]);
            [open, self.factors[0] * rough[1], self.factors[1] * rough[2]]
        })
    }
}

/// Numbers that the texels of two images give, at the larger size of both; 1 without an image.
pub(super) fn data_image(
    images: [Option<RgbaImage>; 2],
    numbers: impl Fn([[f32; 4]; 2]) -> [f32; 3],
) -> RgbaImage {
    let sizes = images.iter().flatten().map(RgbaImage::dimensions);
    let (width, height) = sizes.fold((1, 1), |a, b| (a.0.max(b.0), a.1.max(b.1)));
    let images = images.map(|image| {
        image.map(|image| match image.dimensions() == (width, height) {
            true => image,
            false => image::imageops::resize(&image, width, height, FilterType::Triangle),
        })
    });
    RgbaImage::from_fn(width, height, |x, y| {
        let texel = |image: &RgbaImage| image.get_pixel(x, y).0.map(|byte| f32::from(byte) / 255.0);
        let texels = images.each_ref().map(|image| image.as_ref().map_or([1.0; 4], texel));
        let [red, green, blue] = numbers(texels).map(srgb_byte);
        image::Rgba([red, green, blue, 255])
    })
}

/// The texture of an image of normals, of which x and y are times the factor.
pub(super) fn add_normals(
    textures: &mut Textures<'_>,
    image: &Image<'_>,
    factor: f32,
) -> Result<u32, SceneError> {
    // Not a number tells these numbers from those of other images.
    let numbers = [f32::NAN, factor, 0.0];
    textures.add_data([Some(image), None], numbers, |[image, _]| scaled_normals(image, factor))
}

/// A factor of normals; 1 if it is not finite.
fn scale(factor: f32) -> f32 {
    if factor.is_finite() { factor.clamp(-100.0, 100.0) } else { 1.0 }
}

/// Unit normals, as channels of 0 to 1.
fn scaled_normals(image: Option<RgbaImage>, factor: f32) -> RgbaImage {
    let mut image =
        image.unwrap_or_else(|| RgbaImage::from_pixel(1, 1, image::Rgba([128, 128, 255, 255])));
    for pixel in image.pixels_mut() {
        let [x, y, z, _] = pixel.0.map(|byte| f32::from(byte) / 127.5 - 1.0);
        let normal = Vec3::new(x * factor, y * factor, z).normalize_or(Vec3::Z);
        let [red, green, blue] = (normal * 0.5 + 0.5).to_array().map(srgb_byte);
        pixel.0 = [red, green, blue, 255];
    }
    image
}
