//! Materials of MTL files as casters.
//!
//! `Kd` is the colour and `d` (or 1 - `Tr`) its coverage: below 1 the transfer is `smoke`, as for alphaMode
//! BLEND in glTF. `map_d` makes a cut-out. `Ns` becomes a roughness by Karis 2013, section "Specular D";
//! `Pr`, `Pm` and `Ke` are used unchanged.
use super::{SceneError, gltf::Earlier, images, limits::Limit, read};
use glam::Vec3;
use gobo::model::{Material, Texture, Transfer};
use std::{
    collections::{HashMap, HashSet},
    path::{Path, PathBuf},
};

/// Longest side of a texture \[texels\].
const MAX_SIDE: u32 = 8192;

/// Colour without a material.
const GREY: f32 = 0.7;

/// Largest emission that is kept; beyond it pictures are white anyway.
const MAX_EMISSION: f32 = 1e4;

/// Keys of shading that are not read.
const UNREAD: [&str; 4] = ["Ka", "Ks", "Tf", "illum"];

pub(super) struct ObjMaterials<'a> {
    path: &'a Path,
    earlier: &'a Earlier,
    texels: u64,
    blend: Transfer,
    source: Vec<tobj::Material>,
    made: Vec<Material>,
    textures: Vec<Texture>,
    /// Materials by their index in the file, and textures by their images of colour and coverage.
    known: HashMap<Option<usize>, u32>,
    images: HashMap<[Option<PathBuf>; 2], Option<u32>>,
    /// Images that cannot be read.
    missing: HashSet<String>,
}

impl<'a> ObjMaterials<'a> {
    pub(super) fn new(
        path: &'a Path,
        earlier: &'a Earlier,
        blend: Option<Transfer>,
        source: Vec<tobj::Material>,
    ) -> Self {
        let blend = blend.unwrap_or(Transfer::Smoke);
        let (texels, made, textures) = (earlier.texels, Vec::new(), Vec::new());
        let (known, images, missing) = Default::default();
        Self { path, earlier, texels, blend, source, made, textures, known, images, missing }
    }

    /// Images that a material names.
    pub(super) fn images(path: &Path, material: &tobj::Material) -> Vec<PathBuf> {
        let names = [&material.diffuse_texture, &material.dissolve_texture];
        names.into_iter().flatten().filter_map(|name| beside(path, file_of(name))).collect()
    }

    /// Index of the caster material for a material of the file.
    pub(super) fn add(&mut self, source: Option<usize>) -> Result<u32, SceneError> {
        let source = source.filter(|index| *index < self.source.len());
        if let Some(&known) = self.known.get(&source) {
            return Ok(known);
        }
        let have = (self.earlier.materials + self.made.len()) as u64;
        Limit::Materials.grown_in(self.path, have, 1)?;
        let material = match source {
            None => Material {
                name: "mesh".to_owned(),
                transfer: Transfer::Opaque,
                tint: Vec3::splat(GREY).extend(1.0),
                ..Material::default()
            },
            Some(index) => {
                let source = std::mem::take(&mut self.source[index]);
                let material = self.material(&source)?;
                self.source[index] = source;
                material
            }
        };
        let id = self.made.len() as u32;
        self.made.push(material);
        self.known.insert(source, id);
        Ok(id)
    }

    fn material(&mut self, source: &tobj::Material) -> Result<Material, SceneError> {
        let usual = Material::default();
        let words = |key: &str| {
            let line = source.unknown_param.get(key)?;
            let numbers: Vec<f32> =
                line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
            numbers.iter().all(|number| number.is_finite()).then_some(numbers)
        };
        let share = |key: &str| Some(words(key)?.first()?.clamp(0.0, 1.0));
        let three = |rgb: [f32; 3]| {
            let rgb = Vec3::from_array(rgb);
            Vec3::select(rgb.is_nan_mask(), Vec3::ZERO, rgb)
        };
        let color = source.diffuse.map_or(Vec3::ONE, three).clamp(Vec3::ZERO, Vec3::ONE);
        let cover = source.dissolve.or_else(|| share("Tr").map(|tr| 1.0 - tr)).unwrap_or(1.0);
        let cover = if cover.is_finite() { cover.clamp(0.0, 1.0) } else { 1.0 };
        let names = [&source.diffuse_texture, &source.dissolve_texture];
        let texture = self.texture(names.map(Option::as_deref))?;
        let is_cut = texture.is_some() && source.dissolve_texture.is_some();
        let transfer = match cover {
            _ if is_cut => Transfer::Cutout,
            1.0 => Transfer::Opaque,
            _ => self.blend,
        };
        let shiny = source.shininess.filter(|ns| ns.is_finite() && *ns >= 0.0);
        let roughness = shiny.map(|ns| (2.0 / (ns + 2.0)).sqrt().sqrt());
        let emission = source.emissive.map_or(Vec3::ZERO, three);
        Ok(Material {
            name: source.name.clone(),
            transfer,
            tint: color.extend(cover),
            texture,
            roughness: share("Pr").or(roughness).unwrap_or(usual.roughness),
            metallic: share("Pm").unwrap_or(0.0),
            emission: emission.clamp(Vec3::ZERO, Vec3::splat(MAX_EMISSION)),
            ..usual
        })
    }

