//! Loads the files that a scene names: particles, models and images.
use super::{
    SceneError,
    document::ParticlesTable,
    generate::Generate,
    gltf, images,
    limits::{self, Limit},
    loader::Loader,
    models,
    particles::{self, FARTHEST},
    points, read,
    rig::{Moving, Placement},
    share::Share,
};
use gobo::model::{Bounds, Class, Material, Motion as _, Particle, Skipped, Texture};
use rayon::prelude::*;
use std::{ops::Range, path::Path, sync::Arc};
use toml::Spanned;

/// Particles that one core, and all cores, generate at a time; the memory of a wave is needed twice.
const BLOCK: u64 = 1 << 14;
const WAVE: u64 = 1 << 20;
/// Longest side of a texture \[texels\].
pub(super) const MAX_SIDE: u32 = 8192;

impl Loader<'_> {
    pub(super) fn particles(&mut self, table: &Spanned<ParticlesTable>) -> Result<(), SceneError> {
        let ParticlesTable { file, generate, point_budget, classes, material } = table.get_ref();
        let id = self.material_of_grains(&table.span(), material)?;
        if self.scene.materials[id as usize].is_volume() {
            let help = "use shape = \"puff\", and no attenuation";
            let message = "particles have no volume";
            return Err(self.error(&table.span(), "material", message, help));
        }
        let path = file.as_ref().map(|file| self.folder.join(file));
        let of_clouds = [
            ("point_budget", point_budget.is_some(), "a budget"),
            ("classes", classes.is_some(), "classes"),
        ];
        if let Some((key, _, what)) = of_clouds.into_iter().find(|(_, is_given, _)| *is_given)
            && !path.as_deref().is_some_and(points::is_cloud)
        {
            let message = format!("{what} of particles that are no cloud of points");
            let help = "remove it; clouds are LAS, LAZ, PCD and E57 files";
            return Err(self.error(&table.span(), key, &message, help));
        }
        match (path, generate) {
            (Some(path), None) => self
                .particle_file(&path, id, *point_budget, classes.as_deref())
                .map_err(|e| self.named_by(&table.span(), "file", e)),
            (None, Some(generate)) => self.generated(&table.span(), generate, id),
            _ => {
                let message = "particles need either a file or generate";
                Err(self.error(&table.span(), "file", message, "give one of the two"))
            }
        }
    }

    /// Checks the parameters of a table's generator.
    pub(super) fn check_generate(
        &self,
        table: &Range<usize>,
        generate: &Generate,
    ) -> Result<(), SceneError> {
        let wrong = |&(_, value, positive): &(&str, f32, bool)| {
            !value.is_finite() || value.abs() > FARTHEST || (positive && value <= 0.0)
        };
        if let Some((name, value, _)) = generate.numbers().into_iter().find(wrong) {
            let message = format!("{name} is {value}");
            let help = "lengths are finite, up to 1e7 and above 0";
            return Err(self.error(table, "generate", &message, help));
        }
        if generate.count() == 0 {
            return Err(self.error(
                table,
                "generate",
                "count is 0",
                "1 or more, or remove the table",
            ));
        }
        Ok(())
    }

    fn generated(
        &mut self,
        table: &Range<usize>,
        generate: &Generate,
        material: u32,
    ) -> Result<(), SceneError> {
        let _phase = tracing::debug_span!("generate").entered();
        self.check_generate(table, generate)?;
        let share = self.share_of(material);
        let (have, count) = (self.scene.particles.len(), generate.count_of(share) as usize);
        self.check_limit(Limit::Particles, have, count, (table, "generate"))?;
        limits::reserve(&mut self.scene.particles, count, "particles", self.source.path())?;
        let first_id = self.next_id;
        self.next_id = self.next_id.wrapping_add(generate.count());
        let is_near = |particle: &Particle| {
            particle.center.abs().max_element().max(particle.radius) <= FARTHEST
        };
        let all = 0..u64::from(generate.count());
        let Some(share) = share else {
            for wave in all.clone().step_by(WAVE as usize) {
                let end = all.end.min(wave + WAVE);
                let block = |block: u64| {
                    let first = wave + block * BLOCK;
                    let numbers = first..end.min(first + BLOCK);
                    let particles = generate.particles(numbers, material, first_id);
                    particles.filter(is_near).collect::<Vec<_>>()
                };
                let blocks: Vec<_> =
                    (0..(end - wave).div_ceil(BLOCK)).into_par_iter().map(block).collect();
                self.scene.particles.extend(blocks.into_iter().flatten());
            }
            let left_out = count - (self.scene.particles.len() - have);
            if left_out > 0 {
                *self.scene.skipped.entry("too far").or_default() += left_out as u64;
            }
            return Ok(());
        };
        let whole = if all.end <= Limit::Particles.most() {
            let all = generate.particles(all.clone(), material, first_id).filter(is_near);
            all.fold(Bounds::EMPTY, |bounds, p| bounds.with_sphere(p.center, p.radius))
        } else {
            generate.bounds()
        };
        self.scene.around = self.scene.around.with(&whole);
        for range in share.ranges(all.end) {
            let generated = generate.particles(range, material, first_id).filter(is_near);
            self.scene.particles.extend(generated);
        }
        Ok(())
    }

    /// Share of the particles with a material that is loaded; `None` for all.
    fn share_of(&self, material: u32) -> Option<Share> {
        let class = Class::of(&self.scene.materials[material as usize]);
        self.share.filter(|_| Class::FILTERING.contains(&class))
    }

    /// Loads particles; `budget` and `classes`: of a cloud of points.
    pub(super) fn particle_file(
        &mut self,
        path: &Path,
        id: u32,
        budget: Option<u64>,
        classes: Option<&[(u8, f32)]>,
    ) -> Result<(), SceneError> {
        let material = &self.scene.materials[id as usize];
        let earlier = self.scene.particles.len() as u64;
        let radius = self.radii[id as usize];
        let first_id = self.next_id;
        let mut around = None;
        let mut file = match points::kind_of_file(path) {
            Some(kind) => {
                let share = self.share_of(id);
                let material = id;
                let wanted = points::PointsWanted {
                    material,
                    radius,
                    first_id,
                    earlier,
                    budget,
                    share,
                    classes,
                };
                let cloud = points::load(path, kind, wanted, &mut self.points_origin)?;
                self.next_id = self.next_id.wrapping_add(cloud.rows as u32);
                around = cloud.around;
                cloud.file
            }
            None => {
                let file = particles::load(path, material, id, radius, first_id, earlier)?;
                let rows = file.particles.len() as u64 + file.skipped.values().sum::<u64>();
                self.next_id = self.next_id.wrapping_add(rows as u32);
                file
            }
        };
        if let Some(around) = around {
            self.scene.around = self.scene.around.with(&around);
        } else if let Some(share) = self.share_of(id) {
            let mut numbers = 0..;
            let around = &mut self.scene.around;
            file.particles.retain(|particle| {
                *around = around.with_sphere(particle.center, particle.radius);
                numbers.next().is_some_and(|number| share.has(number))
            });
        }
        if self.scene.particles.is_empty() {
            self.scene.particles = file.particles;
        } else {
            limits::reserve(&mut self.scene.particles, file.particles.len(), "particles", path)?;
            self.scene.particles.extend(file.particles);
        }
        add_skipped(&mut self.scene.skipped, &file.skipped);
        self.scene.notes.extend(file.notes);
        Ok(())
    }

    /// Loads a model; returns its moving part, if the file has animations or keys move it.
    pub(super) fn model(
        &mut self,
        path: &Path,
        placement: Placement,
        wanted: gltf::Wanted<'_>,
    ) -> Result<Option<Moving>, SceneError> {
        let transform = placement.at(0.0);
        let earlier = gltf::Earlier {
            materials: self.scene.materials.len(),
            textures: self.scene.textures.len(),
            texels: self.texels,
            triangles: self.scene.triangles.len(),
            lights: self.scene.lights.len(),
        };
        let model = models::load(path, transform, &earlier, wanted)?;
        self.leaves_splats = model.has_splats;
        let texels = |t: &Texture| u64::from(t.width) * u64::from(t.height);
        self.texels += model.textures.iter().map(texels).sum::<u64>();
        let first_material = self.scene.materials.len() as u32;
        let first_id = self.next_id;
        let objects = model.triangles.iter().map(|t| t.id + 1).max().unwrap_or(0);
        let first_texture = self.scene.textures.len() as u32;
        self.scene.textures.extend(model.textures);
        self.scene.materials.extend(model.materials.into_iter().map(|material| Material {
            texture: material.texture.map(|index| index + first_texture),
            emissive_texture: material.emissive_texture.map(|index| index + first_texture),
            far_side: material.far_side.map(|index| index + first_material),
            details: material.details.map(|index| index + first_material),
            ..material
        }));
        limits::reserve(&mut self.scene.triangles, model.triangles.len(), "triangles", path)?;
        let first_triangle = self.scene.triangles.len();
        self.scene.triangles.extend(model.triangles.into_iter().map(|mut triangle| {
            triangle.material += first_material;
            triangle.id = triangle.id.wrapping_add(first_id);
            triangle
        }));
        let first_light = self.scene.lights.len();
        self.next_id = self.next_id.wrapping_add(objects);
        self.scene.lights.extend(model.lights);
        let is_camera = self.model_camera.is_none();
        self.model_camera = self.model_camera.take().or(model.camera);
        add_skipped(&mut self.scene.skipped, &model.skipped);
        self.scene.notes.extend(model.notes);
        let mut moving = model.rig.map(|rig| Moving {
            lights: rig.lights.iter().map(|&(light, node)| (first_light + light, node)).collect(),
            camera: rig.camera.filter(|_| is_camera),
            rig: Arc::new(rig),
            local: Arc::new(self.scene.triangles[first_triangle..].to_vec()),
            first_triangle,
            ..Moving::none(placement)
        });
        // The scene's triangles are in the spaces of their nodes until posed.
        if let Some(moving) = &mut moving {
            moving.apply(&mut self.scene, 0.0);
            moving.far = self.scene.leave_out_far_triangles();
        }
        Ok(moving)
    }

    /// Index of an image; each image is read once.
    pub(super) fn image(
        &mut self,
        file: &Path,
        (table, key): (&Range<usize>, &str),
    ) -> Result<u32, SceneError> {
        let path = self.folder.join(file);
        if let Some(&known) = self.images.get(&path) {
            return Ok(known);
        }
        let index = self.scene.textures.len();
        self.check_limit(Limit::Textures, index, 1, (table, key))?;
        let bytes = read::bytes(&path).map_err(|error| self.named_by(table, key, error))?;
        let image = images::decode(&bytes, MAX_SIDE, &mut self.texels)
            .map_err(|(message, help)| SceneError::invalid(&path, message, &help))
            .map_err(|error| self.named_by(table, key, error))?;
        let (width, height) = image.dimensions();
        let (name, rgba) = (path.display().to_string(), image.into_raw());
        self.scene.textures.push(Texture { name, width, height, rgba });
        self.images.insert(path, index as u32);
        Ok(index as u32)
    }

    /// Turns an error of a file into one of the key that names the file.
    pub(super) fn named_by(
        &self,
        table: &Range<usize>,
        key: &str,
        error: SceneError,
    ) -> SceneError {
        let help = match &error {
            SceneError::Read { .. } => "paths are relative to the scene file",
            SceneError::Invalid { help, .. } => help.as_deref().unwrap_or_default(),
            SceneError::Document { .. } | SceneError::Memory { .. } => return error,
        };
        self.error(table, key, &format!("{key}: {error}"), help)
    }
}

pub(super) fn add_skipped(sum: &mut Skipped, more: &Skipped) {
    for (reason, count) in more {
        *sum.entry(reason).or_default() += count;
    }
}
