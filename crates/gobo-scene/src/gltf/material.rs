//! glTF materials as casters.
//!
//! Transmission `t` filters light: `T = baseColor * t`; metal transmits nothing. With `KHR_materials_volume`
//! the body is closed, and a ray crosses a front and a back face: each face takes the square root of
//! `baseColor * t`, and the body absorbs by its thickness along the ray. An open mesh has no such thickness:
//! `baseColor * t` is multiplied by `attenuationColor^(thickness / attenuationDistance)` there. A sheet,
//! whose faces look one way, takes the whole product where a ray crosses it; each face of another open mesh
//! takes its square root. Thickness is in the mesh's own units, so the node's scale multiplies it in that
//! material.
use super::{
    Earlier,
    coat::Coat,
    coat_images::coat_material,
    details::SurfaceImages,
    file::GltfFile,
    texture::{Product, Textures, share, transmission},
    uses::Uses,
};
use crate::{SceneError, far_sides::far_side, limits::Limit};
use ::gltf::material::{AlphaMode, PbrMetallicRoughness, Volume};
use glam::{Mat4, Vec3};
use gobo::model::{Fresnel, Material, Skipped, Texture, Transfer};
use std::collections::HashMap;

/// Largest emission that is kept; beyond it pictures are white anyway.
const MAX_EMISSION: f32 = 1e4;

#[derive(Debug)]
pub(crate) struct GltfMaterials<'a> {
    materials: Vec<Material>,
    textures: Textures<'a>,
    file: &'a GltfFile,
    /// Number of the scene's materials before this file.
    earlier: usize,
    /// Transfer of alphaMode BLEND.
    blend: Transfer,
    skipped: Skipped,
    known: HashMap<(Option<usize>, i32), Uses>,
    /// Substitutes of volumes, by the volume's material.
    volumes: HashMap<u32, Inside>,
}

/// Substitutes of a volume in a mesh that is not closed.
#[derive(Debug)]
struct Inside {
    /// Transmittance of the volume's thickness.
    whole: Vec3,
    /// Material of a mesh with two faces along most rays.
    shell: Option<u32>,
    /// Material of a mesh with a single face along most rays.
    sheet: Option<u32>,
}

impl<'a> GltfMaterials<'a> {
    pub(crate) fn new(file: &'a GltfFile, earlier: &Earlier, blend: Option<Transfer>) -> Self {
        Self {
            materials: Vec::new(),
            textures: Textures::new(file, earlier.textures, earlier.texels),
            file,
            earlier: earlier.materials,
            // Its alpha is coverage: behind alpha 1 no light is left.
            blend: blend.unwrap_or(Transfer::Smoke),
            skipped: Skipped::new(),
            known: HashMap::new(),
            volumes: HashMap::new(),
        }
    }

    pub(crate) fn is_volume(&self, material: u32) -> bool {
        self.volumes.contains_key(&material)
    }

    /// Material for an open mesh, in place of a volume's. `is_sheet`: whether a ray crosses one face of it
    /// and not two.
    pub(crate) fn open(
        &mut self,
        material: u32,
        source: &gltf::Material<'_>,
        is_sheet: bool,
    ) -> Result<u32, SceneError> {
        let Some(inside) = self.volumes.get(&material) else { return Ok(material) };
        let (known, whole) = (if is_sheet { inside.sheet } else { inside.shell }, inside.whole);
        if let Some(known) = known {
            return Ok(known);
        }
        let closed = self.materials[material as usize].clone();
        let face = closed.tint.truncate();
        let (kind, tint, texture) = if is_sheet {
            ("sheet", face * face * whole, self.texture(source, true, false)?)
        } else {
            ("open", face * whole.map(f32::sqrt), closed.texture)
        };
        let id = self.materials.len() as u32;
        self.materials.push(Material {
            name: format!("{} ({kind})", closed.name),
            tint: tint.extend(closed.tint.w),
            texture,
            attenuation_color: Vec3::ONE,
            attenuation_distance: f32::INFINITY,
            ior: 1.0,
            fresnel: match closed.fresnel {
                Fresnel::Face { ior } if is_sheet => Fresnel::Pane { ior },
                same => same,
            },
            ..closed
        });
        if let Some(inside) = self.volumes.get_mut(&material) {
            *if is_sheet { &mut inside.sheet } else { &mut inside.shell } = Some(id);
        }
        Ok(id)
    }

