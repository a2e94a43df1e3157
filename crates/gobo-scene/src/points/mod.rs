//! Point clouds, scanned by laser or camera, as discs.
//!
//! Files have z up, as surveys and robots do: their (x, y, z) becomes (x, z, -y).
mod classes;
mod copc;
mod e57;
mod las;
mod laz_chunks;
mod lzf;
mod part;
mod pcd;
mod pcd_header;
mod spacing;

use super::{
    SceneError,
    error::{Fault, quoted},
    limits::{self, Limit},
    particles::{FARTHEST, ParticleFile, linear_from_srgb},
    read,
    share::Share,
};
use glam::{DVec3, Vec3};
use gobo::model::{Bounds, Particle, Skipped};
use part::Part;
use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
};

const DAMAGED: &str = "the file is cut off or damaged: write it again";

/// Format of a point file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PointsKind {
    /// LAS and LAZ.
    Las,
    Pcd,
    E57,
}

/// Format of a file by its first bytes.
pub(super) fn kind_of(start: &[u8]) -> Option<PointsKind> {
    if start.starts_with(b"LASF") {
        return Some(PointsKind::Las);
    }
    if start.starts_with(b"ASTM-E57") {
        return Some(PointsKind::E57);
    }
    pcd_header::is_pcd(start).then_some(PointsKind::Pcd)
}

/// Format of a file by its head; `None` if it is unknown, or the file cannot be read.
pub(super) fn kind_of_file(path: &Path) -> Option<PointsKind> {
    let (head, _) = read::head(path, pcd_header::LONGEST).ok()?;
    kind_of(&head)
}

/// Whether a file is a cloud of points.
pub(super) fn is_cloud(path: &Path) -> bool {
    kind_of_file(path).is_some()
}

/// Number of points that a file's head announces.
pub(super) fn announced(path: &Path) -> Option<u64> {
    let (head, length) = read::head(path, pcd_header::LONGEST).ok()?;
    match kind_of(&head)? {
        PointsKind::Las => las::announced(&head, length),
        PointsKind::Pcd => pcd::announced(&head, length),
        PointsKind::E57 => None,
    }
}

/// Facts from the head of a file.
pub(super) fn facts(path: &Path) -> Vec<(&'static str, String)> {
    let Ok((head, _)) = read::head(path, pcd_header::LONGEST) else { return Vec::new() };
    match kind_of(&head) {
        Some(PointsKind::Las) => las::facts(&head),
        Some(PointsKind::Pcd) => pcd::facts(&head),
        _ => Vec::new(),
    }
}

/// Points of a file by attribute. Lists are as long as `positions`, or empty.
#[derive(Debug, Default)]
struct Points {
    /// Positions as in the file \[m\].
    positions: Vec<DVec3>,
    /// Linear colours.
    colors: Vec<Vec3>,
    /// Strength of the echo; any unit.
    intensities: Vec<f32>,
    /// ASPRS classes.
    classes: Vec<u8>,
    /// Each point's row in the file; empty where no row was skipped.
    rows: Vec<u32>,
    skipped: Skipped,
    notes: Vec<String>,
    /// State of a share, if only its points are kept.
    part: Option<Part>,
}

/// A point of a file.
#[derive(Clone, Copy, Debug, Default)]
struct Point {
    position: DVec3,
    color: Option<Vec3>,
    intensity: Option<f32>,
    class: Option<u8>,
}

impl Points {
    /// Makes room for more points.
    fn reserve(&mut self, more: usize) -> Result<(), Fault> {
        let bytes = (size_of::<Point>() + size_of::<Particle>()) as u64 * more as u64;
        if limits::has_memory(bytes) {
            return Ok(());
        }
        let help = "use a smaller file, or a machine with more memory";
        Err((format!("no memory for {more} points ({} MiB)", bytes >> 20), help))
    }

    /// Number of rows so far.
    fn row(&self) -> u64 {
        let others = self.part.as_ref().map_or(0, |part| part.others);
        self.positions.len() as u64 + others + self.skipped.values().sum::<u64>()
    }

    /// Whether rows have other numbers than their points in the lists.
    fn has_gaps(&self) -> bool {
        self.part.is_some() || !self.skipped.is_empty()
    }

    fn skip(&mut self, reason: &'static str) {
        if !self.has_gaps() {
            self.rows = (0..self.row() as u32).collect();
        }
        *self.skipped.entry(reason).or_default() += 1;
    }

