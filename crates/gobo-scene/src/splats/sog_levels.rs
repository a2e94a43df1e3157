//! Streamed SOG version 1 (`PlayCanvas`): `lod-meta.json` names folders of SOG. Each stores the splats of a
//! region together, at several levels of detail; level 0 is the finest.
use super::{
    Detail,
    cloud::SplatCloud,
    harmonics::Harmonics,
    sog::{self, DAMAGED, Sog},
    sog_store::{Store, file_name, path_in},
};
use crate::{
    error::{Fault, quoted},
    limits::Limit,
};
use serde::Deserialize;
use std::{
    collections::BTreeMap,
    ops::Range,
    path::{Path, PathBuf},
};

/// Most splats that are read by default.
const BUDGET: u64 = 4_000_000;

/// Most nodes of the tree.
const MAX_NODES: u64 = 1 << 20;

#[derive(Deserialize)]
struct LevelsMeta {
    #[serde(rename = "lodLevels")]
    levels: u32,
    /// `meta.json` of splats around the scene without levels.
    environment: Option<String>,
    filenames: Vec<String>,
    tree: LevelNode,
}

impl LevelsMeta {
    fn name(&self, file: usize) -> Result<&str, Fault> {
        let known = self.filenames.len();
        let missing = || (format!("the tree names file {file} of {known}"), DAMAGED);
        self.filenames.get(file).map(String::as_str).ok_or_else(missing)
    }
}

#[derive(Deserialize)]
struct LevelNode {
    #[serde(default)]
    bound: RegionBox,
    #[serde(default)]
    children: Vec<Self>,
    /// Runs by level.
    #[serde(default)]
    lods: BTreeMap<u32, Run>,
}

/// Box around a region, in the file's units; empty where the file gives none.
#[derive(Default, Deserialize)]
#[serde(default)]
struct RegionBox {
    min: Vec<f64>,
    max: Vec<f64>,
}

impl RegionBox {
    /// Its sides, ascending.
    fn sides(&self) -> Option<[f64; 3]> {
        let (min, max): ([f64; 3], [f64; 3]) =
            (self.min.as_slice().try_into().ok()?, self.max.as_slice().try_into().ok()?);
        let mut sides = [0, 1, 2].map(|axis| max[axis] - min[axis]);
        sides.sort_unstable_by(f64::total_cmp);
        (sides[0] >= 0.0 && sides[2].is_finite()).then_some(sides)
    }
}

/// Splats of a region at a level: consecutive ones of a file.
#[derive(Clone, Copy, Deserialize)]
struct Run {
    file: usize,
    offset: u64,
    count: u64,
}

/// Runs of each level, and what the tree tells of its regions.
struct Levels {
    runs: Vec<Vec<Run>>,
    regions: usize,
    /// Sum of the largest faces of the regions' boxes: about the area of the surfaces in them.
    area: f64,
    /// Second-longest side of the box around all, which every direction sees at least.
    extent: Option<f64>,
}

impl Levels {
    fn count(&self, level: usize) -> u64 {
        self.runs[level].iter().fold(0, |sum, run| sum.saturating_add(run.count))
    }

    /// Mean distance of neighbours on the surfaces; infinite for a level that some regions lack.
    fn spacing(&self, level: usize) -> f64 {
        if self.runs[level].len() < self.regions {
            return f64::INFINITY;
        }
        (self.area / self.count(level) as f64).sqrt()
    }

    /// Coarsest level whose splats are no farther apart than texels; `None` if the file tells no boxes.
    fn resolved(&self, across: u32) -> Option<(usize, bool)> {
        let texel = self.extent? / f64::from(across.max(1));
        let is_fine = |level: &usize| self.spacing(*level) <= texel;
        let level = (self.area > 0.0).then(|| (0..self.runs.len()).rev().find(is_fine))?;
        Some((level.unwrap_or(0), level.is_some()))
    }