    pub(crate) fn finish(self) -> (Vec<Material>, Vec<Texture>, Skipped) {
        (self.materials, self.textures.textures, self.skipped)
    }

    pub(crate) fn add(
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
        // A volume may need two more materials, for open meshes.
        let count = (self.earlier + self.materials.len()) as u64;
        let more = match (source.volume(), self.file.diffuse(source)) {
            (Some(_), _) => 3,
            (None, Some(_)) => 2,
            (None, None) => 1,
        };
        let details = SurfaceImages::of(source, transmission(source) > 0.0);
        let details = match self.file.coat(source) {
            Some(_) => 2,
            None => u64::from(details.is_some()),
        };
        Limit::Materials.grown_in(&self.file.path, count, more + details)?;
        let uses = self.convert(source, scale)?;
        self.known.insert(key, uses);
        Ok(uses)
    }

    fn convert(&mut self, source: &gltf::Material<'_>, scale: f32) -> Result<Uses, SceneError> {
        let surface = source.pbr_metallic_roughness();
        let id = self.materials.len() as u32;
        let transmission = transmission(source);
        let transmits = transmission > 0.0;
        let details = SurfaceImages::of(source, transmits);
        let (roughness, metallic) = self.roughness_and_metal(&surface, details.is_some())?;
        if details.is_none() && !source.unlit() {
            self.ignore_of_glass(source);
        }
        let whole = match source.volume().filter(|_| transmits) {
            Some(volume) => self.attenuation(&volume, scale)?,
            None => None,
        };
        let emission =
            Vec3::from(source.emissive_factor()) * source.emissive_strength().unwrap_or(1.0);
        let emission = emission.map(|e| if e > 0.0 { e.min(MAX_EMISSION) } else { 0.0 });
        let emission = if source.unlit() { Vec3::ZERO } else { emission };
        let (uses, [texture, emissive_texture]) =
            self.images(source, transmits, emission != Vec3::ZERO, whole.is_some())?;
        let [red, green, blue, alpha] = surface.base_color_factor().map(|c| c.clamp(0.0, 1.0));
        let mut color = Vec3::new(red, green, blue);
        if transmits {
            color *= transmission;
        }
        let mut volume = (Vec3::ONE, f32::INFINITY);
        if let (Some(whole), Some(source)) = (whole, source.volume()) {
            color = color.map(f32::sqrt);
            let distance = source.attenuation_distance();
            if distance > 0.0 && distance.is_finite() {
                let rgb = Vec3::from(source.attenuation_color()).map(|c| c.clamp(0.0, 1.0));
                volume = (rgb, distance);
            }
            self.volumes.insert(id, Inside { whole, shell: None, sheet: None });
        }
        let reflectivity = self.film(source);
        let ior = source.ior().filter(|ior| ior.is_finite()).unwrap_or(1.5);
        let is_body = transmits && source.volume().is_some_and(|v| v.thickness_factor() > 0.0);
        let dispersion = if is_body { self.file.dispersion(source) } else { 0.0 };
        // Exporters leave an index of 1.5 out; dispersion states that there is one.
        let stated = source.ior().or_else(|| (dispersion > 0.0).then_some(1.5));
        // From KHR_materials_transmission: glass as dense as air is not frosted.
        let frost = roughness * roughness * (2.0 * ior - 2.0).clamp(0.0, 1.0);
        let mut material = Material {
            name: source.name().map_or_else(|| format!("material {id}"), str::to_owned),
            transfer: match source.alpha_mode() {
                _ if transmits => Transfer::Filter,
                AlphaMode::Opaque => Transfer::Opaque,
                AlphaMode::Mask => Transfer::Cutout,
                AlphaMode::Blend => self.blend,
            },
            tint: color.extend(if source.alpha_mode() == AlphaMode::Opaque { 1.0 } else { alpha }),
            texture,
            reflectivity,
            cutoff: share(source.alpha_cutoff().unwrap_or(0.5)),
            emission,
            emissive_texture,
            transmission,
            ior: if is_body { ior.clamp(1.0, 3.0) } else { 1.0 },
            fresnel: match stated {
                Some(_) if !transmits || ior <= 1.0 => Fresnel::None,
                Some(_) if is_body => Fresnel::Face { ior: ior.min(3.0) },
                Some(_) => Fresnel::Pane { ior: ior.min(3.0) },
                None => Fresnel::None,
            },
            dispersion,
            frost: if transmits { frost } else { 0.0 },
            attenuation_color: volume.0,
            attenuation_distance: volume.1,
            roughness,
            metallic,
            unlit: source.unlit(),
            ..Material::default()
        };
        let far = self.far_side(source, &mut material)?;
        let details = match details {
            Some(surface) => Some(surface.details(&material.name, &mut self.textures)?),
            None => None,
        };
        let coat = match self.shown_coat(source, transmits, uses.uv_set) {
            Some(coat) => {
                let document = &self.file.document;
                Some(coat_material(&coat, &material.name, document, &mut self.textures)?)
            }
            None => None,
        };
        let details = details.or(coat.as_ref().map(|_| Material {
            name: format!("{} (details)", material.name),
            ..Material::default()
        }));
        let behind = (self.materials.len() + 1 + usize::from(far.is_some())) as u32;
        material.details = details.as_ref().map(|_| behind);
        let details =
            details.map(|it| Material { details: coat.as_ref().map(|_| behind + 1), ..it });
        self.materials.push(material);
        self.materials.extend(far);
        self.materials.extend(details);
        self.materials.extend(coat);
        Ok(uses)
    }

