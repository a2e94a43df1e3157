//! Particle files: a row per particle, in named columns.
use super::{
    SceneError,
    error::quoted,
    format_table::{Family, endings},
    limits::{self, Limit},
    ply, points, read,
};
use glam::{DVec3, Vec3, Vec4};
pub(super) use gobo::model::FARTHEST;
use gobo::model::{Material, Particle, Skipped, Strand, StrandVertex};
use std::path::Path;

/// Contents of one file.
#[derive(Clone, Debug)]
pub struct ParticleFile {
    /// Particles in the order of the file.
    pub particles: Vec<Particle>,
    /// Particles left out, by reason.
    pub skipped: Skipped,
    /// Columns of the file that are ignored, a sentence each.
    pub notes: Vec<String>,
}

/// Contents of a file of strands.
#[derive(Debug)]
pub(super) struct StrandFile {
    /// One strand for the rows of each id, in the order of rows; one for all rows of a file without ids.
    pub(super) strands: Vec<Strand>,
    /// Rows left out, by reason.
    pub(super) skipped: Skipped,
    pub(super) notes: Vec<String>,
}

/// Columns of a row, in the order of [`NAMES`].
pub(super) type ParticleRow = [f64; NAMES.len()];

/// Names of the columns; the first three are required.
pub(super) const NAMES: [&str; 10] =
    ["x", "y", "z", "radius", "red", "green", "blue", "alpha", "rotation", "id"];

const RADIUS: usize = 3;
const RED: usize = 4;
const ALPHA: usize = 7;
const ROTATION: usize = 8;
const ID: usize = 9;

/// Values of a row for missing columns.
pub(super) const BLANK: ParticleRow = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0];

/// Storage of a column in the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Storage {
    #[default]
    Absent,
    /// A number as stored; colours are linear.
    Plain,
    /// 0..=255; colours are sRGB.
    Byte,
}

/// Longest head of a file that is read ahead \[bytes\].
const LONGEST_HEAD: u64 = 1 << 16;

/// Radius of particles that all coincide \[m\].
const LONE_RADIUS: f32 = 0.05;

/// Columns of a file.
#[derive(Debug, Default)]
pub(super) struct Columns {
    storage: [Storage; NAMES.len()],
    /// Names of columns that are ignored.
    unread: Vec<String>,
}

impl Columns {
    /// Index in a row of the column with this name; `storage` for that index.
    pub(super) fn find(
        &mut self,
        name: &str,
        storage: impl FnOnce(usize) -> Storage,
    ) -> Option<usize> {
        let Some(column) = NAMES.iter().position(|known| *known == name) else {
            return self.unread(name);
        };
        self.storage[column] = storage(column);
        Some(column)
    }

    pub(super) fn unread(&mut self, name: &str) -> Option<usize> {
        self.unread.push(quoted(name));
        None
    }

    /// Note about ignored columns; at most a dozen by name.
    fn note(&self) -> Option<String> {
        const NAMED: usize = 12;
        let (named, more) = self.unread.split_at(self.unread.len().min(NAMED));
        let more =
            if more.is_empty() { String::new() } else { format!(" and {} more", more.len()) };
        let columns = if self.unread.len() == 1 { "column" } else { "columns" };
        (!named.is_empty()).then(|| format!("not read: {columns} {}{more}", named.join(", ")))
    }
}

/// Target of the rows.
#[derive(Clone, Copy)]
pub(super) struct RowKind<'a> {
    material: &'a Material,
    material_id: u32,
    first_id: u32,
    /// Whether radii of 0 are valid, and all rows without an id belong to the first.
    of_strands: bool,
    storage: [Storage; NAMES.len()],
}

/// Conversion of rows to particles.
pub(super) struct Rows<'a> {
    pub(super) kind: RowKind<'a>,
    /// Number of the scene's particles before this file.
    earlier: u64,
    /// Number of rows so far.
    pub(super) count: u32,
    particles: Vec<Particle>,
    skipped: Skipped,
    notes: Vec<String>,
}

/// Loads a file. `material_id` is stored in the particles; ids default to row number + `first_id`.
/// `default_radius` \[m\] is for files without a radius column; if it is `None` too, the radius is half the
/// mean spacing, estimated from bounds and count. `earlier`: particles that the scene already has.
pub(super) fn load(
    path: &Path,
    material: &Material,
    material_id: u32,
    default_radius: Option<f32>,
    first_id: u32,
    earlier: u64,
) -> Result<ParticleFile, SceneError> {
    let kind = RowKind { first_id, ..RowKind::new(material, material_id) };
    Rows { earlier, ..Rows::new(kind) }.load(path, default_radius)
}

