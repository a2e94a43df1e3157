//! Volumes of a scene: grids of voxels from files, or generated.
use super::{
    SceneError,
    clouds::{Cloud, KindOfCloud},
    document::{MOST_FACTOR, VolumeTable},
    limits::Limit,
    loader::Loader,
    loader_files::add_skipped,
    look::{Look, delta_eddington},
    particles::FARTHEST,
    read,
    volume_frame::{CHANNELS, Content, FileContent, Frame, numbered},
};
use glam::{Affine3A, DMat4, IVec3, UVec3, Vec3};
use gobo::model::{Bounds, Density, Grid, Material, Motion, Scene, Shape, moved};
use std::{
    collections::HashSet,
    path::{Path, PathBuf},
    sync::Arc,
};
use toml::Spanned;

/// An animated volume of a scene.
#[derive(Clone, Debug)]
struct MovingVolume {
    /// Index into the scene's grids.
    index: usize,
    /// Index into the scene's materials.
    material: u32,
    content: Content,
    world_from_volume: DMat4,
    /// Optical depth of a metre of density 1 [1/m].
    factor: f32,
    /// Its first frame, if made at loading: it is used again when the start is rendered.
    start: Option<Arc<Frame>>,
}

impl Motion for MovingVolume {
    fn apply(&self, scene: &mut Scene, seconds: f64) {
        let start = self.start.as_ref().filter(|_| seconds == 0.0);
        let frame = match start {
            Some(start) => Ok(Frame::clone(start)),
            None => self.content.at(seconds).map_err(|_| ()),
        };
        let grid = &mut scene.grids[self.index];
        grid.bricks.clear();
        let wrong = frame.as_ref().map_or(0, |frame| frame.skipped.values().sum());
        let is_shown = frame.is_ok_and(|frame| {
            put(grid, frame, self.world_from_volume, self.factor);
            grid.problem().is_none() && is_near(grid)
        });
        let bricks: usize = scene.grids.iter().map(|grid| grid.bricks.len()).sum();
        let fits = Limit::Bricks.grown(0, bricks as u64).is_ok();
        if !is_shown || !fits {
            scene.grids[self.index].bricks.clear();
            *scene.skipped.entry(moved::FRAME).or_default() += 1;
        } else if wrong > 0 && start.is_none() {
            *scene.skipped.entry(moved::VOXEL).or_default() += wrong;
        }
    }

    fn most_bricks(&self) -> u64 {
        self.content.most_bricks()
    }

    fn reach(&self, wanted: &dyn Fn(u32) -> bool) -> Bounds {
        let Some(outline) = self.content.outline().filter(|_| wanted(self.material)) else {
            return Bounds::EMPTY;
        };
        let mut grid = Grid::default();
        put(&mut grid, outline, self.world_from_volume, self.factor);
        grid.bounds()
    }

    fn moved(&self, by: Vec3) -> Option<Arc<dyn Motion>> {
        let world_from_volume = DMat4::from_translation(by.as_dvec3()) * self.world_from_volume;
        Some(Arc::new(Self { world_from_volume, ..self.clone() }))
    }
}

/// A grid of a volume: all of it, a channel, or a row of a table of colours.
struct VolumePart {
    content: Content,
    /// Its first frame.
    start: Frame,
    /// Extinction, multiplied by the volume's own.
    extinction: Vec3,
    albedo: Vec3,
    /// Index among the volume's materials.
    material: usize,
}

impl VolumePart {
    fn new(content: Content, start: Frame) -> Self {
        Self { content, start, extinction: Vec3::ONE, albedo: Vec3::ONE, material: 0 }
    }
}

/// Puts a frame into a grid.
fn put(grid: &mut Grid, frame: Frame, world_from_volume: DMat4, factor: f32) {
    let world_from_index = world_from_volume * DMat4::from(frame.volume_from_index);
    grid.world_from_index = Affine3A::from_mat4(world_from_index.as_mat4());
    grid.bricks = frame.bricks;
    grid.factor = factor * frame.scale;
}

/// Whether it is within the largest coordinates of a scene.
fn is_near(grid: &Grid) -> bool {
    let bounds = grid.bounds();
    bounds.is_empty() || bounds.min.abs().max(bounds.max.abs()).max_element() <= FARTHEST
}

/// Mean optical depth along y of the columns that are not empty, for a factor of 1.
fn thickness(grid: &Grid) -> f64 {
    let mut columns = HashSet::new();
    let (mut sum, size) = (0.0, IVec3::splat(8));
    for brick in &grid.bricks {
        let edges = brick.size().as_ivec3();
        let first = brick.origin.div_euclid(size);
        let last = (brick.origin + edges - 1).div_euclid(size);
        columns.extend((first.x..=last.x).flat_map(|x| (first.z..=last.z).map(move |z| (x, z))));
        sum += match &brick.density {
            Density::Voxels(voxels) => {
                // The last voxels are the first of other bricks.
                let voxel = |i: u32| UVec3::new(i % 8, i / 8 % 8, i / 64);
                (0..512).map(|i| f64::from(voxels.at(voxel(i)))).sum::<f64>()
            }
            Density::Constant { density, .. } => {
                f64::from(*density) * edges.as_dvec3().element_product()
            }
        };
    }
    let height = f64::from(grid.world_from_index.matrix3.y_axis.length());
    if columns.is_empty() { 0.0 } else { sum * height / (64 * columns.len()) as f64 }
}