    /// The texture of two images; `None` if neither can be read.
    fn texture(&mut self, names: [Option<&str>; 2]) -> Result<Option<u32>, SceneError> {
        let mut image = |name: Option<&str>| {
            let name = name?;
            let path = beside(self.path, file_of(name)).filter(|path| read::is_file(path));
            if path.is_none() {
                self.missing.insert(name.to_owned());
            }
            path
        };
        let key = names.map(&mut image);
        if key == [None, None] {
            return Ok(None);
        }
        if let Some(&known) = self.images.get(&key) {
            return Ok(known);
        }
        let have = (self.earlier.textures + self.textures.len()) as u64;
        Limit::Textures.grown_in(self.path, have, 1)?;
        let [color, cover] = &key;
        let mut decoded = |path: &Path| {
            let bytes = read::bytes(path)?;
            images::decode(&bytes, MAX_SIDE, &mut self.texels)
                .map_err(|(message, help)| SceneError::invalid(path, message, &help))
        };
        let mut image = match (color, cover) {
            (Some(color), _) => decoded(color)?,
            (None, Some(cover)) => {
                let mut image = decoded(cover)?;
                image
                    .pixels_mut()
                    .for_each(|pixel| *pixel = [255, 255, 255, alpha(pixel.0)].into());
                image
            }
            (None, None) => return Ok(None),
        };
        if let (Some(_), Some(cover)) = (color, cover)
            && key[0] != key[1]
        {
            let cover = decoded(cover)?;
            let (width, height) = image.dimensions();
            // The nearest texel if the sizes differ.
            for (x, y, pixel) in image.enumerate_pixels_mut() {
                let at = |i: u32, of: u32, to: u32| {
                    (u64::from(i) * u64::from(to) / u64::from(of)) as u32
                };
                let from =
                    cover.get_pixel(at(x, width, cover.width()), at(y, height, cover.height()));
                pixel.0[3] = alpha(from.0);
            }
        }
        let index = self.textures.len() as u32;
        let path = color.as_ref().or(cover.as_ref()).map_or(self.path, PathBuf::as_path);
        let (width, height) = image.dimensions();
        let (name, rgba) = (path.display().to_string(), image.into_raw());
        self.textures.push(Texture { name, width, height, rgba });
        self.images.insert(key, Some(index));
        Ok(Some(index))
    }

    pub(super) fn finish(self, notes: &mut Vec<String>) -> (Vec<Material>, Vec<Texture>) {
        let name = self.path.display();
        if !self.missing.is_empty() {
            let mut missing: Vec<&String> = self.missing.iter().collect();
            missing.sort_unstable();
            let names: Vec<String> =
                missing.into_iter().take(12).map(|name| super::error::quoted(name)).collect();
            notes.push(format!("{name}: images that cannot be found: {}", names.join(", ")));
        }
        let has = |key: &str| match key {
            "Ka" => self.source.iter().any(|material| material.ambient_texture.is_some()),
            "Ks" => self.source.iter().any(|material| material.specular_texture.is_some()),
            "illum" => self.source.iter().any(|material| material.normal_texture.is_some()),
            _ => self.source.iter().any(|material| material.unknown_param.contains_key(key)),
        };
        let words = |key: &str| match key {
            "Ka" => "map_Ka",
            "Ks" => "map_Ks",
            "illum" => "map_Bump",
            _ => "Tf",
        };
        let unread: Vec<&str> = UNREAD.into_iter().filter(|key| has(key)).map(words).collect();
        if !unread.is_empty() {
            notes.push(format!("{name}: not read of its materials: {}", unread.join(", ")));
        }
        (self.made, self.textures)
    }
}

/// Path of a file that an OBJ or MTL names, in its folder or below; programs write both kinds of slashes.
pub(super) fn beside(path: &Path, name: &str) -> Option<PathBuf> {
    let name = name.trim().replace('\\', "/");
    if name.contains(':') || read::leaves_folder(Path::new(&name)) {
        return None;
    }
    Some(path.with_file_name("").join(name))
}

/// The file's name in a line that may begin with options.
fn file_of(line: &str) -> &str {
    if line.starts_with('-') {
        line.rsplit(char::is_whitespace).next().unwrap_or(line)
    } else {
        line
    }
}

/// Coverage by an image: its alpha or, if it is opaque, its red channel.
fn alpha([r, _, _, a]: [u8; 4]) -> u8 {
    if a < 255 { a } else { r }
}