/// Loads a file of strands, with the columns of particles. `default_radius` \[m\] is for files without a
/// radius column.
pub(super) fn load_strands(
    path: &Path,
    material: &Material,
    material_id: u32,
    default_radius: Option<f32>,
) -> Result<StrandFile, SceneError> {
    let kind = RowKind { of_strands: true, ..RowKind::new(material, material_id) };
    let ParticleFile { particles, skipped, notes } = Rows::new(kind).load(path, default_radius)?;
    let of_rows = particles.chunk_by(|a, b| a.id == b.id).map(|rows| Strand {
        vertices: rows
            .iter()
            .map(|row| StrandVertex { position: row.center, radius: row.radius, color: row.color })
            .collect(),
        material: material_id,
        id: rows[0].id,
    });
    Ok(StrandFile { strands: of_rows.collect(), skipped, notes })
}

/// Number of particles that a PLY file's header announces, if the file is long enough for them; `None` for a
/// CSV file.
pub(super) fn announced(path: &Path) -> Option<u64> {
    if let Some(count) = points::announced(path) {
        return Some(count);
    }
    let is_ply = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ply"));
    is_ply.then(|| read::head(path, LONGEST_HEAD).ok()).flatten().and_then(ply::announced)
}

/// Elements of a PLY file and their columns.
pub(super) fn facts(path: &Path) -> Vec<(&'static str, String)> {
    read::head(path, LONGEST_HEAD).map_or_else(|_| Vec::new(), |(head, _)| ply::facts(&head))
}

fn check_count(path: &Path, earlier: u64, count: u64) -> Result<(), SceneError> {
    Limit::Particles.grown_in(path, earlier, count).map(|_| ())
}

impl<'a> Rows<'a> {
    fn new(kind: RowKind<'a>) -> Self {
        let (particles, skipped, notes) = Default::default();
        Self { kind, earlier: 0, count: 0, particles, skipped, notes }
    }

    fn load(
        mut self,
        path: &Path,
        default_radius: Option<f32>,
    ) -> Result<ParticleFile, SceneError> {
        if let Some(count) = announced(path) {
            check_count(path, self.earlier, count)?;
        }
        let bytes = read::bytes(path)?;
        let rows = &mut self;
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("ply") => ply::read(path, &bytes, rows)?,
            Some("csv") => read_csv(path, &bytes, rows)?,
            _ => {
                let of_rows = |family| matches!(family, Family::Particles | Family::Points);
                let endings = endings(of_rows, "and");
                let message = format!("particles come from {endings} files only");
                return Err(SceneError::invalid(path, message, "convert the file, or rename it"));
            }
        }
        let Rows { kind, mut particles, skipped, notes, .. } = self;
        if kind.storage[RADIUS] == Storage::Absent {
            let radius = default_radius.unwrap_or_else(|| half_spacing(&particles));
            for particle in &mut particles {
                particle.radius = radius;
            }
        }
        Ok(ParticleFile { particles, skipped, notes })
    }

    /// Sets the columns; call it before the rows.
    pub(super) fn begin(
        &mut self,
        path: &Path,
        columns: &Columns,
        capacity: usize,
    ) -> Result<(), SceneError> {
        if let Some(i) = (0..3).find(|&i| columns.storage[i] == Storage::Absent) {
            let message = format!("has no column `{}`", NAMES[i]);
            return Err(SceneError::invalid(path, message, "particles need x, y and z"));
        }
        check_count(path, self.earlier, capacity as u64)?;
        if let Some(note) = columns.note() {
            self.note(path, &note);
        }
        self.kind.storage = columns.storage;
        limits::reserve(&mut self.particles, capacity, "particles", path)
    }

    pub(super) fn note(&mut self, path: &Path, what: &str) {
        self.notes.push(format!("{}: {what}", path.display()));
    }

    /// Adds the result of the next row.
    pub(super) fn push(&mut self, particle: Result<Particle, &'static str>) {
        match particle {
            Ok(particle) => self.particles.push(particle),
            Err(reason) => *self.skipped.entry(reason).or_default() += 1,
        }
        self.count = self.count.wrapping_add(1);
    }
}

