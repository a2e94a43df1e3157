//! PLY with a row per splat: 3D Gaussian splatting (Kerbl et al. 2023) and volumetric primitives (Condor et
//! al. 2024).
use super::{
    cloud::{HARMONIC, SplatCloud},
    harmonics::{Harmonics, degree_of},
    kind::SplatKind,
};
use crate::{
    error::{Fault, quoted},
    ply_body::{ElementTable, PlyBody},
    ply_header::{self, Element, Property},
};
use glam::{Quat, Vec3};
use gobo::model::Gaussian;
use std::f32::consts::TAU;

/// Columns of both kinds.
const SHAPE: [&str; 10] =
    ["x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"];
const SPLAT: [&str; 4] = ["opacity", "f_dc_0", "f_dc_1", "f_dc_2"];
const MEDIUM: [&str; 4] = ["sigma_t_0", "albedo_0", "albedo_1", "albedo_2"];

/// Column that distinguishes compressed splats from others.
const PACKED: &str = "packed_position";

/// Table of `columns` in the properties of `element`, all of which are required.
pub(super) fn table(element: &Element, columns: &[&str]) -> Result<ElementTable, Fault> {
    let mut of_properties = vec![None; element.properties.len()];
    for (i, name) in columns.iter().enumerate() {
        let property = element.properties.iter().position(|property| {
            property.name == *name && matches!(property.kind, ply_header::PropertyKind::One(_))
        });
        let Some(property) = property else {
            let message = format!("splats without a column {}", quoted(name));
            return Err((message, "write the columns of 3D Gaussian splatting"));
        };
        of_properties[property] = Some(i);
    }
    Ok(ElementTable { columns: of_properties, width: columns.len() })
}

/// Kind of splats by the columns of a header.
pub(super) fn kind_of(bytes: &[u8]) -> Option<SplatKind> {
    let header = ply_header::parse(bytes).ok()?;
    let vertex = header.elements.iter().find(|element| element.name == "vertex")?;
    let has = |name: &str| vertex.properties.iter().any(|property| property.name == name);
    if has(PACKED) {
        return Some(SplatKind::Packed);
    }
    ["scale_0", "rot_0", "f_dc_0"].into_iter().any(has).then_some(SplatKind::Ply)
}

pub(super) fn read(bytes: &[u8]) -> Result<SplatCloud, Fault> {
    let header = ply_header::parse(bytes)?;
    let mut body = PlyBody::new(&header, bytes);
    let mut cloud = None;
    let mut notes = Vec::new();
    for element in &header.elements {
        body.check_count(element)?;
        if element.name == "vertex" {
            cloud = Some(vertices(&mut body, element)?);
        } else {
            body.skip(element)?;
            if element.count > 0 {
                notes.push(format!(
                    "{} rows of {} are not read",
                    element.count,
                    quoted(&element.name)
                ));
            }
        }
    }
    let none = || ("there is no element `vertex` in the PLY header".to_owned(), "write the splats");
    let mut cloud = cloud.ok_or_else(none)?;
    cloud.notes.extend(notes);
    if let Some(note) = body.left_over() {
        cloud.notes.push(note);
    }
    Ok(cloud.finish())
}

