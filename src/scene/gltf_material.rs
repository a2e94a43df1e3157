//! glTF materials as casters.
//!
//! Transmission `t` filters: `T = baseColor * t`. With `KHR_materials_volume` the body is closed and a ray
//! crosses a front and a back face, so each face takes the square root of `baseColor * t`, and the body
//! absorbs by its thickness along the ray. A mesh that is not closed has no such thickness: there each face
//! takes the square root of `attenuationColor^(thickness / attenuationDistance)` as well. Thickness is in
//! the mesh's own units, so the node's scale multiplies it in that material.
use super::{SceneError, gltf::Earlier, gltf_file::File, gltf_texture::Textures, limits::Limit};
use crate::model::{Material, Skipped, Texture, Transfer};
use ::gltf::material::{AlphaMode, Volume};
use glam::{Mat4, Vec2, Vec3};
use std::collections::HashMap;

/// Largest emission that is kept; beyond it pictures are white anyway.
const MAX_EMISSION: f32 = 1e4;

#[derive(Debug)]
pub(super) struct Materials<'a> {
    materials: Vec<Material>,
    textures: Textures<'a>,
    file: &'a File,
    /// Materials that the scene had before.
    earlier: usize,
    skipped: Skipped,
    known: HashMap<(Option<usize>, i32), Uses>,
    /// For each volume: transmittance of two faces if its mesh is not closed, and the material for that
    /// case.
    open: HashMap<u32, (Vec3, Option<u32>)>,
}

/// How a primitive uses its material.
#[derive(Clone, Copy, Debug)]
pub(super) struct Uses {
    /// Index into the model's materials.
    pub(super) material: u32,
    pub(super) uv_set: u32,
    offset: Vec2,
    rotation: f32,
    scale: Vec2,
}

impl Uses {
    /// `KHR_texture_transform`: scale, then rotation (counterclockwise, v points down), then offset.
    pub(super) fn transform_uv(&self, uv: Vec2) -> Vec2 {
        let (uv, (sin, cos)) = (uv * self.scale, self.rotation.sin_cos());
        self.offset + Vec2::new(cos * uv.x + sin * uv.y, cos * uv.y - sin * uv.x)
    }

    fn new(material: u32, info: Option<&gltf::texture::Info<'_>>) -> Self {
        let mut uses =
            Self { material, uv_set: 0, offset: Vec2::ZERO, rotation: 0.0, scale: Vec2::ONE };
        let Some(info) = info else { return uses };
        uses.uv_set = info.tex_coord();
        if let Some(transform) = info.texture_transform() {
            uses.uv_set = transform.tex_coord().unwrap_or(uses.uv_set);
            uses.offset = transform.offset().into();
            uses.rotation = transform.rotation();
            uses.scale = transform.scale().into();
        }
        uses
    }

    fn has_same_uvs(&self, other: &Self) -> bool {
        self.uv_set == other.uv_set
            && self.offset == other.offset
            && self.rotation == other.rotation
            && self.scale == other.scale
    }
}

impl<'a> Materials<'a> {
    pub(super) fn new(file: &'a File, earlier: &Earlier) -> Self {
        Self {
            materials: Vec::new(),
            textures: Textures::new(file, earlier.textures, earlier.texels),
            file,
            earlier: earlier.materials,
            skipped: Skipped::new(),
            known: HashMap::new(),
            open: HashMap::new(),
        }
    }

    pub(super) fn is_volume(&self, material: u32) -> bool {
        self.open.contains_key(&material)
    }

    /// Material for a mesh that is not closed, in place of a volume's.
    pub(super) fn open(&mut self, material: u32) -> u32 {
        let Some((whole, open)) = self.open.get_mut(&material) else { return material };
        *open.get_or_insert_with(|| {
            let closed = &self.materials[material as usize];
            let tint = closed.tint.truncate() * whole.map(f32::sqrt);
            self.materials.push(Material {
                name: format!("{} (open)", closed.name),
                tint: tint.extend(closed.tint.w),
                attenuation_color: Vec3::ONE,
                attenuation_distance: f32::INFINITY,
                ior: 1.0,
                ..closed.clone()
            });
            self.materials.len() as u32 - 1
        })
    }

    pub(super) fn finish(self) -> (Vec<Material>, Vec<Texture>, Skipped) {
        (self.materials, self.textures.textures, self.skipped)
    }

    pub(super) fn add(
        &mut self,
        source: &gltf::Material<'_>,
        world: Mat4,
    ) -> Result<Uses, SceneError> {
        let scale = match source.volume() {
            Some(_) => world.determinant().abs().cbrt(),
            None => 1.0,
        };
        // Steps of 0.1%: nodes whose scales differ by rounding share a material.
        let key = (source.index(), (scale.max(f32::MIN_POSITIVE).ln() * 1000.0).round() as i32);
        if let Some(uses) = self.known.get(&key) {
            return Ok(*uses);
        }
        // A volume may need a second one.
        let count = (self.earlier + self.materials.len()) as u64;
        Limit::Materials
            .grown(count, if source.volume().is_some() { 2 } else { 1 })
            .map_err(|(message, help)| self.file.invalid(message, help))?;
        let uses = self.convert(source, scale)?;
        self.known.insert(key, uses);
        Ok(uses)
    }