    /// Adds the next point of the file.
    fn push(&mut self, point: Point) {
        if !point.position.is_finite() {
            return self.skip("not finite");
        }
        let row = self.row();
        if self.part.as_mut().is_some_and(|part| !part.takes(row, &point)) {
            return;
        }
        if self.has_gaps() {
            self.rows.push(row as u32);
        }
        self.positions.push(point.position);
        self.colors.extend(point.color);
        self.intensities.extend(point.intensity);
        self.classes.extend(point.class);
    }
}

/// Linear light of an sRGB colour.
fn linear(rgb: [f32; 3]) -> Vec3 {
    Vec3::from_array(rgb.map(|c| linear_from_srgb(c.clamp(0.0, 1.0))))
}

/// Target of a file's points.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointsWanted<'a> {
    pub(super) material: u32,
    /// Radius of all points \[m\]; `None`: by their spacing.
    pub(super) radius: Option<f32>,
    pub(super) first_id: u32,
    /// Number of the scene's particles before this file.
    pub(super) earlier: u64,
    /// Most points to read, of a file with levels of detail; `None`: as many as fit in the scene.
    pub(super) budget: Option<u64>,
    /// Share of the points to read, where the format and a known radius allow it; `None` for all.
    pub(super) share: Option<Share>,
    /// Alphas by class; others have 1, and points of alpha 0 are left out.
    pub(super) classes: Option<&'a [(u8, f32)]>,
}

impl PointsWanted<'_> {
    /// Share that is read alone.
    fn share_alone(&self, kind: PointsKind) -> Option<Share> {
        self.share.filter(|_| kind == PointsKind::Las && self.radius.is_some())
    }
}

/// A cloud as particles.
#[derive(Debug)]
pub(super) struct PointFile {
    pub(super) file: ParticleFile,
    /// Rows of the file, also skipped ones.
    pub(super) rows: u64,
    /// Box around the discs of all points, if the file has only those of a share.
    pub(super) around: Option<Bounds>,
}

/// Number of points that may be read.
#[derive(Clone, Copy, Debug)]
struct Room {
    of_scene: u64,
    budget: Option<u64>,
}

impl Room {
    fn most(self) -> u64 {
        self.budget.map_or(self.of_scene, |budget| budget.min(self.of_scene))
    }

    /// Refuses more points, of a file without levels of detail.
    fn check(self, count: u64) -> Result<(), Fault> {
        if count > self.of_scene {
            let help = "thin the cloud out, or write it with levels of detail, as COPC (by PDAL or untwine)";
            return Err((
                format!("{count} points, but a scene has room for {}", self.of_scene),
                help,
            ));
        }
        if self.budget.is_some_and(|budget| count > budget) {
            let help = "remove point_budget, or write the cloud as COPC (by PDAL or untwine)";
            return Err((format!("{count} points without levels of detail"), help));
        }
        Ok(())
    }
}

/// Loads a file as discs. `origin`: offset subtracted from the coordinates of all files, set by the first far
/// from 0.
pub(super) fn load(
    path: &Path,
    kind: PointsKind,
    wanted: PointsWanted<'_>,
    origin: &mut Option<DVec3>,
) -> Result<PointFile, SceneError> {
    let invalid = |(message, help): Fault| SceneError::invalid(path, message, help);
    let share = wanted.share_alone(kind);
    if let Some(count) = announced(path) {
        let own = share.map_or(count, |share| share.count_of(count));
        Limit::Particles.grown(wanted.earlier, own).map_err(|(message, help)| {
            let lacks_radius = wanted.share.is_some() && kind == PointsKind::Las && share.is_none();
            invalid((message, if lacks_radius { part::HELP } else { help }))
        })?;
    }
    let of_scene = Limit::Particles.most().saturating_sub(wanted.earlier);
    let room = Room { of_scene, budget: wanted.budget };
    let (head, length) = read::head(path, pcd_header::LONGEST)?;
    if kind == PointsKind::Las && las::is_plain(&head) {
        let mut source = read::open(path)?;
        let points = las::read_plain(&head, length, &mut *source, room, share).map_err(invalid)?;
        return discs(path, points, wanted, origin);
    }
    let bytes = read::bytes(path)?;
    // The crates for these formats may panic on damaged files.
    let read = catch_unwind(AssertUnwindSafe(|| match kind {
        PointsKind::Las => las::read(&bytes, room, share),
        PointsKind::Pcd => pcd::read(&bytes, room),
        PointsKind::E57 => e57::read(&bytes, room),
    }));
    let read = read.unwrap_or_else(|_| Err(("its data are damaged".to_owned(), DAMAGED)));
    let points = read.map_err(invalid)?;
    drop(bytes);
    discs(path, points, wanted, origin)
}

