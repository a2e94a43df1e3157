//! Particle files: PLY and CSV.
use super::SceneError;
use crate::{
    caster::{Material, Particle},
    counters::Skipped,
};
use glam::{Vec3, Vec4};
use ply_rs_bw::{
    parser::{Parser, Reader},
    ply::{Property, PropertyAccess, PropertyAccessResult},
};
use std::{fs::File, io::BufReader, path::Path};

/// What a file holds, and what of it was left out.
#[derive(Debug)]
pub(super) struct ParticleFile {
    pub particles: Vec<Particle>,
    pub skipped: Skipped,
}

/// A coordinate beyond it is no place in a scene [m].
const FARTHEST: f32 = 1e7;

/// One particle as the file gives it.
#[derive(Clone, Copy, Debug)]
struct Row {
    center: Vec3,
    radius: Option<f32>,
    color: Vec4,
    rotation: f32,
    id: Option<u32>,
}

/// Columns that mean something here; others are left alone.
const COLUMNS: [&str; 10] =
    ["x", "y", "z", "radius", "red", "green", "blue", "alpha", "rotation", "id"];

impl Row {
    const EMPTY: Self =
        Self { center: Vec3::ZERO, radius: None, color: Vec4::ONE, rotation: 0.0, id: None };

    /// Whether the name is one of [`COLUMNS`].
    fn set(&mut self, name: &str, value: f64) -> bool {
        let number = value as f32;
        match name {
            "x" => self.center.x = number,
            "y" => self.center.y = number,
            "z" => self.center.z = number,
            "radius" => self.radius = Some(number),
            "red" => self.color.x = number,
            "green" => self.color.y = number,
            "blue" => self.color.z = number,
            "alpha" => self.color.w = number,
            "rotation" => self.rotation = number,
            // Beyond 32 bits an id keeps its low bits: it only has to tell particles apart.
            "id" => self.id = Some(value as i64 as u32),
            _ => return false,
        }
        true
    }

    /// Why the particle must be left out.
    fn fault(&self, max_color: f32) -> Option<&'static str> {
        let numbers = [self.radius.unwrap_or(1.0), self.rotation];
        if !(self.center.is_finite()
            && self.color.is_finite()
            && numbers.iter().all(|n| n.is_finite()))
        {
            return Some("not finite");
        }
        let color = self.color.truncate();
        if self.center.abs().max_element() > FARTHEST {
            Some("too far")
        } else if self.radius.is_some_and(|radius| radius <= 0.0 || radius > FARTHEST) {
            Some("radius out of range")
        } else if color.min_element() < 0.0 || color.max_element() > max_color {
            Some("colour out of range")
        } else if !(0.0..=1.0).contains(&self.color.w) {
            Some("alpha out of range")
        } else {
            None
        }
    }
}

impl PropertyAccess for Row {
    fn new() -> Self {
        Self::EMPTY
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let value = match property {
            Property::Char(v) => f64::from(v),
            Property::UChar(v) => match name {
                "red" | "green" | "blue" => f64::from(linear(v)),
                "alpha" => f64::from(v) / 255.0,
                _ => f64::from(v),
            },
            Property::Short(v) => f64::from(v),
            Property::UShort(v) => f64::from(v),
            Property::Int(v) => f64::from(v),
            Property::UInt(v) => f64::from(v),
            Property::Float(v) => f64::from(v),
            Property::Double(v) => v,
            _ => return PropertyAccessResult::Ignored,
        };
        if self.set(name, value) {
            PropertyAccessResult::Set
        } else {
            PropertyAccessResult::Ignored
        }
    }
}

