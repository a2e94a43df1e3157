//! Voxels of a volume at a time, from a file or generated.
use super::{
    SceneError,
    clouds::Cloud,
    dense::{Dense, DenseBricks, fitting_bricks},
    document::VolumeTable,
    error::quoted,
    limits::Limit,
    look::Look,
    plain::nearest,
    read,
    units::Up,
    vdb::{Bricks, Tree, Vdb, VdbGrid, VolumeFault},
    volume_file::VolumeFile,
};
use glam::{DAffine3, DMat3, DVec3};
use gobo::model::{Brick, Scene, Skipped};
use std::path::{Path, PathBuf};

/// Channels of a grid of colours.
pub(super) const CHANNELS: usize = 3;

/// Source of a volume's voxels.
#[derive(Clone, Debug)]
pub(super) enum Content {
    File(FileContent),
    Cloud {
        cloud: Cloud,
        /// Highest temperature of the emission \[K\].
        kelvin: Option<f32>,
        look: Look,
    },
}

/// Part of a file, or of a sequence of files, that a volume shows.
#[derive(Clone, Debug)]
pub(super) struct FileContent {
    path: PathBuf,
    /// First and last number of a sequence of files.
    frames: Option<[u32; 2]>,
    /// Name of the grid of densities.
    grid: Option<String>,
    /// Name of a grid of colours.
    color: Option<String>,
    /// The colour channel that multiplies densities.
    channel: usize,
    /// Grid of temperatures, and the temperature of the value 1 \[K\].
    hot: Option<(String, f32)>,
    look: Look,
    /// Overrides of the file's unit \[m\] and axes.
    unit: Option<f64>,
    up: Option<Up>,
}

/// Voxels of a volume at one time.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    pub(super) bricks: Vec<Brick>,
    /// Density per density of a brick.
    pub(super) scale: f32,
    pub(super) volume_from_index: DAffine3,
    pub(super) skipped: Skipped,
    /// Parts of the file that are not shown, a sentence each.
    pub(super) notes: Vec<String>,
}

impl Content {
    /// Whether it changes with time.
    pub(super) fn moves(&self) -> bool {
        match self {
            Self::File(file) => file.frames.is_some_and(|[first, last]| first < last),
            Self::Cloud { cloud, .. } => cloud.moves(),
        }
    }

    /// An animated volume as its empty box; `None` for others.
    pub(super) fn outline(&self) -> Option<Frame> {
        match self {
            Self::Cloud { cloud, .. } if cloud.moves() => {
                Some(Frame::of_cloud(cloud, vec![cloud.outline()]))
            }
            _ => None,
        }
    }

    /// Upper bound of its bricks; 0 for a file.
    pub(super) fn most_bricks(&self) -> u64 {
        match self {
            Self::File { .. } => 0,
            Self::Cloud { cloud, .. } => cloud.most_bricks(),
        }
    }

    pub(super) fn at(&self, seconds: f64) -> Result<Frame, SceneError> {
        match self {
            Self::File(file) => {
                let path = file.path(seconds);
                file.frame(&path, &VolumeFile::open(&path, file.grid.as_deref())?)
            }
            Self::Cloud { cloud, kelvin, look } => {
                Ok(Frame::of_cloud(cloud, cloud.bricks(seconds, *kelvin, look)))
            }
        }
    }
}

impl FileContent {
    pub(super) fn new(path: PathBuf, table: &VolumeTable) -> Self {
        let hot = table.emission.as_ref().map(|emission| {
            let grid = emission.grid.clone().unwrap_or_else(|| "temperature".to_owned());
            (grid, emission.kelvin.unwrap_or(1.0))
        });
        Self {
            path,
            frames: table.frames,
            grid: table.grid.clone(),
            color: table.color_grid.clone(),
            channel: 0,
            hot,
            look: table.look.clone(),
            unit: table.unit,
            up: table.up,
        }
    }

    /// The same with one channel of its colours.
    pub(super) fn with_channel(&self, channel: usize) -> Self {
        Self { channel, ..self.clone() }
    }

    /// The same with one row of its table of colours.
    pub(super) fn with_look(&self, look: Look) -> Self {
        Self { look, ..self.clone() }
    }

    /// Its file at the start.
    pub(super) fn open(&self) -> Result<VolumeFile, SceneError> {
        VolumeFile::open(&self.path(0.0), self.grid.as_deref())
    }