    fn convert(&mut self, source: &gltf::Material<'_>, scale: f32) -> Result<Uses, SceneError> {
        let surface = source.pbr_metallic_roughness();
        let base = surface.base_color_factor().map(|c| c.clamp(0.0, 1.0));
        let base_texture = surface.base_color_texture();
        let id = self.materials.len() as u32;
        let transmission =
            source.transmission().map_or(0.0, |t| t.transmission_factor().clamp(0.0, 1.0));
        let transmits = transmission > 0.0;
        let transmission_texture =
            source.transmission().filter(|_| transmits).and_then(|t| t.transmission_texture());
        let attenuation = match source.volume().filter(|_| transmits) {
            Some(volume) => self.attenuation(&volume, scale)?,
            None => None,
        };
        let emission =
            Vec3::from(source.emissive_factor()) * source.emissive_strength().unwrap_or(1.0);
        let emission = emission.map(|e| if e > 0.0 { e.min(MAX_EMISSION) } else { 0.0 });
        let emissive_texture = source.emissive_texture().filter(|_| emission != Vec3::ZERO);
        let first = base_texture.as_ref().or(transmission_texture.as_ref());
        let uses = Uses::new(id, first.or(emissive_texture.as_ref()));
        if let Some(info) = &transmission_texture
            && !Uses::new(id, Some(info)).has_same_uvs(&uses)
        {
            self.ignore("texture coordinates of transmission textures ignored");
        }
        if let Some(info) = &emissive_texture
            && !Uses::new(id, Some(info)).has_same_uvs(&uses)
        {
            self.ignore("texture coordinates of emissive textures ignored");
        }
        let mut color = Vec3::new(base[0], base[1], base[2]);
        if transmits {
            color *= transmission;
        }
        let mut volume = (Vec3::ONE, f32::INFINITY);
        if let (Some(whole), Some(source)) = (attenuation, source.volume()) {
            color = color.map(f32::sqrt);
            let rgb = Vec3::from(source.attenuation_color()).map(|c| c.clamp(0.0, 1.0));
            volume = (rgb, source.attenuation_distance());
            self.open.insert(id, (whole, None));
        }
        let is_opaque = source.alpha_mode() == AlphaMode::Opaque;
        let texture = self.textures.add(
            base_texture.map(|info| info.texture().source()),
            transmission_texture.map(|info| info.texture().source()),
            is_opaque,
            attenuation.is_some(),
        )?;
        let emissive_image = emissive_texture.map(|info| info.texture().source());
        let emissive_texture = self.textures.add(emissive_image, None, true, false)?;
        let (mut rough, mut metal) = (1.0, 1.0);
        if let Some(info) = surface.metallic_roughness_texture() {
            [_, rough, metal, _] = self.textures.means(&info.texture().source())?;
            self.ignore("textures of roughness and metal: by their means");
        }
        let film = source.index().and_then(|index| self.file.film(index));
        let reflectivity = film.map_or(0.0, |film| film.reflectivity(source.ior().unwrap_or(1.5)));
        if film.is_some() {
            self.ignore("colours of thin films: by their mean");
        }
        let number = |value: f32| if value.is_finite() { value.clamp(0.0, 1.0) } else { 1.0 };
        let roughness = number(surface.roughness_factor() * rough);
        let ior = source.ior().filter(|ior| ior.is_finite()).unwrap_or(1.5);
        let is_body = transmits && source.volume().is_some_and(|v| v.thickness_factor() > 0.0);
        self.materials.push(Material {
            name: source.name().map_or_else(|| format!("material {id}"), str::to_owned),
            transfer: match source.alpha_mode() {
                _ if transmits => Transfer::Filter,
                AlphaMode::Opaque => Transfer::Opaque,
                AlphaMode::Mask => Transfer::Cutout,
                AlphaMode::Blend => Transfer::Filter,
            },
            tint: color.extend(if is_opaque { 1.0 } else { base[3] }),
            texture,
            reflectivity,
            cutoff: number(source.alpha_cutoff().unwrap_or(0.5)),
            emission,
            emissive_texture,
            transmission,
            ior: if is_body { ior.clamp(1.0, 3.0) } else { 1.0 },
            // Of KHR_materials_transmission: glass as dense as air is not frosted.
            frost: if transmits {
                roughness * roughness * (2.0 * ior - 2.0).clamp(0.0, 1.0)
            } else {
                0.0
            },
            attenuation_color: volume.0,
            attenuation_distance: volume.1,
            roughness,
            metallic: number(surface.metallic_factor() * metal),
            ..Material::default()
        });
        Ok(uses)
    }

    /// Transmittance of the whole body; `None` for a thin wall.
    fn attenuation(&mut self, volume: &Volume<'_>, scale: f32) -> Result<Option<Vec3>, SceneError> {
        let distance = volume.attenuation_distance();
        let mut thickness = volume.thickness_factor() * scale;
        if let Some(info) = volume.thickness_texture() {
            thickness *= self.textures.means(&info.texture().source())?[1];
        }
        let is_body = thickness > 0.0 && thickness.is_finite();
        if !(is_body && distance > 0.0 && distance.is_finite()) {
            return Ok(None);
        }
        let color = Vec3::from(volume.attenuation_color()).map(|c| c.clamp(0.0, 1.0));
        Ok(Some(color.map(|c| c.powf(thickness / distance))))
    }

    fn ignore(&mut self, reason: &'static str) {
        *self.skipped.entry(reason).or_default() += 1;
    }
}