    /// The clear coat of a solid, lit material.
    fn shown_coat(
        &mut self,
        source: &gltf::Material<'_>,
        transmits: bool,
        uv_set: u32,
    ) -> Option<Coat> {
        let coat = self.file.coat(source)?;
        let is_solid = !transmits && source.alpha_mode() != AlphaMode::Blend;
        if !is_solid || source.unlit() || self.file.diffuse(source).is_some() {
            self.ignore("clear coats of what is not opaque, or not lit, ignored");
            return None;
        }
        if coat.has_other_uvs(uv_set) {
            self.ignore("texture coordinates of clear coats' textures ignored");
        }
        Some(coat)
    }

    /// Counts images of what is not solid that are not shown.
    fn ignore_of_glass(&mut self, source: &gltf::Material<'_>) {
        if source.normal_texture().is_some() {
            self.ignore("normal textures of what is not opaque ignored");
        }
        if source.occlusion_texture().is_some() {
            self.ignore("occlusion textures of what is not opaque ignored");
        }
    }
    /// The material of diffuse transmission to the far side.
    fn far_side(
        &mut self,
        source: &gltf::Material<'_>,
        material: &mut Material,
    ) -> Result<Option<Material>, SceneError> {
        let Some(diffuse) = self.file.diffuse(source) else { return Ok(None) };
        if material.transmission > 0.0 || material.unlit {
            self.ignore("diffuse transmission of glass or of what is not lit ignored");
            return Ok(None);
        }
        if diffuse.is_placed {
            self.ignore("texture coordinates of diffuse transmission textures ignored");
        }
        let product = Product::far(&self.file.document, &diffuse, source);
        let texture = self.textures.add(&product)?;
        let id = self.materials.len() as u32 + 1;
        let far = far_side(material, id, diffuse.lacks(), diffuse.factor * diffuse.color);
        Ok(Some(Material { texture, ..far }))
    }