    /// The file at a time \[s\].
    pub(super) fn path(&self, seconds: f64) -> PathBuf {
        let Some([first, last]) = self.frames else { return self.path.clone() };
        let frame = (seconds * Scene::FRAME_RATE).round() as u32;
        numbered(&self.path, first.saturating_add(frame).min(last)).unwrap_or_default()
    }

    /// Number of nodes with voxels in a file; 0 if it cannot be read, or has none.
    pub(super) fn announced(&self, path: &Path) -> u64 {
        let channels = if self.color.is_some() { CHANNELS as u64 } else { 1 };
        let vdb =
            read::head(path, 8).is_ok_and(|(head, _)| Vdb::is(&head)).then(|| read::bytes(path));
        let Some(Ok(bytes)) = vdb else { return 0 };
        let grid = Vdb::new(bytes).and_then(|vdb| {
            let i = chosen(&vdb, self.grid.as_deref())?;
            vdb.read(i, false)
        });
        let nodes = |tree: &Tree| (tree.leaves.len() + tree.tiles.len()) as u64;
        grid.map_or(0, |grid| nodes(&grid.tree) * channels)
    }

    /// Voxels of its open file.
    pub(super) fn frame(&self, path: &Path, file: &VolumeFile) -> Result<Frame, SceneError> {
        let _phase = tracing::debug_span!("read").entered();
        let frame = match file {
            VolumeFile::Vdb(vdb) => self.of_vdb(path, vdb),
            VolumeFile::Dense(dense) => self.of_dense(path, dense),
        };
        frame.map_err(|VolumeFault { message, help }| SceneError::invalid(path, message, help))
    }

    fn of_dense(&self, path: &Path, dense: &Dense) -> Result<Frame, VolumeFault> {
        if self.color.is_some() || self.hot.is_some() {
            let help = "remove color_grid and emission, or write the grids to a .vdb file";
            return Err(VolumeFault::new("it has no grids of colours or temperatures", help));
        }
        let is_colored = dense.channels() > 1;
        if is_colored && self.look.has_values() {
            let help = "remove colors and window, or write one number for each voxel";
            return Err(VolumeFault::new("its voxels have colours of their own", help));
        }
        let volume_from_index = dense.volume_from_index(self.unit, self.up);
        let density = |voxel: [usize; 3]| {
            let point =
                || volume_from_index.transform_point3(DVec3::from_array(voxel.map(|at| at as f64)));
            if self.look.is_clipped() && !self.look.has(point) {
                0.0
            } else if is_colored {
                dense.color(voxel, self.channel)
            } else {
                self.look.density(dense.value(voxel))
            }
        };
        let dense_bricks = fitting_bricks(dense.size(), density)?;
        let volume_from_index = volume_from_index * dense_bricks.file_from_index();
        let DenseBricks { bricks, wrong, step } = dense_bricks;
        let name = path.display();
        let mut notes: Vec<_> = dense.notes.iter().map(|note| format!("{name}: {note}")).collect();
        if step > 1 {
            let [width, height, depth] = dense.size();
            notes.push(format!(
                "{name}: its {width} x {height} x {depth} voxels need more than {} bricks: means of {step} x \
                 {step} x {step} voxels are shown; `clip` shows a part as it is",
                Limit::Bricks.most()
            ));
        }
        Ok(Frame::of_bricks(bricks, wrong, volume_from_index, notes))
    }

