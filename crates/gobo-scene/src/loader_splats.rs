//! Loads splats from files, or generates them.
use super::{
    SceneError,
    document::{Cast, Opacity, SplatsTable},
    generate::{Chance, Generate},
    limits::{self, Limit},
    loader::Loader,
    loader_files::add_skipped,
    rig::{Moving, Placement},
    splat_file::{FoundSplats, load_level},
    splats::{Detail, SplatCloud, SplatKind, placed},
    volumes::USUAL_THICKNESS,
};
use glam::{DVec3, Quat, Vec3};
use gobo::model::{Gaussian, GaussianOpacity, Material, Shape};
use std::{f32::consts::TAU, f64::consts::TAU as DTAU, ops::Range, path::Path, sync::Arc};
use toml::Spanned;

/// Longest deviation of a generated splat, in radii of the particle that it replaces: a soft disc is about as
/// wide as a Gaussian of half its radius.
const DEVIATION: f32 = 0.5;

/// Most extinction of a medium that is rendered on its own [1/m].
const MOST_ALONE: f32 = 1e4;

impl Loader<'_> {
    pub(super) fn splats(
        &mut self,
        table: &Spanned<SplatsTable>,
        is_keyed: bool,
    ) -> Result<(), SceneError> {
        let (span, given) = (table.span(), table.get_ref());
        let material = match &given.material {
            None => Material { name: "splats".to_owned(), ..Material::default() },
            Some(name) => {
                let index = self.material_of_grains(&span, name)?;
                self.scene.materials[index as usize].clone()
            }
        };
        if material.is_volume() {
            let message = "splats have no volume";
            let help = "set opacity = \"medium\", and no attenuation";
            return Err(self.error(&span, "material", message, help));
        }
        if given.lod.is_some() && given.file.is_none() {
            let help = "name a file that has levels of detail, or remove lod";
            return Err(self.error(&span, "lod", "lod of splats without a file", help));
        }
        let cloud = match (&given.file, &given.generate) {
            (Some(file), None) => {
                let path = self.folder.join(file);
                let cloud = load_level(&path, self.detail(given.lod))
                    .map_err(|e| self.named_by(&span, "file", e))?;
                self.note_of_file(&path, &cloud);
                cloud
            }
            (None, Some(generate)) => self.generated_splats(&span, generate)?,
            _ => {
                let message = "splats need either a file or generate";
                return Err(self.error(&span, "file", message, "give one of the two"));
            }
        };
        let material = self.splat_material(&span, given, material, &cloud)?;
        let place = (&span, if given.file.is_some() { "file" } else { "generate" });
        self.check_limit(Limit::Materials, self.scene.materials.len(), 1, place)?;
        self.check_limit(Limit::Splats, self.scene.gaussians.len(), cloud.splats.len(), place)?;
        let (first, first_id) = (self.scene.gaussians.len(), self.next_id);
        let moving = self.add_splats(cloud, material, &given.placement, is_keyed)?;
        if let Some(file) = &given.file {
            let range = first..self.scene.gaussians.len();
            let path = self.folder.join(file);
            self.splat_files
                .push((path, FoundSplats { range, first_id, detail: self.detail(given.lod) }));
        }
        self.place("splats", &span, given.name.as_ref(), 0..0, moving)
    }

    fn detail(&self, lod: Option<u32>) -> Detail {
        Detail { lod, across: self.across }
    }

    /// Loads splats that alone are a scene; `kind`: of a file other than glTF.
    pub(super) fn splats_alone(
        &mut self,
        path: &Path,
        kind: Option<SplatKind>,
    ) -> Result<(), SceneError> {
        let mut cloud = load_level(path, self.detail(None))?;
        let is_turned = kind.is_some_and(SplatKind::points_down) && cloud.extinction.is_none();
        let rotation = if is_turned { Vec3::X * 180.0 } else { Vec3::ZERO };
        if is_turned {
            self.note_turned(path);
        }
        let thickness = thickness(&cloud);
        if let Some(density) = cloud.extinction.filter(|_| thickness > 0.0) {
            let factor = ((USUAL_THICKNESS / thickness) as f32).min(MOST_ALONE / density);
            if factor > 1.0 {
                cloud.extinction = Some(density * factor);
                let name = path.display();
                self.scene.notes.push(format!(
                    "{name}: taken {factor:.3} times as dense as it is: a [[splats]] table reads it as it is"
                ));
            }
        }
        self.add_neutral(path, cloud, rotation)
    }

    /// The splats of a file; if no table names the file, they are added as they are.
    pub(super) fn found_splats(&mut self, path: &Path) -> Result<FoundSplats, SceneError> {
        let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let mut known = self.splat_files.iter();
        if let Some((_, found)) = known.find(|known| whole(&known.0) == whole(path)) {
            return Ok(found.clone());
        }
        let (first, first_id) = (self.scene.gaussians.len(), self.next_id);
        let detail = self.detail(None);
        let cloud = load_level(path, detail)?;
        self.add_neutral(path, cloud, Vec3::ZERO)?;
        Ok(FoundSplats { range: first..self.scene.gaussians.len(), first_id, detail })
    }

    /// Adds splats with a neutral shadow. `rotation`: Euler xyz \[degrees\].
    fn add_neutral(
        &mut self,
        path: &Path,
        cloud: SplatCloud,
        rotation: Vec3,
    ) -> Result<(), SceneError> {
        self.note_of_file(path, &cloud);
        let material = Material {
            name: "splats".to_owned(),
            shape: Shape::Gaussian,
            gaussian: opacity_of(None, None, &cloud).unwrap_or_default(),
            neutral: true,
            ..Material::default()
        };
        let placement = Placement::still(Vec3::ZERO, rotation, Vec3::ONE);
        self.add_splats(cloud, material, &placement, false).map(|_| ())
    }

    pub(super) fn note_turned(&mut self, path: &Path) {
        let name = path.display();
        let note = "turned by 180 degrees about x, as y points down in most such files; a \
                    [[splats]] table reads it as it is";
        self.scene.notes.push(format!("{name}: {note}"));
    }

    fn note_of_file(&mut self, path: &Path, cloud: &SplatCloud) {
        let name = path.display();
        self.scene.notes.extend(cloud.notes.iter().map(|note| format!("{name}: {note}")));
    }

    /// The material of a table's splats, from the one that the table names.
    fn splat_material(
        &self,
        span: &Range<usize>,
        given: &SplatsTable,
        material: Material,
        cloud: &SplatCloud,
    ) -> Result<Material, SceneError> {
        let gaussian = opacity_of(given.opacity, given.density, cloud).map_err(|message| {
            let key = if given.opacity.is_some() { "opacity" } else { "density" };
            let help = "the two meanings of opacity are never converted into each other";
            self.error(span, key, message, help)
        })?;
        Ok(Material {
            shape: Shape::Gaussian,
            gaussian,
            neutral: given.cast == Cast::Neutral,
            casts: material.casts && given.cast != Cast::None,
            ..material
        })
    }

    /// Adds the splats of a cloud; returns their movable part.
    fn add_splats(
        &mut self,
        cloud: SplatCloud,
        material: Material,
        placement: &Placement,
        is_keyed: bool,
    ) -> Result<Option<Moving>, SceneError> {
        let index = self.scene.materials.len() as u32;
        let (max_color, opacity) = (material.transfer.max_color(), material.gaussian);
        self.scene.materials.push(material);
        let first_gaussian = self.scene.gaussians.len();
        let count = cloud.splats.len();
        let path = self.source.path();
        limits::reserve(&mut self.scene.gaussians, count, "splats", path)?;
        let world = placement.at(0.0);
        let mut local = Vec::new();
        if is_keyed {
            limits::reserve(&mut local, count, "splats", path)?;
        }
        for (i, splat) in cloud.splats.into_iter().enumerate() {
            let id = self.next_id.wrapping_add(cloud.rows.get(i).map_or(i as u32, |row| *row));
            let splat = Gaussian { material: index, id, ..splat };
            let placed = placed(&splat, &world);
            match placed.problem(max_color, opacity) {
                None => {
                    self.scene.gaussians.push(placed);
                    if is_keyed {
                        local.push(splat);
                    }
                }
                Some(reason) => *self.scene.skipped.entry(reason).or_default() += 1,
            }
        }
        let rows = count as u64 + cloud.skipped.values().sum::<u64>();
        self.next_id = self.next_id.wrapping_add(rows as u32);
        add_skipped(&mut self.scene.skipped, &cloud.skipped);
        Ok(is_keyed.then(|| Moving {
            gaussians: Arc::new(local),
            first_gaussian,
            ..Moving::none(placement.clone())
        }))
    }

    fn generated_splats(
        &mut self,
        span: &Range<usize>,
        generate: &Generate,
    ) -> Result<SplatCloud, SceneError> {
        let _phase = tracing::debug_span!("generate").entered();
        self.check_generate(span, generate)?;
        let room = SplatCloud::with_room(generate.count().into());
        let mut cloud =
            room.map_err(|(message, help)| self.error(span, "generate", &message, help))?;
        let mut chance = Chance::new(generate.seed() ^ u64::from(u32::MAX));
        for particle in generate.particles(0..generate.count().into(), 0, 0) {
            let mut three =
                |least, most| Vec3::from_array([(); 3].map(|()| chance.within(least, most)));
            let axis = three(-1.0, 1.0).normalize_or(Vec3::X);
            let shape = three(0.2, 1.0) * particle.radius * DEVIATION;
            cloud.push(Gaussian {
                center: particle.center,
                rotation: Quat::from_axis_angle(axis, chance.within(0.0, TAU)),
                sigma: shape,
                color: particle.color.truncate(),
                opacity: particle.color.w,
                ..Gaussian::default()
            });
        }
        Ok(cloud.finish())
    }
}

