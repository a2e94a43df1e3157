//! Conversion of a scene file's tables, one after the other, to a scene.
use super::{
    Scene, SceneError,
    animate::Placed,
    defaults,
    displace::Displaced,
    document::{Document, MaterialTable, MeshTable, ShapeTable, TextureSource},
    error::quoted,
    far_sides::far_side,
    formats,
    gltf::Wanted,
    limits::Limit,
    noise::Animated,
    particles::FARTHEST,
    plain::nearest,
    rig::{Moving, Rig},
    shapes,
    share::Share,
    source::SceneText,
    splat_file::FoundSplats,
};
use glam::DVec3;
use gobo::model::{Material, Motion, Texture, volume};
use std::{
    collections::{HashMap, HashSet},
    ops::Range,
    path::{Path, PathBuf},
    sync::Arc,
};
use toml::Spanned;

pub(super) struct Loader<'a> {
    pub(super) source: &'a SceneText<'a>,
    /// Folder of the scene file.
    pub(super) folder: PathBuf,
    pub(super) scene: Scene,
    /// Indices by name of the file's materials, which come first in the scene.
    names: HashMap<String, u32>,
    /// Radius of particles of each material \[m\].
    pub(super) radii: Vec<Option<f32>>,
    /// Textures by the path of their image.
    pub(super) images: HashMap<PathBuf, u32>,
    /// Texels of all textures.
    pub(super) texels: u64,
    pub(super) next_id: u32,
    pub(super) model_camera: Option<super::Camera>,
    /// Shapes, then meshes, that keys may move.
    pub(super) placed: Vec<Placed>,
    /// Kind and name of each entry that has a name.
    placed_names: HashSet<(&'static str, String)>,
    /// Displaced spheres that do not move.
    pub(super) still: Vec<Arc<dyn Motion>>,
    /// Whether emitters' particles and animated volumes are made for time 0.
    pub(super) makes_start: bool,
    /// The share of the filtering particles to load.
    pub(super) share: Option<Share>,
    /// Files of splats: their splats in the scene, and the id of the first row.
    pub(super) splat_files: Vec<(PathBuf, FoundSplats)>,
    /// Offset subtracted from the coordinates of all point files, once one is read \[m\].
    pub(super) points_origin: Option<DVec3>,
    /// Texels along the largest map, or pixels along the picture if they are more.
    pub(super) across: u32,
    /// Whether the last model holds splats.
    pub(super) leaves_splats: bool,
    /// Whether generated textures are made.
    pub(super) paints: bool,
    /// Emitters of which one sample was emitted, and volumes of which only the box was made.
    pub(super) resting: Vec<Arc<dyn Motion>>,
}

impl<'a> Loader<'a> {
    pub(super) fn new(source: &'a SceneText<'a>, path: &Path) -> Self {
        Self {
            source,
            folder: path.parent().map(Path::to_owned).unwrap_or_default(),
            scene: defaults::empty_scene(),
            names: HashMap::new(),
            radii: Vec::new(),
            images: HashMap::new(),
            texels: 0,
            next_id: 0,
            model_camera: None,
            placed: Vec::new(),
            placed_names: HashSet::new(),
            still: Vec::new(),
            makes_start: true,
            share: None,
            splat_files: Vec::new(),
            points_origin: None,
            across: 0,
            leaves_splats: false,
            paints: true,
            resting: Vec::new(),
        }
    }

    pub(super) fn error(
        &self,
        table: &Range<usize>,
        key: &str,
        message: &str,
        help: &str,
    ) -> SceneError {
        self.source.error_at(table, key, message, help)
    }

    /// Checks that `have` + `more` items are within a limit.
    pub(super) fn check_limit(
        &self,
        limit: Limit,
        have: usize,
        more: usize,
        (table, key): (&Range<usize>, &str),
    ) -> Result<(), SceneError> {
        let grown = limit.grown(have as u64, more as u64);
        grown.map(|_| ()).map_err(|(message, help)| self.error(table, key, &message, help))
    }

