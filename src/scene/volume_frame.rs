//! What a volume shows at a time: voxels of a file, or generated ones.
use super::{
    SceneError,
    clouds::Cloud,
    document::VolumeTable,
    error::quoted,
    plain::nearest,
    read,
    vdb::{Bricks, Fault, Tree, Vdb, VdbGrid},
};
use crate::model::{Brick, Scene, Skipped};
use glam::DAffine3;
use std::path::{Path, PathBuf};

/// Channels of a grid of colours.
pub(super) const CHANNELS: usize = 3;

/// What a volume shows at any time.
#[derive(Clone, Debug)]
pub(super) enum Content {
    File {
        path: PathBuf,
        /// First and last number of a sequence of files.
        frames: Option<[u32; 2]>,
        /// Name of the grid of densities.
        grid: Option<String>,
        /// Grid of colours, and the channel that multiplies densities.
        color: Option<(String, usize)>,
        /// Grid of temperatures, and the temperature of a value of 1 [K].
        hot: Option<(String, f32)>,
    },
    Cloud {
        cloud: Cloud,
        /// Highest temperature of what glows [K].
        kelvin: Option<f32>,
    },
}

/// What a volume shows at one time.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    pub(super) bricks: Vec<Brick>,
    /// Density per density of a brick.
    pub(super) scale: f32,
    pub(super) volume_from_index: DAffine3,
    pub(super) skipped: Skipped,
    /// What of the file is not shown, a sentence each.
    pub(super) notes: Vec<String>,
}

impl Content {
    /// `channel`: of a file with a grid of colours.
    pub(super) fn of_file(path: PathBuf, table: &VolumeTable, channel: usize) -> Self {
        let hot = table.emission.as_ref().map(|emission| {
            let grid = emission.grid.clone().unwrap_or_else(|| "temperature".to_owned());
            (grid, emission.kelvin.unwrap_or(1.0))
        });
        let color = table.color_grid.clone().map(|name| (name, channel));
        Self::File { path, frames: table.frames, grid: table.grid.clone(), color, hot }
    }

    /// Whether it changes with time.
    pub(super) fn moves(&self) -> bool {
        match self {
            Self::File { frames, .. } => frames.is_some_and(|[first, last]| first < last),
            Self::Cloud { cloud, .. } => cloud.moves(),
        }
    }

    /// A generated volume that changes as its box without anything in it; `None` for others.
    pub(super) fn outline(&self) -> Option<Frame> {
        match self {
            Self::Cloud { cloud, .. } if cloud.moves() => {
                Some(Frame::of_cloud(cloud, vec![cloud.outline()]))
            }
            _ => None,
        }
    }

    /// Bricks that it makes at most; 0 for a file.
    pub(super) fn most_bricks(&self) -> u64 {
        match self {
            Self::File { .. } => 0,
            Self::Cloud { cloud, .. } => cloud.most_bricks(),
        }
    }

    /// The file at a time [s]; the name of none for a cloud.
    pub(super) fn path(&self, seconds: f64) -> PathBuf {
        match self {
            Self::File { path, frames: None, .. } => path.clone(),
            Self::File { path, frames: Some([first, last]), .. } => {
                let frame = (seconds * Scene::FRAME_RATE).round() as u32;
                numbered(path, first.saturating_add(frame).min(*last)).unwrap_or_default()
            }
            Self::Cloud { .. } => PathBuf::new(),
        }
    }

    /// Nodes with voxels in a file, or 0 if it cannot be read.
    pub(super) fn announced(&self, path: &Path) -> u64 {
        let Self::File { grid, color, .. } = self else { return 0 };
        let channels = if color.is_some() { CHANNELS as u64 } else { 1 };
        let grid = open(path).and_then(|vdb| {
            let i = chosen(&vdb, grid.as_deref())?;
            vdb.read(i, false)
        });
        let nodes = |tree: &Tree| (tree.leaves.len() + tree.tiles.len()) as u64;
        grid.map_or(0, |grid| nodes(&grid.tree) * channels)
    }

    pub(super) fn at(&self, seconds: f64) -> Result<Frame, SceneError> {
        match self {
            Self::File { grid, color, hot, .. } => {
                phase!("read");
                let path = self.path(seconds);
                read::check(&path)?;
                let of_file = |Fault { message, help }| SceneError::invalid(&path, message, help);
                let names = [grid.as_deref(), color.as_ref().map(|(name, _)| &**name)];
                let channel = color.as_ref().map_or(0, |&(_, channel)| channel);
                frame(&path, names, channel, hot.as_ref()).map_err(of_file)
            }
            Self::Cloud { cloud, kelvin } => {
                Ok(Frame::of_cloud(cloud, cloud.bricks(seconds, *kelvin)))
            }
        }
    }
}