/// Distance from the origin along an axis past which 32 bits round to more than a millimetre \[m\].
const FAR: f64 = 10_000.0;

/// Farthest corner of a scene \[m\].
const FAR_CORNER: Vec3 = Vec3::splat(FARTHEST);

/// Origins are multiples of this \[m\].
const STEP: f64 = 1000.0;

/// Box of all points, in the file's axes \[m\].
fn extent(points: &Points) -> [DVec3; 2] {
    let of_list = || {
        let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        points.positions.iter().fold(empty, |[min, max], at| [min.min(*at), max.max(*at)])
    };
    points.part.as_ref().map_or_else(of_list, |part| part.extent)
}

/// Origin of far points, in the file's axes: along each axis the middle of the box where that is beyond
/// [`FAR`].
fn far_origin([min, max]: [DVec3; 2]) -> DVec3 {
    let along = |axis: usize| {
        let farthest = min[axis].abs().max(max[axis].abs());
        let middle = 0.5 * min[axis] + 0.5 * max[axis];
        if farthest > FAR { (middle / STEP).round() * STEP } else { 0.0 }
    };
    if min.is_finite() && max.is_finite() {
        DVec3::new(along(0), along(1), along(2))
    } else {
        DVec3::ZERO
    }
}

fn discs(
    path: &Path,
    mut points: Points,
    wanted: PointsWanted<'_>,
    origin: &mut Option<DVec3>,
) -> Result<PointFile, SceneError> {
    let (extent, rows) = (extent(&points), points.row());
    let found = far_origin(extent);
    let base = *origin.get_or_insert(found);
    let name = path.display();
    let mut notes: Vec<String> =
        points.notes.iter().map(|note| format!("{name}: {note}")).collect();
    if base != DVec3::ZERO {
        let [x, y, z] = base.to_array();
        notes
            .push(format!("{name}: x = {x}, y = {y}, z = {z} m of the file is the scene's origin"));
    }
    let colors = classes::colors(&mut points, &mut notes, path);
    let alphas = wanted.classes.map(|classes| classes::alphas(&points, classes)).transpose();
    let alphas =
        alphas.map_err(|(message, help): Fault| SceneError::invalid(path, message, help))?;
    let mut particles = Vec::new();
    limits::reserve(&mut particles, points.positions.len(), "particles", path)?;
    let mut skipped = std::mem::take(&mut points.skipped);
    let placed = |position: DVec3| {
        let DVec3 { x, y, z } = position - base;
        DVec3::new(x, z, -y).as_vec3()
    };
    for (i, position) in points.positions.iter().enumerate() {
        let alpha = alphas.as_ref().map_or(1.0, |of| of[usize::from(points.classes[i])]);
        if alpha == 0.0 {
            *skipped.entry("class of alpha 0").or_default() += 1;
            continue;
        }
        let center = placed(*position);
        if center.abs().max_element() > FARTHEST {
            *skipped.entry("too far").or_default() += 1;
            continue;
        }
        let row = points.rows.get(i).copied().unwrap_or(i as u32);
        particles.push(Particle {
            center,
            color: colors.get(i).copied().unwrap_or(classes::PLAIN).extend(alpha),
            material: wanted.material,
            id: wanted.first_id.wrapping_add(row),
            ..Particle::default()
        });
    }
    let radius = wanted.radius.unwrap_or_else(|| {
        let radius = spacing::radius(&particles).min(FARTHEST);
        notes.push(format!(
            "{name}: discs have a radius of {radius:.3} m, by the spacing of points"
        ));
        radius
    });
    particles.iter_mut().for_each(|particle| particle.radius = radius);
    let around = points.part.is_some().then(|| {
        let corners = extent.map(|corner| placed(corner).clamp(-FAR_CORNER, FAR_CORNER));
        let is_empty = extent[0].x > extent[1].x;
        let corners = corners.into_iter().filter(|_| !is_empty);
        corners.fold(Bounds::EMPTY, |bounds, corner| bounds.with_sphere(corner, radius))
    });
    Ok(PointFile { file: ParticleFile { particles, skipped, notes }, rows, around })
}

/// Names of unread columns, for a note.
fn unread(names: &[&str]) -> Option<String> {
    const NAMED: usize = 12;
    let named: Vec<String> = names.iter().take(NAMED).map(|name| quoted(name)).collect();
    let more = names.len().saturating_sub(NAMED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    (!named.is_empty()).then(|| format!("not read: {}{more}", named.join(", ")))
}