/// Mean optical depth of a medium along y, weighted by absorption, as if the medium were one Gaussian; 0 for
/// splats.
fn thickness(cloud: &SplatCloud) -> f64 {
    let (mut all, mut first, mut second) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for splat in &cloud.splats {
        let (center, sigma) = (splat.center.as_dvec3(), splat.sigma.as_dvec3());
        let depth = f64::from(splat.opacity) * sigma.element_product() * DTAU.powf(1.5);
        all += depth;
        first += depth * center;
        second += depth * (center * center + sigma.length_squared() / 3.0);
    }
    let spread = second / all - (first / all) * (first / all);
    let thickness = f64::from(cloud.extinction.unwrap_or(0.0)) * all
        / (2.0 * DTAU * (spread.x * spread.z).sqrt());
    if thickness.is_finite() { thickness } else { 0.0 }
}

/// Meaning of a cloud's opacity, by a table's keys and the file.
fn opacity_of(
    opacity: Option<Opacity>,
    density: Option<f32>,
    cloud: &SplatCloud,
) -> Result<GaussianOpacity, &'static str> {
    match (opacity, density.or(cloud.extinction)) {
        (Some(Opacity::Splat), _) if cloud.extinction.is_some() => {
            Err("the file holds the extinction of a medium, not opacities of splats")
        }
        (Some(Opacity::Splat), _) | (None, None) => Ok(GaussianOpacity::Splat),
        (None, Some(_)) if cloud.extinction.is_none() => {
            Err("a density needs opacity = \"medium\"")
        }
        (_, Some(density)) => Ok(GaussianOpacity::Medium { density }),
        (Some(Opacity::Medium), None) => Err("opacity \"medium\" needs a density"),
    }
}