    pub(super) fn document(&mut self, document: &Document) -> Result<(), SceneError> {
        self.check_announced(document)?;
        self.scene.shadow = document.shadow;
        self.scene.mask = document.mask;
        self.scene.clusters = document.clusters;
        self.scene.air = document.air;
        if let Some(table) = &document.environment {
            self.environment(table, document.light.is_empty())?;
        }
        self.lights(document)?;
        let of_lights = self.scene.lights.iter().filter_map(|light| light.size);
        let pixels = document.camera.as_ref().and_then(|table| table.get_ref().size);
        let pixels = pixels.unwrap_or(defaults::PICTURE).max_element();
        self.across = of_lights.fold(document.shadow.size, u32::max).max(pixels);
        for (index, table) in document.material.iter().enumerate() {
            let MaterialTable { material, texture, radius, .. } = table.get_ref();
            self.check_limit(Limit::Materials, index, 1, (&table.span(), "name"))?;
            let texture = texture.as_ref().map(|image| self.texture(table, image)).transpose()?;
            if self.names.insert(material.name.clone(), index as u32).is_some() {
                let message = format!("a second material named {}", quoted(&material.name));
                let help = "give each material its own name";
                return Err(self.error(&table.span(), "name", &message, help));
            }
            self.radii.push(*radius);
            self.scene.materials.push(Material { texture, ..material.clone() });
        }
        self.far_sides(document)?;
        for table in &document.particles {
            self.particles(table)?;
        }
        let is_keyed = |kind: &str| {
            document.animate.iter().any(|keyed| keyed.get_ref().target.starts_with(kind))
        };
        for table in &document.splats {
            self.splats(table, is_keyed("splats."))?;
        }
        for table in &document.shape {
            self.shape(table)?;
        }
        for table in &document.mesh {
            let MeshTable { name, file, casts, transfer, variant, placement } = table.get_ref();
            let path = self.folder.join(file);
            formats::refuse_foreign(&path).map_err(|e| self.named_by(&table.span(), "file", e))?;
            let first_material = self.scene.materials.len();
            let first_triangle = self.scene.triangles.len();
            let (blend, is_keyed) = (*transfer, is_keyed("mesh."));
            let wanted = Wanted { blend, is_keyed, variant: variant.as_deref() };
            let moving = self
                .model(&path, placement.clone(), wanted)
                .map_err(|e| self.named_by(&table.span(), "file", e))?;
            for material in &mut self.scene.materials[first_material..] {
                material.casts &= casts;
            }
            if self.leaves_splats {
                let name = path.display();
                self.scene.notes.push(format!("{name}: its splats are read by a [[splats]] table"));
            }
            let triangles = first_triangle..self.scene.triangles.len();
            self.place("mesh", &table.span(), name.as_ref(), triangles, moving)?;
        }
        for table in &document.volume {
            self.volume(table)?;
        }
        for table in &document.strands {
            self.strands(table, is_keyed("strands."))?;
        }
        self.emitters(&document.emitter)
    }

    fn lights(&mut self, document: &Document) -> Result<(), SceneError> {
        let mut names = HashSet::new();
        let (mut sources, mut bounces) = (0, 0);
        for (index, table) in document.light.iter().enumerate() {
            self.check_limit(Limit::Lights, index, 1, (&table.span(), "kind"))?;
            let light = table.get_ref();
            if !names.insert(light.name.clone()) {
                let message = format!("a second light named {}", quoted(&light.name));
                let help = "give each light its own name";
                return Err(self.error(&table.span(), "name", &message, help));
            }
            if light.area().is_some() {
                let viewpoints = light.viewpoint_count() as usize;
                self.check_limit(Limit::Sources, sources, viewpoints, (&table.span(), "source"))?;
                sources += viewpoints;
            }
            let points = light.bounce_count() as usize;
            self.check_limit(Limit::Bounces, bounces, points, (&table.span(), "bounce"))?;
            bounces += points;
            self.scene.lights.push(light.clone());
        }
        Ok(())
    }

    fn texture(
        &mut self,
        table: &Spanned<MaterialTable>,
        image: &TextureSource,
    ) -> Result<u32, SceneError> {
        let place = (&table.span(), "texture");
        match image {
            TextureSource::File(file) => self.image(file, place),
            &TextureSource::Noise(noise) => {
                let index = self.scene.textures.len();
                self.check_limit(Limit::Textures, index, 1, place)?;
                let texels = (noise.size * noise.size) as usize;
                self.check_limit(Limit::Texels, self.texels as usize, texels, place)?;
                self.texels += texels as u64;
                let name = format!("noise of {}", table.get_ref().material.name);
                if !self.paints {
                    let rgba = vec![u8::MAX; 4];
                    self.scene.textures.push(Texture { name, width: 1, height: 1, rgba });
                    return Ok(index as u32);
                }
                self.scene.textures.push(noise.texture(name, 0.0));
                if noise.moves() {
                    self.scene.motions.push(Arc::new(Animated { texture: index as u32, noise }));
                }
                Ok(index as u32)
            }
        }
    }

