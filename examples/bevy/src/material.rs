//! Bevy's material in gobo's light.
use bevy::{
    asset::uuid_handle,
    image::Image,
    pbr::{ExtendedMaterial, MaterialExtension},
    prelude::*,
    render::render_resource::{
        AsBindGroup, Extent3d, TextureDimension, TextureFormat, TextureUsages,
    },
    shader::ShaderRef,
};

/// Mask of the picture: the share of the sun's light that reaches each pixel, in red, green and blue.
pub(crate) const MASK: Handle<Image> = uuid_handle!("8f6c0c2e-5d0f-4d39-9f4e-3b7a3f6b2a51");

/// Bevy's material, lit by the sun through gobo's casters.
pub type GoboMaterial = ExtendedMaterial<StandardMaterial, ColoredLight>;

/// The sun's light at the pixels of the camera with [`ColoredShadows`](crate::ColoredShadows).
#[derive(Asset, AsBindGroup, TypePath, Clone, Debug)]
pub struct ColoredLight {
    #[texture(100, sample_type = "float", filterable = false)]
    mask: Handle<Image>,
}

impl Default for ColoredLight {
    fn default() -> Self {
        Self { mask: MASK }
    }
}

impl MaterialExtension for ColoredLight {
    fn fragment_shader() -> ShaderRef {
        "embedded://bevy_gobo/colored.wesl".into()
    }
}

/// A material of Bevy's in gobo's light. It must be opaque and forward-rendered, and its light must not have
/// Bevy's shadow maps.
pub fn lit(base: StandardMaterial) -> GoboMaterial {
    GoboMaterial { base, extension: ColoredLight::default() }
}

/// A mask of full light.
pub(crate) fn clear_mask(size: UVec2) -> Image {
    let size = Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 };
    let (format, usage) = (TextureFormat::Rgba8Unorm, TextureUsages::COPY_DST);
    let mut image = Image::new_fill(size, TextureDimension::D2, &[255; 4], format, default());
    image.texture_descriptor.usage |= usage;
    image
}

/// Keeps the mask at the size of the camera's picture.
pub(crate) fn fit_mask(
    cameras: Query<&Camera, With<crate::ColoredShadows>>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<GoboMaterial>>,
) {
    let Some(size) = cameras.iter().find_map(Camera::physical_target_size) else { return };
    if images.get(&MASK).is_some_and(|mask| mask.size() == size) {
        return;
    }
    if let Err(error) = images.insert(&MASK, clear_mask(size)) {
        error!("no coloured shadows: {error}");
    }
    // Each material binds the mask anew.
    materials.iter_mut().for_each(drop);
}
