//! Scene files to scenes: everything is checked here, and nothing unchecked gets past.
use super::{
    Scene, SceneError, defaults,
    displace::Displaced,
    document::{Document, EnvironmentTable, MeshTable, ParticlesTable, ShapeTable, TextureSource},
    generate::Generate,
    gltf, light_tables,
    noise::Animated,
    particles::{self, FARTHEST},
    shapes,
    source::{self, Source},
    tables,
};
use crate::model::{Material, ShadowSettings, Skipped, volume};
use glam::{EulerRot, Mat4, Quat, Vec3};
use std::{
    ops::Range,
    path::{Path, PathBuf},
    sync::Arc,
};
use toml::Spanned;

/// Longest side of a texture [texels].
const MAX_IMAGE: u32 = 8192;

/// Reads a `.toml`, `.glb`, `.gltf`, `.ply` or `.csv` file.
pub fn load(path: &Path) -> Result<Scene, SceneError> {
    load_with(path, &[])
}

/// As [`load`]; `set` replaces values of the scene file before they are checked: dotted keys such
/// as `shadow.size`, `light.sun.intensity` or `material.0.tint`, and TOML values.
pub fn load_with(path: &Path, set: &[(String, String)]) -> Result<Scene, SceneError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let file = match extension.as_str() {
        "toml" => std::fs::read_to_string(path)
            .map_err(|source| SceneError::Read { path: path.to_owned(), source })?,
        "glb" | "gltf" | "ply" | "csv" => String::new(),
        _ => {
            let help = "a scene is a .toml, .glb, .gltf, .ply or .csv file";
            let message = format!("no known kind of scene: {extension:?}");
            return Err(SceneError::invalid(path, message, help));
        }
    };
    let file = match extension.as_str() {
        "ply" | "csv" => defaults::PARTICLE_MATERIAL.to_owned(),
        _ => file,
    };
    // So that `light.sun.size` can be set where the file leaves the light out.
    let file = match file.parse::<toml::Table>() {
        Ok(table) if !table.contains_key("light") && sets_light(set) => file + defaults::SUN,
        _ => file,
    };
    let text = source::joined(&file, set);
    let source = Source::parse(path, &text, file.len(), set)?;
    let document = source.document()?;
    let mut loader = Loader {
        source: &source,
        folder: path.parent().map(Path::to_owned).unwrap_or_default(),
        scene: defaults::empty_scene(),
        names: Vec::new(),
        radii: Vec::new(),
        next_id: 0,
        model_camera: None,
    };
    loader.document(&document)?;
    match extension.as_str() {
        "glb" | "gltf" => loader.model(path, Mat4::IDENTITY)?,
        "ply" | "csv" => {
            let material = loader.scene.materials[0].clone();
            loader.particle_file(path, &material, 0, loader.radii[0])?;
        }
        _ => {}
    }
    let Loader { mut scene, model_camera, .. } = loader;
    // Before the ground is added: the camera looks at what the file holds.
    let bounds = scene.bounds();
    scene.camera = match &document.camera {
        Some(table) => tables::camera(&source, table, model_camera, &bounds)?,
        None => model_camera.unwrap_or_else(|| defaults::camera(&bounds)),
    };
    if extension != "toml" {
        defaults::add_ground(&mut scene);
    }
    if scene.lights.is_empty() {
        scene.lights.push(defaults::sun());
    }
    Ok(scene)
}

fn sets_light(set: &[(String, String)]) -> bool {
    set.iter().any(|(key, _)| key.starts_with("light."))
}

struct Loader<'a> {
    source: &'a Source<'a>,
    folder: PathBuf,
    scene: Scene,
    /// Of the file's materials, which come first.
    names: Vec<String>,
    /// Of the file's materials [m].
    radii: Vec<Option<f32>>,
    next_id: u32,
    model_camera: Option<super::Camera>,
}