impl Frame {
    fn of_cloud(cloud: &Cloud, bricks: Vec<Brick>) -> Self {
        let (skipped, notes) = Default::default();
        Self { bricks, scale: 1.0, volume_from_index: cloud.box_from_index(), skipped, notes }
    }
}

/// The file of a sequence with a number: `%d`, or `%04d` for four digits, in the file's name.
pub(super) fn numbered(path: &Path, number: u32) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let (before, rest) = name.split_once('%')?;
    let (digits, after) = rest.split_once('d')?;
    let width: usize = if digits.is_empty() { 0 } else { digits.parse().ok()? };
    (width <= 9).then(|| path.with_file_name(format!("{before}{number:0width$}{after}")))
}

fn open(path: &Path) -> Result<Vdb, Fault> {
    let failed = |error: SceneError| Fault::new(error.to_string(), "check the file");
    read::bytes(path).map_err(failed).and_then(Vdb::new)
}

/// Place of the grid of densities in the file.
fn chosen(vdb: &Vdb, name: Option<&str>) -> Result<usize, Fault> {
    let wanted = name.unwrap_or("density");
    if let Some(i) = vdb.names().position(|known| known == wanted) {
        return Ok(i);
    }
    let known: Vec<&str> = vdb.names().collect();
    if known.is_empty() {
        let message = format!("no grid of numbers is there; {}", vdb.unread.join("; "));
        return Err(Fault::new(message, "write a grid of floats or halves, as for fog"));
    }
    if name.is_none() {
        return Ok(0);
    }
    Err(unknown("grid", wanted, known))
}

/// Place of a grid of colours in the file.
fn chosen_color(vdb: &Vdb, name: &str) -> Result<usize, Fault> {
    if let Some(i) = vdb.color_names().position(|known| known == name) {
        return Ok(i);
    }
    let known: Vec<&str> = vdb.color_names().collect();
    if known.is_empty() {
        let message = format!("no grid of colours is there, and so no {}", quoted(name));
        return Err(Fault::new(
            message,
            "remove color_grid, or write colours as vectors of floats",
        ));
    }
    Err(unknown("grid of colours", name, known))
}

fn unknown(kind: &str, wanted: &str, mut known: Vec<&str>) -> Fault {
    known.truncate(8);
    let of = known.iter().map(|name| quoted(name)).collect::<Vec<_>>().join(", ");
    let near = nearest(wanted, known).unwrap_or_default();
    let message = format!("there is no {kind} {}, but {of}; {near}", quoted(wanted));
    Fault::new(message.trim_end_matches("; "), "name one of the file's grids")
}

/// `names`: of the grids of densities and of colours.
fn frame(
    path: &Path,
    [name, color]: [Option<&str>; 2],
    channel: usize,
    hot: Option<&(String, f32)>,
) -> Result<Frame, Fault> {
    let vdb = open(path)?;
    let i = chosen(&vdb, name)?;
    let mut grid = vdb.read(i, true)?;
    let chosen = vdb.names().nth(i).unwrap_or_default();
    if grid.class == "level set" {
        let message = format!("the grid {} is a level set, not a density", quoted(chosen));
        return Err(Fault::new(message, "convert it to a fog volume, or name another grid"));
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
        let message = format!("the grids {} and {} differ in place or scale", names[0], names[1]);
        (other.world_from_index != grid.world_from_index)
            .then(|| Fault::new(message, "resample one to the other"))
    };
    for other in vdb.color_names().filter(|&other| Some(other) != color) {
        notes.push(note(&format!(
            "the colours of grid {} are not used: color_grid names one",
            quoted(other)
        )));
    }
    let mut heat = None;
    if let Some((name, kelvin)) = hot {
        let temperatures = vdb.read(self::chosen(&vdb, Some(name))?, true)?;
        is_elsewhere(&temperatures, name).map_or(Ok(()), Err)?;
        heat = Some((temperatures, *kelvin));
    }
    if let Some(name) = color {
        let colors = vdb.read_color(chosen_color(&vdb, name)?, channel)?;
        is_elsewhere(&colors, name).map_or(Ok(()), Err)?;
        grid.tree = grid.tree.times(&colors.tree, colors.background)?;
    }
    let Bricks { mut bricks, scale, mut negative, mut not_finite } = grid.tree.into_bricks()?;
    if let Some((heat, kelvin)) = heat {
        let [below, wrong] = heat.tree.heat(&mut bricks, kelvin);
        (negative, not_finite) = (negative + below, not_finite + wrong);
    }
    let counts = [("voxel below 0", negative), ("voxel not finite", not_finite)];
    let skipped = counts.into_iter().filter(|&(_, count)| count > 0).collect();
    Ok(Frame { bricks, scale, volume_from_index: grid.world_from_index, skipped, notes })
}