fn vertices(body: &mut PlyBody<'_>, element: &Element) -> Result<SplatCloud, Fault> {
    let is_medium = element.properties.iter().any(|property| property.name == MEDIUM[0]);
    let names = [&SHAPE[..], if is_medium { &MEDIUM } else { &SPLAT }].concat();
    let columns = table(element, &names)?;
    let mut cloud = SplatCloud::with_room(element.count as u64)?;
    let mut densest = 0.0_f32;
    let read = |_: usize, row: &[f64]| {
        let number = |i: usize| row[i] as f32;
        let vector = |i: usize| Vec3::new(number(i), number(i + 1), number(i + 2));
        let (sigma, color) = (vector(3).exp(), vector(11));
        let (opacity, color) = if is_medium {
            // A normalised kernel: its integral over space is `sigma_t`.
            let volume = TAU.powf(1.5) * sigma.x * sigma.y * sigma.z;
            let extinction = number(10) / volume;
            (extinction, color)
        } else {
            (sigmoid(number(10)), Vec3::splat(0.5) + HARMONIC * color)
        };
        let rotation = Quat::from_xyzw(number(7), number(8), number(9), number(6));
        Gaussian { center: vector(0), rotation, sigma, opacity, color, ..Gaussian::default() }
    };
    if is_medium {
        // Opacities are shares of the largest extinction, known at the end.
        let mut all = Vec::new();
        let help = "use a smaller file, or a machine with more memory";
        all.try_reserve_exact(element.count)
            .map_err(|_| (format!("no memory for {} splats", element.count), help))?;
        body.rows(element, &columns, read, |splat| {
            densest = densest.max(if splat.opacity.is_finite() { splat.opacity } else { 0.0 });
            all.push(splat);
            Ok(())
        })?;
        for splat in all {
            cloud.push(Gaussian {
                opacity: splat.opacity / densest.max(f32::MIN_POSITIVE),
                ..splat
            });
        }
        cloud.extinction = Some(densest);
    } else {
        body.rows(element, &columns, read, |splat| {
            cloud.push(splat);
            Ok(())
        })?;
    }
    let is_rest = |name: &str| name.starts_with("f_rest_") || matches!(name, "nx" | "ny" | "nz");
    let unread: Vec<String> = (element.properties.iter().zip(&columns.columns))
        .filter(|(property, column)| column.is_none() && !is_rest(&property.name))
        .map(|(property, _)| quoted(&property.name))
        .take(12)
        .collect();
    if !unread.is_empty() {
        cloud.notes.push(format!("not read: columns {}", unread.join(", ")));
    }
    let rest = element.properties.iter().filter(|property| property.name.starts_with("f_rest_"));
    cloud.leave_out_harmonics(rest.count() / 3);
    Ok(cloud)
}

/// Coefficients of higher harmonics, the columns `f_rest_*`: those of red first, then green, then blue.
pub(super) fn harmonics(bytes: &[u8]) -> Result<Harmonics, Fault> {
    let header = ply_header::parse(bytes)?;
    let mut body = PlyBody::new(&header, bytes);
    for element in &header.elements {
        body.check_count(element)?;
        if element.name == "vertex" {
            return rest(&mut body, element, |number| number as f32);
        }
        body.skip(element)?;
    }
    Ok(Harmonics::default())
}

/// The columns `f_rest_*` of an element; `coefficient`: of a column's number.
pub(super) fn rest(
    body: &mut PlyBody<'_>,
    element: &Element,
    coefficient: impl Fn(f64) -> f32 + Sync,
) -> Result<Harmonics, Fault> {
    let is_rest = |property: &&Property| property.name.starts_with("f_rest_");
    let columns = element.properties.iter().filter(is_rest).count();
    if !columns.is_multiple_of(3) || degree_of(columns / 3).is_none() {
        let message =
            format!("{columns} columns f_rest_*: harmonics of a degree have 9, 24, 45 or 72");
        return Err((message, "write all coefficients of a degree"));
    }
    let names: Vec<String> = (0..columns).map(|i| format!("f_rest_{i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let table = table(element, &names)?;
    let mut harmonics = Harmonics::with_room(columns / 3, element.count as u64)?;
    let read = |_: usize, row: &[f64]| row.iter().map(|&number| coefficient(number)).collect();
    body.rows(element, &table, read, |row: Vec<f32>| {
        harmonics.push_channels(|i| row[i]);
        Ok(())
    })?;
    Ok(harmonics)
}

fn sigmoid(logit: f32) -> f32 {
    1.0 / (1.0 + (-logit).exp())
}