    /// The level that is asked for, or else the coarsest that texels do not resolve, and no finer than
    /// [`BUDGET`] allows; and why.
    fn chosen(&self, detail: Detail) -> Result<(usize, String), Fault> {
        let (last, across) = (self.runs.len() - 1, detail.across);
        match detail.lod {
            Some(level) if level as usize > last => {
                let message = format!("lod is {level}, but the file has levels 0 to {last}");
                return Err((message, "give one of its levels"));
            }
            Some(level) => return Ok((level as usize, "as `lod` says".to_owned())),
            None => {}
        }
        let resolved = self.resolved(across);
        let wanted = resolved.map_or(0, |(level, _)| level);
        let level = (wanted..last).find(|&level| self.count(level) <= BUDGET).unwrap_or(last);
        let why = match resolved {
            _ if level > wanted => format!("the finest of at most {BUDGET} splats"),
            Some((_, true)) => {
                format!(
                    "the coarsest whose splats are no farther apart than 1/{across} of its extent"
                )
            }
            Some(_) => {
                format!("the finest: its splats are farther apart than 1/{across} of its extent")
            }
            None => "the finest, as the file tells no extent".to_owned(),
        };
        Ok((level, why))
    }

    /// Ranges of the splats of a level, by the index of their file.
    fn by_file(&self, level: usize) -> BTreeMap<usize, Vec<Range<u64>>> {
        let mut by_file: BTreeMap<usize, Vec<Range<u64>>> = BTreeMap::new();
        for run in &self.runs[level] {
            let range = run.offset..run.offset.saturating_add(run.count);
            by_file.entry(run.file).or_default().push(range);
        }
        by_file.values_mut().for_each(|runs| runs.sort_by_key(|run| run.start));
        by_file
    }

    fn add(&mut self, node: &LevelNode, nodes: &mut u64) -> Result<(), Fault> {
        *nodes += 1;
        if *nodes > MAX_NODES {
            return Err((format!("the tree has more than {MAX_NODES} nodes"), DAMAGED));
        }
        for (&level, &run) in &node.lods {
            let Some(runs) = self.runs.get_mut(level as usize) else {
                let levels = self.runs.len();
                return Err((format!("the tree has level {level} of {levels} levels"), DAMAGED));
            };
            runs.push(run);
        }
        if !node.lods.is_empty() {
            self.regions += 1;
            self.area += node.bound.sides().map_or(0.0, |[_, middle, longest]| middle * longest);
        }
        node.children.iter().try_for_each(|child| self.add(child, nodes))
    }
}

fn meta(bytes: &[u8]) -> Result<(LevelsMeta, Levels), Fault> {
    let json = |error| (format!("not a valid lod-meta.json: {error}"), DAMAGED);
    // The parser refuses deep trees.
    let meta: LevelsMeta = serde_json::from_slice(bytes).map_err(json)?;
    if meta.levels == 0 || meta.levels > 64 {
        return Err((format!("{} levels of detail, not 1 to 64", meta.levels), DAMAGED));
    }
    let extent = meta.tree.bound.sides().map(|[_, middle, _]| middle);
    let runs = vec![Vec::new(); meta.levels as usize];
    let mut levels = Levels { runs, regions: 0, area: 0.0, extent };
    levels.add(&meta.tree, &mut 0)?;
    Ok((meta, levels))
}