    /// Texture of a material's colour and transmission, texture of its emission, and the coordinates of the
    /// first. `is_face`: whether the first belongs to one face of a body.
    fn images(
        &mut self,
        source: &gltf::Material<'_>,
        transmits: bool,
        emits: bool,
        is_face: bool,
    ) -> Result<(Uses, [Option<u32>; 2]), SceneError> {
        let id = self.materials.len() as u32;
        let surface = source.pbr_metallic_roughness();
        let base = surface.base_color_texture();
        let transmission =
            source.transmission().filter(|_| transmits).and_then(|t| t.transmission_texture());
        let is_detailed = SurfaceImages::of(source, transmits).is_some();
        let metal = surface.metallic_roughness_texture().filter(|_| transmits || is_detailed);
        let emission = source.emissive_texture().filter(|_| emits);
        let first =
            [&base, &transmission, &metal, &emission].into_iter().find_map(|info| info.as_ref());
        let mut uses = Uses::new(id, first);
        let normals = source.normal_texture().map(|it| it.tex_coord());
        let occlusion = source.occlusion_texture().map(|it| it.tex_coord());
        if first.is_none() {
            let coat = self.file.coat(source).and_then(|coat| coat.uv_set());
            let own = normals.or(occlusion).filter(|_| is_detailed);
            uses.uv_set = own.or(coat).unwrap_or(0);
        }
        for (uv_set, reason) in [
            (normals, "texture coordinates of normal textures ignored"),
            (occlusion, "texture coordinates of occlusion textures ignored"),
        ] {
            if is_detailed && uv_set.is_some_and(|uv_set| uv_set != uses.uv_set) {
                self.ignore(reason);
            }
        }
        for (info, reason) in [
            (&transmission, "texture coordinates of transmission textures ignored"),
            (&metal, "texture coordinates of metal textures ignored"),
            (&emission, "texture coordinates of emissive textures ignored"),
        ] {
            if info.is_some() && !Uses::new(id, info.as_ref()).has_same_uvs(&uses) {
                self.ignore(reason);
            }
        }
        let texture = self.texture(source, transmits, is_face)?;
        let emission = emission.map(|info| info.texture().source());
        let emission = Product { base: emission, is_opaque: true, ..Product::default() };
        Ok((uses, [texture, self.textures.add(&emission)?]))
    }

    /// Texture of its colour and transmission. `is_face`: whether it belongs to one of a body's two faces.
    fn texture(
        &mut self,
        source: &gltf::Material<'_>,
        transmits: bool,
        is_face: bool,
    ) -> Result<Option<u32>, SceneError> {
        let product = Product::of(source, transmits, is_face);
        let diffuse = self.file.diffuse(source).filter(|_| !transmits && !source.unlit());
        let document = &self.file.document;
        let product = diffuse.map_or(product.clone(), |diffuse| product.near(document, &diffuse));
        self.textures.add(&product)
    }

    /// Roughness and metallic share, by the means of their texture.
    fn roughness_and_metal(
        &mut self,
        surface: &PbrMetallicRoughness<'_>,
        has_details: bool,
    ) -> Result<(f32, f32), SceneError> {
        let (mut rough, mut metal) = (1.0, 1.0);
        if let Some(info) = surface.metallic_roughness_texture() {
            [_, rough, metal, _] = self.textures.means(&info.texture().source())?;
            if !has_details {
                self.ignore("textures of roughness and metal: by their means");
            }
        }
        Ok((share(surface.roughness_factor() * rough), share(surface.metallic_factor() * metal)))
    }

    /// Reflectivity of a thin film; 0 without.
    fn film(&mut self, source: &gltf::Material<'_>) -> f32 {
        let Some(film) = source.index().and_then(|index| self.file.film(index)) else { return 0.0 };
        let reflectivity = film.reflectivity(source.ior().unwrap_or(1.5));
        self.ignore("colours of thin films: by their mean");
        reflectivity
    }

    /// Transmittance of the whole body; `None` for a thin wall.
    fn attenuation(&mut self, volume: &Volume<'_>, scale: f32) -> Result<Option<Vec3>, SceneError> {
        let distance = volume.attenuation_distance();
        let mut thickness = volume.thickness_factor() * scale;
        if let Some(info) = volume.thickness_texture() {
            thickness *= self.textures.means(&info.texture().source())?[1];
            self.ignore("textures of thickness: by their means");
        }
        if !(thickness > 0.0 && thickness.is_finite()) {
            return Ok(None);
        }
        if !(distance > 0.0 && distance.is_finite()) {
            return Ok(Some(Vec3::ONE));
        }
        let color = Vec3::from(volume.attenuation_color()).map(|c| c.clamp(0.0, 1.0));
        Ok(Some(color.map(|c| c.powf(thickness / distance))))
    }

    fn ignore(&mut self, reason: &'static str) {
        *self.skipped.entry(reason).or_default() += 1;
    }
}