    fn of_vdb(&self, path: &Path, vdb: &Vdb) -> Result<Frame, VolumeFault> {
        let (name, color) = (self.grid.as_deref(), self.color.as_deref());
        let i = chosen(vdb, name)?;
        let mut grid = vdb.read(i, true)?;
        let chosen = vdb.names().nth(i).unwrap_or_default();
        if grid.class == "level set" {
            let message = format!("the grid {} is a level set, not a density", quoted(chosen));
            return Err(VolumeFault::new(
                message,
                "convert it to a fog volume, or name another grid",
            ));
        }
        let note = |text: &str| format!("{}: {text}", path.display());
        let mut notes: Vec<String> = vdb.unread.iter().map(|unread| note(unread)).collect();
        if name.is_none() && chosen != "density" && vdb.names().count() > 1 {
            notes.push(note(&format!("of its grids, {} is taken for the density", quoted(chosen))));
        }
        if grid.background != 0.0 {
            let background = grid.background;
            notes.push(note(&format!("the background of {background} counts as nothing")));
        }
        let is_elsewhere = |other: &VdbGrid, name: &str| {
            let names = [chosen, name].map(quoted);
            let message =
                format!("the grids {} and {} differ in place or scale", names[0], names[1]);
            (other.world_from_index != grid.world_from_index)
                .then(|| VolumeFault::new(message, "resample one to the other"))
        };
        for other in vdb.color_names().filter(|&other| Some(other) != color) {
            notes.push(note(&format!(
                "the colours of grid {} are not used: color_grid names one",
                quoted(other)
            )));
        }
        let mut heat = None;
        if let Some((name, kelvin)) = &self.hot {
            let temperatures = vdb.read(self::chosen(vdb, Some(name))?, true)?;
            is_elsewhere(&temperatures, name).map_or(Ok(()), Err)?;
            heat = Some((temperatures, *kelvin));
        }
        if let Some(name) = color {
            let colors = vdb.read_color(chosen_color(vdb, name)?, self.channel)?;
            is_elsewhere(&colors, name).map_or(Ok(()), Err)?;
            grid.tree = grid.tree.times(&colors.tree, colors.background)?;
        }
        let axes = self.up.map_or(DMat3::IDENTITY, Up::turn) * self.unit.unwrap_or(1.0);
        let volume_from_index = DAffine3::from_mat3(axes) * grid.world_from_index;
        let mut bricks = self.look.shown(grid.tree, volume_from_index)?.into_bricks()?;
        let mut wrong = [0, 0];
        if let Some((heat, kelvin)) = heat {
            wrong = heat.tree.heat(&mut bricks.bricks, kelvin);
        }
        Ok(Frame::of_bricks(bricks, wrong, volume_from_index, notes))
    }
}

impl Frame {
    fn of_cloud(cloud: &Cloud, bricks: Vec<Brick>) -> Self {
        let (skipped, notes) = Default::default();
        Self { bricks, scale: 1.0, volume_from_index: cloud.box_from_index(), skipped, notes }
    }

    /// `wrong`: numbers of values below 0 and of values that are not finite, besides those of the bricks.
    fn of_bricks(
        bricks: Bricks,
        wrong: [u64; 2],
        volume_from_index: DAffine3,
        notes: Vec<String>,
    ) -> Self {
        let Bricks { bricks, scale, negative, not_finite } = bricks;
        let counts =
            [("voxel below 0", negative + wrong[0]), ("voxel not finite", not_finite + wrong[1])];
        let skipped = counts.into_iter().filter(|&(_, count)| count > 0).collect();
        Self { bricks, scale, volume_from_index, skipped, notes }
    }
}

/// Path of file `number` of a sequence: `%d`, or `%04d` for four digits, in the file's name.
pub(super) fn numbered(path: &Path, number: u32) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let (before, rest) = name.split_once('%')?;
    let (digits, after) = rest.split_once('d')?;
    let width: usize = if digits.is_empty() { 0 } else { digits.parse().ok()? };
    (width <= 9).then(|| path.with_file_name(format!("{before}{number:0width$}{after}")))
}

/// Index of the grid of densities in the file.
fn chosen(vdb: &Vdb, name: Option<&str>) -> Result<usize, VolumeFault> {
    let wanted = name.unwrap_or("density");
    if let Some(i) = vdb.names().position(|known| known == wanted) {
        return Ok(i);
    }
    let known: Vec<&str> = vdb.names().collect();
    if known.is_empty() {
        let message = format!("no grid of numbers is there; {}", vdb.unread.join("; "));
        return Err(VolumeFault::new(message, "write a grid of floats or halves, as for fog"));
    }
    if name.is_none() {
        return Ok(0);
    }
    Err(unknown("grid", wanted, known))
}

/// Index of a grid of colours in the file.
fn chosen_color(vdb: &Vdb, name: &str) -> Result<usize, VolumeFault> {
    if let Some(i) = vdb.color_names().position(|known| known == name) {
        return Ok(i);
    }
    let known: Vec<&str> = vdb.color_names().collect();
    if known.is_empty() {
        let message = format!("no grid of colours is there, and so no {}", quoted(name));
        return Err(VolumeFault::new(
            message,
            "remove color_grid, or write colours as vectors of floats",
        ));
    }
    Err(unknown("grid of colours", name, known))
}

fn unknown(kind: &str, wanted: &str, mut known: Vec<&str>) -> VolumeFault {
    known.truncate(8);
    let of = known.iter().map(|name| quoted(name)).collect::<Vec<_>>().join(", ");
    let near = nearest(wanted, known).unwrap_or_default();
    let message = format!("there is no {kind} {}, but {of}; {near}", quoted(wanted));
    VolumeFault::new(message.trim_end_matches("; "), "name one of the file's grids")
}