/// An sRGB byte as linear light (IEC 61966-2-1).
fn linear(byte: u8) -> f32 {
    let v = f32::from(byte) / 255.0;
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// Reads a file's particles. Ids that the file lacks are row numbers from `first_id`; radii are
/// `default_radius` [m], or half the mean spacing.
pub(super) fn load(
    path: &Path,
    material: &Material,
    material_id: u32,
    default_radius: Option<f32>,
    first_id: u32,
) -> Result<ParticleFile, SceneError> {
    let is_ply = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ply"));
    let is_csv = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
    let rows = match (is_ply, is_csv) {
        (true, _) => read_ply(path)?,
        (_, true) => read_csv(path)?,
        _ => {
            let message = "particles come from .ply or .csv files";
            return Err(SceneError::invalid(path, message, "convert the file to one of them"));
        }
    };
    let mut skipped = Skipped::new();
    let max_color = material.transfer.max_color();
    let kept: Vec<_> = (0u32..)
        .zip(rows)
        .filter(|(_, row)| match row.fault(max_color) {
            Some(fault) => {
                *skipped.entry(fault).or_default() += 1;
                false
            }
            None => true,
        })
        .collect();
    let radius = default_radius.unwrap_or_else(|| half_spacing(&kept));
    let particles = kept
        .into_iter()
        .map(|(number, row)| Particle {
            center: row.center,
            radius: row.radius.unwrap_or(radius),
            color: row.color,
            rotation: row.rotation,
            material: material_id,
            id: row.id.unwrap_or_else(|| first_id.wrapping_add(number)),
        })
        .collect();
    Ok(ParticleFile { particles, skipped })
}

/// Half the edge of the cube that a particle has for itself in the bounds [m].
fn half_spacing(rows: &[(u32, Row)]) -> f32 {
    let min = rows.iter().fold(Vec3::INFINITY, |a, (_, row)| a.min(row.center));
    let max = rows.iter().fold(Vec3::NEG_INFINITY, |a, (_, row)| a.max(row.center));
    let extent = (max - min).max(Vec3::ZERO);
    let thick = extent.max(Vec3::splat(extent.max_element() * 1e-2));
    let spacing = (thick.element_product() / rows.len().max(1) as f32).cbrt();
    if spacing.is_finite() && spacing > 0.0 { spacing * 0.5 } else { 0.05 }
}

fn read_ply(path: &Path) -> Result<Vec<Row>, SceneError> {
    let file = File::open(path)
        .map_err(|source| SceneError::Read { path: path.to_owned(), source })?;
    let broken = |error: &dyn std::fmt::Display| {
        let help = "export it again as ascii or binary PLY 1.0 with a vertex element";
        SceneError::invalid(path, format!("no readable PLY: {error}"), help)
    };
    let mut reader = Reader::new(BufReader::new(file));
    let parser = Parser::<Row>::new();
    let header = parser.read_header(&mut reader).map_err(|error| broken(&error))?;
    let mut rows = None;
    for (name, element) in &header.elements {
        let elements = parser
            .read_payload_for_element(&mut reader, element, &header)
            .map_err(|error| broken(&error))?;
        if name == "vertex" || name == "particle" {
            if let Some(missing) =
                COLUMNS[..3].iter().find(|axis| !element.properties.contains_key(**axis))
            {
                return Err(broken(&format!("its {name} element has no property {missing}")));
            }
            rows = Some(elements);
            break;
        }
    }
    rows.ok_or_else(|| broken(&"it has no element named vertex"))
}

fn read_csv(path: &Path) -> Result<Vec<Row>, SceneError> {
    let broken = |message: String| {
        let help = "a CSV needs a header line with x,y,z and one number in each field";
        SceneError::invalid(path, message, help)
    };
    let file = File::open(path)
        .map_err(|source| SceneError::Read { path: path.to_owned(), source })?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(file);
    let header = reader.headers().map_err(|error| broken(error.to_string()))?.clone();
    if let Some(missing) = COLUMNS[..3].iter().find(|axis| !header.iter().any(|h| h == **axis)) {
        return Err(broken(format!("no column named {missing}")));
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| broken(error.to_string()))?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut row = Row::EMPTY;
        for (name, field) in header.iter().zip(&record) {
            if COLUMNS.contains(&name) {
                let value = field.parse().map_err(|_| {
                    broken(format!("line {line}: {name} is {field:?}, which is no number"))
                })?;
                row.set(name, value);
            }
        }
        rows.push(row);
    }
    Ok(rows)
}
