//! Images of clear coats, as textures of a material of the coat.
use super::{
    coat::Coat,
    details::{add_normals, data_image},
    texture::{Textures, image},
};
use crate::SceneError;
use ::gltf::Document;
use gobo::model;

/// The material of a coat.
pub(super) fn coat_material(
    coat: &Coat,
    name: &str,
    document: &Document,
    textures: &mut Textures<'_>,
) -> Result<model::Material, SceneError> {
    let [share, rough] = [coat.share, coat.rough].map(|texture| image(document, texture));
    let normals = coat.normals.and_then(|(index, by)| Some((image(document, Some(index))?, by)));
    let texture = match share.is_some() || rough.is_some() {
        true => {
            // Infinity, which no factor is, tells these numbers from those of other images.
            let numbers = [f32::INFINITY, coat.factor, coat.roughness];
            let images = [share.as_ref(), rough.as_ref()];
            let shares = |[share, rough]: [[f32; 4]; 2]| {
                [coat.factor * share[0], coat.roughness * rough[1], 0.0]
            };
            Some(textures.add_data(images, numbers, |images| data_image(images, shares))?)
        }
        false => None,
    };
    let emissive_texture = match &normals {
        Some((image, factor)) => Some(add_normals(textures, image, *factor)?),
        None => None,
    };
    Ok(model::Material {
        name: format!("{name} (coat)"),
        texture,
        emissive_texture,
        reflectivity: coat.factor,
        roughness: coat.roughness,
        ..model::Material::default()
    })
}