impl Loader<'_> {
    fn error(&self, table: &Range<usize>, key: &str, message: &str, help: &str) -> SceneError {
        self.source.error_at(table, key, message, help)
    }

    fn document(&mut self, document: &Document) -> Result<(), SceneError> {
        let source = self.source;
        self.scene.shadow = match &document.shadow {
            Some(table) => tables::shadow(source, table)?,
            None => ShadowSettings::default(),
        };
        if let Some(table) = &document.clusters {
            self.scene.clusters = tables::clusters(source, table)?;
        }
        if let Some(table) = &document.environment {
            let EnvironmentTable { ambient, background } = table.get_ref();
            let color = |key, value: &Option<[f32; 3]>, usual: Vec3| match value {
                None => Ok(usual),
                Some(rgb) if rgb.iter().all(|v| v.is_finite() && *v >= 0.0) => Ok((*rgb).into()),
                Some(rgb) => {
                    let message = format!("{key} is {rgb:?}");
                    Err(self.error(
                        &table.span(),
                        key,
                        &message,
                        "light is finite and not negative",
                    ))
                }
            };
            let ambient = color("ambient", ambient, self.scene.ambient)?;
            let background = color("background", background, self.scene.background)?;
            (self.scene.ambient, self.scene.background) = (ambient, background);
        }
        if let Some(table) = &document.air {
            self.scene.air = tables::air(source, table)?;
        }
        for (index, table) in document.light.iter().enumerate() {
            let light = light_tables::light(source, table, index)?;
            if self.scene.lights.iter().any(|known| known.name == light.name) {
                let message = format!("a second light named {:?}", light.name);
                return Err(self.error(
                    &table.span(),
                    "name",
                    &message,
                    "give each light its own name",
                ));
            }
            self.scene.lights.push(light);
        }
        for table in &document.material {
            let (material, image) = tables::material(source, table)?;
            if self.names.contains(&material.name) {
                let message = format!("a second material named {:?}", material.name);
                return Err(self.error(
                    &table.span(),
                    "name",
                    &message,
                    "give each material its own name",
                ));
            }
            let texture = match image {
                None => None,
                Some(TextureSource::File(file)) => Some(self.image(&file)?),
                Some(TextureSource::Noise(noise)) => {
                    let index = self.scene.textures.len() as u32;
                    let name = format!("noise of {}", material.name);
                    self.scene.textures.push(noise.texture(name, 0.0));
                    if noise.moves() {
                        self.scene.motions.push(Arc::new(Animated { texture: index, noise }));
                    }
                    Some(index)
                }
            };
            self.names.push(material.name.clone());
            self.radii.push(table.get_ref().radius);
            self.scene.materials.push(Material { texture, ..material });
        }
        for table in &document.particles {
            self.particles(table)?;
        }
        for table in &document.shape {
            self.shape(table)?;
        }
        for table in &document.mesh {
            let MeshTable { file, translation, rotation, scale } = table.get_ref();
            let transform = self.transform(&table.span(), *translation, *rotation, *scale)?;
            self.model(&self.folder.join(file), transform)?;
        }
        Ok(())
    }

    /// Index of a material by its name.
    fn material(&self, span: &Range<usize>, name: &str) -> Result<u32, SceneError> {
        if let Some(index) = self.names.iter().position(|known| known == name) {
            return Ok(index as u32);
        }
        let help = source::nearest(name, self.names.iter().map(String::as_str))
            .unwrap_or_else(|| "add a [[material]] with this name".to_owned());
        Err(self.error(span, "material", &format!("no material is named {name:?}"), &help))
    }

    fn transform(
        &self,
        span: &Range<usize>,
        translation: Option<[f32; 3]>,
        rotation: Option<[f32; 3]>,
        scale: Option<[f32; 3]>,
    ) -> Result<Mat4, SceneError> {
        let translation = translation.unwrap_or([0.0; 3]);
        let rotation = rotation.unwrap_or([0.0; 3]);
        let scale = scale.unwrap_or([1.0; 3]);
        for (key, values) in
            [("translation", translation), ("rotation", rotation), ("scale", scale)]
        {
            if !values.iter().all(|v| v.is_finite() && v.abs() <= FARTHEST) {
                let message = format!("{key} is {values:?}");
                return Err(self.error(span, key, &message, "use finite numbers up to 1e7"));
            }
        }
        if scale.contains(&0.0) {
            let help = "use a small number to flatten a shape";
            return Err(self.error(span, "scale", "scale has a 0", help));
        }
        let [x, y, z] = rotation.map(f32::to_radians);
        let turn = Quat::from_euler(EulerRot::XYZ, x, y, z);
        Ok(Mat4::from_scale_rotation_translation(scale.into(), turn, translation.into()))
    }

    fn shape(&mut self, table: &Spanned<ShapeTable>) -> Result<(), SceneError> {
        let ShapeTable { kind, material, level, displace, translation, rotation, scale } =
            table.get_ref();
        let level = level.unwrap_or(shapes::SPHERE_LEVEL);
        if level > shapes::MAX_LEVEL {
            let help = format!("at most {}", shapes::MAX_LEVEL);
            let message = format!("level is {level}");
            return Err(self.error(&table.span(), "level", &message, &help));
        }
        let material = self.material(&table.span(), material)?;
        let transform = self.transform(&table.span(), *translation, *rotation, *scale)?;
        let mut triangles = shapes::shape(*kind, level, transform, material, self.next_id);
        if let Some(displace) = *displace {
            if let Some((message, help)) = displace.fault(*kind) {
                return Err(self.error(&table.span(), "displace", &message, help));
            }
            let first_triangle = self.scene.triangles.len();
            let displaced =
                Displaced { first_triangle, displace, level, world_from_sphere: transform };
            displaced.set_time(&mut triangles, 0.0);
            if displace.moves() {
                self.scene.motions.push(Arc::new(displaced));
            }
        }
        if self.scene.materials[material as usize].is_volume() {
            if !volume::is_closed(&triangles) {
                let help = "use a closed shape, or a material without attenuation";
                let message = "a volume needs an inside";
                return Err(self.error(&table.span(), "kind", message, help));
            }
            volume::turn_outwards(&mut triangles);
        }
        self.next_id = self.next_id.wrapping_add(1);
        let mut corners = triangles.iter().flat_map(|triangle| triangle.positions);
        if corners.any(|corner| corner.abs().max_element() > FARTHEST) {
            let help = "move it towards the origin or make it smaller";
            let message = "the shape reaches beyond 1e7 m";
            return Err(self.error(&table.span(), "translation", message, help));
        }
        self.scene.triangles.extend(triangles);
        Ok(())
    }

    fn particles(&mut self, table: &Spanned<ParticlesTable>) -> Result<(), SceneError> {
        let ParticlesTable { file, generate, material } = table.get_ref();
        let id = self.material(&table.span(), material)?;
        if self.scene.materials[id as usize].is_volume() {
            let help = "use shape = \"puff\", and no attenuation";
            let message = "particles have no volume";
            return Err(self.error(&table.span(), "material", message, help));
        }
        match (file, generate) {
            (Some(file), None) => {
                let material = self.scene.materials[id as usize].clone();
                let path = self.folder.join(file);
                self.particle_file(&path, &material, id, self.radii[id as usize])
            }
            (None, Some(generate)) => {
                if generate.count() > Generate::MAX_COUNT {
                    let message = format!("count is {}", generate.count());
                    let help = format!("at most {}", Generate::MAX_COUNT);
                    return Err(self.error(&table.span(), "generate", &message, &help));
                }
                if let Some((name, value, _)) =
                    generate.numbers().into_iter().find(|&(_, value, positive)| {
                        !value.is_finite() || value.abs() > FARTHEST || (positive && value <= 0.0)
                    })
                {
                    let message = format!("{name} is {value}");
                    let help = "lengths are finite, up to 1e7 and above 0";
                    return Err(self.error(&table.span(), "generate", &message, help));
                }
                let particles = generate.particles(id, self.next_id);
                self.next_id = self.next_id.wrapping_add(particles.len() as u32);
                for particle in particles {
                    if particle.center.abs().max_element().max(particle.radius) <= FARTHEST {
                        self.scene.particles.push(particle);
                    } else {
                        *self.scene.skipped.entry("too far").or_default() += 1;
                    }
                }
                Ok(())
            }
            _ => {
                let message = "particles need either a file or generate";
                Err(self.error(&table.span(), "file", message, "give one of the two"))
            }
        }
    }

    fn particle_file(
        &mut self,
        path: &Path,
        material: &Material,
        material_id: u32,
        radius: Option<f32>,
    ) -> Result<(), SceneError> {
        let file = particles::load(path, material, material_id, radius, self.next_id)?;
        let rows = file.particles.len() as u64 + file.skipped.values().sum::<u64>();
        self.next_id = self.next_id.wrapping_add(rows as u32);
        self.scene.particles.extend(file.particles);
        add_skipped(&mut self.scene.skipped, &file.skipped);
        Ok(())
    }

    fn model(&mut self, path: &Path, transform: Mat4) -> Result<(), SceneError> {
        let model = gltf::load(path, transform)?;
        let first_material = self.scene.materials.len() as u32;
        let first_id = self.next_id;
        let objects = model.triangles.iter().map(|t| t.id + 1).max().unwrap_or(0);
        let first_texture = self.scene.textures.len() as u32;
        self.scene.textures.extend(model.textures);
        self.scene.materials.extend(model.materials.into_iter().map(|material| Material {
            texture: material.texture.map(|index| index + first_texture),
            ..material
        }));
        self.scene.triangles.extend(model.triangles.into_iter().map(|mut triangle| {
            triangle.material += first_material;
            triangle.id = triangle.id.wrapping_add(first_id);
            triangle
        }));
        self.next_id = self.next_id.wrapping_add(objects);
        self.scene.lights.extend(model.lights);
        self.model_camera = self.model_camera.take().or(model.camera);
        add_skipped(&mut self.scene.skipped, &model.skipped);
        Ok(())
    }

    /// Reads an image once; its index.
    fn image(&mut self, file: &Path) -> Result<u32, SceneError> {
        let path = self.folder.join(file);
        let name = path.display().to_string();
        if let Some(known) = self.scene.textures.iter().position(|t| t.name == name) {
            return Ok(known as u32);
        }
        let read_error = |source| SceneError::Read { path: path.clone(), source };
        let mut reader = image::ImageReader::open(&path)
            .and_then(image::ImageReader::with_guessed_format)
            .map_err(read_error)?;
        // Before decoding: a few bytes may promise gigabytes.
        let mut limits = image::Limits::default();
        (limits.max_image_width, limits.max_image_height) = (Some(MAX_IMAGE), Some(MAX_IMAGE));
        reader.limits(limits);
        let help = format!("use a PNG or JPEG of at most {MAX_IMAGE} texels a side");
        let image =
            reader.decode().map_err(|e| SceneError::invalid(&path, e.to_string(), &help))?;
        let image = image.into_rgba8();
        let (width, height) = image.dimensions();
        let rgba = image.into_raw();
        self.scene.textures.push(crate::model::Texture { name, width, height, rgba });
        Ok(self.scene.textures.len() as u32 - 1)
    }
}

fn add_skipped(sum: &mut Skipped, more: &Skipped) {
    for (reason, count) in more {
        *sum.entry(reason).or_default() += count;
    }
}