impl<'a> RowKind<'a> {
    fn new(material: &'a Material, material_id: u32) -> Self {
        let storage = [Storage::Absent; NAMES.len()];
        Self { material, material_id, first_id: 0, of_strands: false, storage }
    }

    /// The particle of a row, or the reason to leave it out. `number`: of the row.
    pub(super) fn particle(
        &self,
        row: &ParticleRow,
        number: u32,
    ) -> Result<Particle, &'static str> {
        let value = |i: usize| row[i] as f32;
        let color = |i: usize| match self.storage[i] {
            Storage::Byte if i == ALPHA => value(i) / 255.0,
            Storage::Byte => linear_from_srgb(value(i) / 255.0),
            _ => value(i),
        };
        if !(0..NAMES.len()).all(|i| value(i).is_finite()) {
            return Err("not finite");
        }
        let center = Vec3::from_array(std::array::from_fn(value));
        let radius = value(RADIUS);
        let rgba = Vec4::from_array(std::array::from_fn(|i| color(RED + i)));
        let id = match self.storage[ID] {
            Storage::Absent if self.of_strands => self.first_id,
            Storage::Absent => self.first_id.wrapping_add(number),
            _ => row[ID] as i64 as u32,
        };
        let (rotation, material) = (value(ROTATION), self.material_id);
        let particle = Particle { center, radius, color: rgba, rotation, material, id };
        // A strand may end in a point.
        let is_point = self.of_strands && radius == 0.0;
        let checked = Particle { radius: if is_point { 1.0 } else { radius }, ..particle };
        checked.problem(self.material.transfer.max_color()).map_or(Ok(particle), Err)
    }
}

pub(super) fn linear_from_srgb(c: f32) -> f32 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// Half the side of the cube (square, line) per particle \[m\]. Axes along which the particles hardly differ
/// are ignored.
fn half_spacing(particles: &[Particle]) -> f32 {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for particle in particles {
        min = min.min(particle.center.as_dvec3());
        max = max.max(particle.center.as_dvec3());
    }
    let extent = max - min;
    let flat = extent.max_element() * 1e-4;
    let sides: Vec<f64> = extent.to_array().into_iter().filter(|&side| side > flat).collect();
    if sides.is_empty() {
        return LONE_RADIUS;
    }
    let share = sides.iter().product::<f64>() / particles.len() as f64;
    (0.5 * share.powf(1.0 / sides.len() as f64)) as f32
}

fn read_csv(path: &Path, bytes: &[u8], rows: &mut Rows<'_>) -> Result<(), SceneError> {
    // One quoted field may hold the rest of the file, in a buffer that doubles as it grows.
    if !limits::has_memory(3 * bytes.len() as u64) {
        return Err(SceneError::memory(path, "no memory for the rows of the file"));
    }
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes);
    let csv_error = |error: csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        let problem = match error.kind() {
            csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                format!("{len} fields, but the header has {expected_len}")
            }
            csv::ErrorKind::Utf8 { .. } => "the text is not UTF-8".to_owned(),
            _ => error.to_string(),
        };
        let help = "give every row as many fields as the header, in UTF-8";
        SceneError::invalid(path, format!("line {line}: {problem}"), help)
    };
    let header = reader.headers().map_err(csv_error)?.clone();
    let mut columns = Columns::default();
    let mut fields = Vec::new();
    for (field, name) in header.iter().enumerate() {
        let Some(column) = columns.find(name, |_| Storage::Plain) else { continue };
        if fields.iter().any(|&(_, other)| other == column) {
            let message = format!("line 1: two columns are named `{name}`");
            return Err(SceneError::invalid(path, message, "rename or remove one of them"));
        }
        fields.push((field, column));
    }
    rows.begin(path, &columns, 0)?;
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(csv_error)? {
        let mut row = BLANK;
        for &(field, column) in &fields {
            let text = record.get(field).unwrap_or_default();
            row[column] = text.parse().map_err(|_| {
                let line = record.position().map_or(0, csv::Position::line);
                let (name, text) = (NAMES[column], quoted(text));
                let message = format!("line {line}, column `{name}`: {text} is not a number");
                SceneError::invalid(path, message, "write a number, or remove the row")
            })?;
        }
        check_count(path, rows.earlier, u64::from(rows.count) + 1)?;
        limits::reserve(&mut rows.particles, 1, "particles", path)?;
        rows.push(rows.kind.particle(&row, rows.count));
    }
    Ok(())
}