    /// Index of a material by its name.
    pub(super) fn material(&self, span: &Range<usize>, name: &str) -> Result<u32, SceneError> {
        if let Some(&index) = self.names.get(name) {
            return Ok(index);
        }
        let mut known: Vec<&str> = self.names.keys().map(String::as_str).collect();
        known.sort_unstable();
        let help =
            nearest(name, known).unwrap_or_else(|| "add a [[material]] with this name".to_owned());
        let message = format!("no material is named {}", quoted(name));
        Err(self.error(span, "material", &message, &help))
    }

    /// Adds the far-side materials of the file's materials.
    pub(super) fn far_sides(&mut self, document: &Document) -> Result<(), SceneError> {
        for (index, table) in document.material.iter().enumerate() {
            let MaterialTable { far_side: Some((share, color)), .. } = table.get_ref() else {
                continue;
            };
            let last = self.scene.materials.len();
            let place = (&table.span(), "diffuse_transmission");
            self.check_limit(Limit::Materials, last, 1, place)?;
            let material = &mut self.scene.materials[index];
            let far = far_side(material, last as u32, *share, *share * *color);
            self.scene.materials.push(far);
        }
        Ok(())
    }

    /// Like [`Self::material`], for casters without a far side.
    pub(super) fn material_of_grains(
        &self,
        span: &Range<usize>,
        name: &str,
    ) -> Result<u32, SceneError> {
        let index = self.material(span, name)?;
        if self.scene.materials[index as usize].far_side.is_some() {
            let message = "only shapes and meshes have a far side";
            let help = "use a material without diffuse_transmission";
            return Err(self.error(span, "material", message, help));
        }
        Ok(index)
    }

    /// Adds a shape or mesh to the parts that keys may move.
    pub(super) fn place(
        &mut self,
        kind: &'static str,
        table: &Range<usize>,
        name: Option<&String>,
        triangles: Range<usize>,
        moving: Option<Moving>,
    ) -> Result<(), SceneError> {
        if let Some(name) = name
            && !self.placed_names.insert((kind, name.clone()))
        {
            let message = format!("a second {kind} named {}", quoted(name));
            return Err(self.error(table, "name", &message, "give each its own name"));
        }
        self.placed.push(Placed { kind, name: name.cloned(), triangles, moving });
        Ok(())
    }

    fn shape(&mut self, table: &Spanned<ShapeTable>) -> Result<(), SceneError> {
        let ShapeTable { name, kind, material, level, displace, placement } = table.get_ref();
        let (kind, level) = (*kind, *level);
        let material = self.material(&table.span(), material)?;
        let transform = placement.at(0.0);
        let (have, more) = (self.scene.triangles.len(), shapes::triangles_of(kind, level));
        self.check_limit(Limit::Triangles, have, more, (&table.span(), "level"))?;
        let mut local = shapes::local(kind, level, material, self.next_id);
        let mut triangles = shapes::shape(kind, level, transform, material, self.next_id);
        if let Some(displace) = *displace {
            let displaced = Displaced {
                first_triangle: have,
                displace,
                level,
                world_from_sphere: transform,
                material,
            };
            displaced.set_time(&mut triangles, 0.0);
            let parts = if displace.moves() { &mut self.scene.motions } else { &mut self.still };
            parts.push(Arc::new(displaced));
        }
        if self.scene.materials[material as usize].is_volume() {
            if !volume::is_closed(&triangles) {
                let help = "use a closed shape, or a material without attenuation";
                let message = "a volume needs an inside";
                return Err(self.error(&table.span(), "kind", message, help));
            }
            volume::turn_outwards(&mut triangles);
            volume::turn_outwards(&mut local);
        }
        self.next_id = self.next_id.wrapping_add(1);
        let mut corners = triangles.iter().flat_map(|triangle| triangle.positions);
        if corners.any(|corner| corner.abs().max_element() > FARTHEST) {
            let help = "move it towards the origin or make it smaller";
            let message = "the shape reaches beyond 1e7 m";
            return Err(self.error(&table.span(), "translation", message, help));
        }
        let moving = displace.is_none().then(|| Moving {
            rig: Arc::new(Rig::whole(local.len())),
            local: Arc::new(local),
            first_triangle: self.scene.triangles.len(),
            ..Moving::none(placement.clone())
        });
        self.scene.triangles.extend(triangles);
        let triangles = have..self.scene.triangles.len();
        self.place("shape", &table.span(), name.as_ref(), triangles, moving)
    }
}

/// An error at a line, counted from 1, without a scene file to quote.
pub(super) fn error_of_line(path: &Path, line: usize, message: &str, help: &str) -> SceneError {
    SceneError::invalid(path, format!("line {line}: {message}"), help)
}