/// Temperature in the middle of an explosion \[K\].
const HOTTEST: f32 = 2200.0;

/// Optical depth along y of a volume or medium that is rendered on its own: neither faint nor black.
pub(super) const USUAL_THICKNESS: f64 = 4.0;

/// A part for each row of the table of colours, or one without a table.
fn rows(
    given: &VolumeTable,
    of_look: impl Fn(Look) -> Result<VolumePart, SceneError>,
) -> Result<Vec<VolumePart>, SceneError> {
    let rows = given.look.rows();
    if rows.is_empty() {
        return Ok(vec![of_look(given.look.clone())?]);
    }
    let of_row = |(material, (look, color)): (usize, (Look, Vec3))| {
        let [extinction, albedo] = delta_eddington(color, given.ahead);
        Ok(VolumePart { extinction, albedo, material, ..of_look(look)? })
    };
    rows.into_iter().enumerate().map(of_row).collect()
}

impl Loader<'_> {
    pub(super) fn volume(&mut self, table: &Spanned<VolumeTable>) -> Result<(), SceneError> {
        let (given, span) = (table.get_ref(), &table.span());
        // A file that is itself the scene has no key that names it.
        let is_alone =
            given.file.as_ref().is_some_and(|file| self.folder.join(file) == self.source.path());
        let named = |error| if is_alone { error } else { self.named_by(span, "file", error) };
        let (key, parts) = self.parts(table, &named)?;
        let first_material = self.scene.materials.len();
        let materials = parts.iter().map(|part| part.material + 1).max().unwrap_or(0);
        self.check_limit(Limit::Materials, first_material, materials, (span, key))?;
        let have: usize = self.scene.grids.iter().map(|grid| grid.bricks.len()).sum();
        let mut bricks = 0;
        let world_from_volume = given.placement.at(0.0).as_dmat4();
        let mut grids = Vec::new();
        for part in &parts {
            bricks += part.start.bricks.len();
            self.check_limit(Limit::Bricks, have, bricks, (span, key))?;
            grids.push(self.grid(table, part, world_from_volume)?);
        }
        let factor = given.factor.unwrap_or_else(|| {
            let thickness = grids.iter().map(thickness).fold(0.0, f64::max);
            if !is_alone || thickness <= 0.0 {
                return 1.0;
            }
            let factor = (USUAL_THICKNESS / thickness) as f32;
            self.scene.notes.push(format!(
                "a density of 1 is taken for an extinction of {factor:.3} per metre: \
                 --set volume.0.density.factor=... sets another"
            ));
            factor.min(MOST_FACTOR)
        });
        for material in 0..materials {
            let part = parts.iter().find(|part| part.material == material);
            let albedo = part.map_or(Vec3::ONE, |part| part.albedo);
            self.scene.materials.push(Material {
                name: format!("volume {}", self.scene.grids.len() + material),
                shape: Shape::Brick,
                tint: (given.albedo * albedo).extend(1.0),
                casts: given.casts,
                visible: given.visible,
                ..Material::default()
            });
        }
        // A file leaves out the same for all parts.
        if let Some(part) = parts.first() {
            self.scene.notes.extend_from_slice(&part.start.notes);
            add_skipped(&mut self.scene.skipped, &part.start.skipped);
        }
        for (VolumePart { content, start, .. }, mut grid) in parts.into_iter().zip(grids) {
            grid.factor *= factor;
            if content.moves() {
                let is_outline = !self.makes_start && content.outline().is_some();
                let start = (!is_outline).then(|| Arc::new(start));
                let index = self.scene.grids.len();
                let material = grid.material;
                let moving =
                    MovingVolume { index, material, content, world_from_volume, factor, start };
                let motions = if is_outline { &mut self.resting } else { &mut self.scene.motions };
                motions.push(Arc::new(moving));
            }
            self.scene.grids.push(grid);
        }
        Ok(())
    }

    /// The parts of a volume, and the key that its placement comes from. `named`: an error of its file.
    fn parts(
        &self,
        table: &Spanned<VolumeTable>,
        named: &impl Fn(SceneError) -> SceneError,
    ) -> Result<(&'static str, Vec<VolumePart>), SceneError> {
        let (given, span) = (table.get_ref(), &table.span());
        match (&given.file, &given.generate) {
            (Some(file), None) => {
                let content = self.of_file(table, file)?;
                let parts = self.of_open_file(table, &content, named)?;
                Ok(("file", parts))
            }
            (None, Some(cloud)) => {
                let (key, what) = match given {
                    VolumeTable { frames: Some(_), .. } => ("frames", "frames or a grid"),
                    VolumeTable { grid: Some(_), .. } => ("density", "frames or a grid"),
                    VolumeTable { color_grid: Some(_), .. } => ("color_grid", "frames or a grid"),
                    VolumeTable { unit: Some(_), .. } => ("unit", "a unit or an axis"),
                    VolumeTable { up: Some(_), .. } => ("up", "a unit or an axis"),
                    _ => return Ok(("generate", self.of_cloud(table, *cloud)?)),
                };
                let help = "remove it: a generated volume has no files";
                Err(self.error(span, key, &format!("{what} of what has no file"), help))
            }
            _ => {
                let message = "a volume needs either a file or generate";
                Err(self.error(span, "file", message, "give one of the two"))
            }
        }
    }

    /// A grid of the volume.
    fn grid(
        &self,
        table: &Spanned<VolumeTable>,
        part: &VolumePart,
        world_from_volume: DMat4,
    ) -> Result<Grid, SceneError> {
        let (given, span) = (table.get_ref(), &table.span());
        let mut grid = Grid {
            extinction: given.color * part.extinction,
            material: (self.scene.materials.len() + part.material) as u32,
            anisotropy: given.anisotropy,
            emission: given.emission.as_ref().map_or(0.0, |emission| emission.factor),
            ..Grid::default()
        };
        put(&mut grid, part.start.clone(), world_from_volume, 1.0);
        if let Some(problem) = grid.problem() {
            let help = "change the scale, or the transform of the file";
            return Err(self.error(span, "scale", &format!("the volume: {problem}"), help));
        }
        if !is_near(&grid) {
            let help = "move it towards the origin or make it smaller";
            let message = "the volume reaches beyond 1e7 m";
            return Err(self.error(span, "translation", message, help));
        }
        Ok(grid)
    }

    /// A generated volume; only an explosion is hot.
    fn of_cloud(
        &self,
        table: &Spanned<VolumeTable>,
        cloud: Cloud,
    ) -> Result<Vec<VolumePart>, SceneError> {
        let given = table.get_ref();
        let kelvin = match &given.emission {
            None => None,
            Some(emission) if cloud.kind != KindOfCloud::Explosion || emission.grid.is_some() => {
                let help = "only explosions glow, and have no grid";
                return Err(self.error(
                    &table.span(),
                    "emission",
                    "emission of what is cold",
                    help,
                ));
            }
            Some(emission) => Some(emission.kelvin.unwrap_or(HOTTEST)),
        };
        let part = |look| {
            let content = Content::Cloud { cloud, kelvin, look };
            let outline = content.outline().filter(|_| !self.makes_start);
            let start = outline.map_or_else(|| content.at(0.0), Ok)?;
            Ok(VolumePart::new(content, start))
        };
        rows(given, part)
    }

    /// The parts of a file at the start: one per channel or row of a table of colours, or a single one.
    fn of_open_file(
        &self,
        table: &Spanned<VolumeTable>,
        content: &FileContent,
        named: &impl Fn(SceneError) -> SceneError,
    ) -> Result<Vec<VolumePart>, SceneError> {
        let given = table.get_ref();
        if given.color_grid.is_some() && !given.look.rows().is_empty() {
            let help = "remove one of the two";
            let message = "a table of colours and a grid of colours";
            return Err(self.error(&table.span(), "colors", message, help));
        }
        let file = content.open().map_err(named)?;
        let path = content.path(0.0);
        let part = |content: FileContent| {
            let start = content.frame(&path, &file).map_err(named)?;
            Ok(VolumePart::new(Content::File(content), start))
        };
        if given.color_grid.is_some() || file.channels() > 1 {
            // Each channel is a grid that absorbs no other channel.
            let of_channel = |channel| {
                let part = part(content.with_channel(channel))?;
                Ok(VolumePart { extinction: Vec3::AXES[channel], ..part })
            };
            return (0..CHANNELS).map(of_channel).collect();
        }
        let of_look = |look| part(content.with_look(look));
        rows(given, of_look)
    }

    /// A file, or all files of a sequence, which must exist.
    fn of_file(
        &self,
        table: &Spanned<VolumeTable>,
        file: &Path,
    ) -> Result<FileContent, SceneError> {
        let (given, span) = (table.get_ref(), &table.span());
        let path = self.folder.join(file);
        let is_sequence = numbered(&path, 0).is_some();
        let content = FileContent::new(path.clone(), given);
        let Some([first, last]) = given.frames else {
            if is_sequence && !read::is_file(&path) {
                let help = "add `frames = [first, last]`";
                return Err(self.error(span, "file", "a sequence of files without frames", help));
            }
            return Ok(content);
        };
        if !is_sequence {
            let help = "write %04d where the number of four digits stands";
            return Err(self.error(span, "frames", "frames of a file without a number", help));
        }
        for frame in first..=last {
            let path: PathBuf = numbered(&path, frame).unwrap_or_default();
            read::check(&path).map_err(|error| self.named_by(span, "file", error))?;
        }
        Ok(content)
    }
}