/// Reads a level. `path` and `bytes`: of the `lod-meta.json`.
pub(super) fn read(path: &Path, bytes: &[u8], detail: Detail) -> Result<SplatCloud, Fault> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let (meta, levels) = meta(bytes)?;
    let ((level, why), last) = (levels.chosen(detail)?, levels.runs.len() - 1);
    let count = levels.count(level);
    let surroundings = match &meta.environment {
        None => None,
        Some(name) => Some((name, open(folder, name)?)),
    };
    let around = surroundings.as_ref().map_or(0, |(_, sog)| sog.count);
    let help = "give `lod` a coarser level, or write the file with one";
    let fewer = |(message, _): Fault| (format!("level {level} of 0 to {last}: {message}"), help);
    Limit::Splats.grown(count, around).map_err(fewer)?;
    let mut cloud = SplatCloud::with_room(count.saturating_add(around)).map_err(fewer)?;
    let mut harmonics = 0;
    for (file, runs) in levels.by_file(level) {
        let name = meta.name(file)?;
        let sog = open(folder, name)?;
        for run in runs {
            check(&run, sog.count, name)?;
            push(&mut cloud, &sog, run, name)?;
        }
        harmonics = harmonics.max(sog.harmonics);
    }
    if let Some((name, sog)) = &surroundings {
        push(&mut cloud, sog, 0..sog.count, name)?;
        cloud.notes.push(format!("{around} splats of its surroundings are read, too"));
    }
    let finest = levels.count(0);
    cloud.notes.push(format!(
        "level {level} of detail of 0 to {last} is read, with {count} splats of {finest}, {why}: `lod` chooses \
         another"
    ));
    let without = levels.regions - levels.runs[level].len();
    if without > 0 {
        cloud.notes.push(format!("{without} of {} regions have no such level", levels.regions));
    }
    cloud.leave_out_harmonics(harmonics);
    Ok(cloud.finish())
}

/// Coefficients of higher harmonics of the splats that [`read`] reads, in their order.
pub(super) fn harmonics(path: &Path, bytes: &[u8], detail: Detail) -> Result<Harmonics, Fault> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let (meta, levels) = meta(bytes)?;
    let (level, _) = levels.chosen(detail)?;
    Limit::Splats.grown(0, levels.count(level))?;
    let whole = |name: &str| {
        let place = path_in(folder, name)?;
        let mut store = Store::folder(place.parent().unwrap_or(folder));
        sog::harmonics(&mut store, &file_name(&place)).map_err(in_file(name))
    };
    let mut parts = Vec::new();
    for (file, runs) in levels.by_file(level) {
        let name = meta.name(file)?;
        let (all, splats) = whole(name)?;
        for run in runs {
            check(&run, splats, name)?;
            parts.push((all.of_range(&run), run.end - run.start));
        }
    }
    parts.extend(meta.environment.as_deref().map(whole).transpose()?);
    let parts: Vec<_> = parts.iter().map(|(part, splats)| (part, *splats)).collect();
    Harmonics::joined(&parts)
}

/// Refuses splats that a file does not have.
fn check(run: &Range<u64>, have: u64, name: &str) -> Result<(), Fault> {
    if run.end <= have {
        return Ok(());
    }
    let message = format!("{} has {have} splats, and the tree names {}", quoted(name), run.end);
    Err((message, DAMAGED))
}

/// Opens the SOG of a `meta.json` that is named relative to a folder.
fn open(folder: &Path, name: &str) -> Result<Sog, Fault> {
    let place = path_in(folder, name)?;
    let inside = place.parent().unwrap_or(folder);
    Sog::open(&mut Store::folder(inside), &file_name(&place)).map_err(in_file(name))
}

fn push(cloud: &mut SplatCloud, sog: &Sog, run: Range<u64>, name: &str) -> Result<(), Fault> {
    run.map(|i| sog.splat(i as usize)).try_for_each(|splat| {
        cloud.push(splat.map_err(in_file(name))?);
        Ok(())
    })
}

fn in_file(name: &str) -> impl Fn(Fault) -> Fault {
    move |(message, help)| (format!("{}: {message}", quoted(name)), help)
}

/// Files of all levels that a `lod-meta.json` names.
pub(super) fn files(path: &Path, bytes: &[u8]) -> Result<Vec<PathBuf>, Fault> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let (meta, _) = meta(bytes)?;
    let mut files = Vec::new();
    for name in meta.filenames.iter().chain(&meta.environment) {
        let meta = path_in(folder, name)?;
        let inside = meta.parent().unwrap_or(folder);
        for image in sog::images(inside, &file_name(&meta)).map_err(in_file(name))? {
            files.push(path_in(inside, &image)?);
        }
        files.push(meta);
    }
    Ok(files)
}
