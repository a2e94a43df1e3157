//! PLY with faces: a mesh, with the normals and colours of its vertices.
use super::{
    SceneError,
    error::{Fault, quoted},
    faces::{Face, Surface, Vertices},
    limits::{self, Limit},
    particles::linear_from_srgb,
    ply_body::{ElementTable, PlyBody},
    ply_header::{self, Element, PropertyKind, Scalar},
    read,
};
use glam::{Vec3, Vec4};
use gobo::model::{Material, Transfer, VertexColor};
use std::path::Path;

/// Columns of vertices.
const NAMES: [&str; 10] = ["x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", "alpha"];

/// Names of the list of a face's vertices.
const LISTS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Albedo of a mesh without colours.
const GREY: f32 = 0.7;

/// Index of the list of vertices among a face's properties.
fn list(element: &Element) -> Option<usize> {
    element.properties.iter().position(|property| {
        LISTS.contains(&property.name.as_str())
            && matches!(property.kind, PropertyKind::List { .. })
    })
}

/// Whether a file that starts with these bytes is a PLY with faces.
pub(super) fn is_mesh(start: &[u8]) -> bool {
    if !start.starts_with(b"ply") {
        return false;
    }
    let Ok(header) = ply_header::parse(start) else { return false };
    let mut faces = header.elements.iter().filter(|element| element.name == "face");
    faces.any(|element| element.count > 0 && list(element).is_some())
}

/// Reads a file. `earlier`: triangles of the scene before it.
pub(super) fn read(path: &Path, earlier: u64) -> Result<Surface, SceneError> {
    let invalid = |(message, help): Fault| SceneError::invalid(path, message, help);
    let bytes = read::bytes(path)?;
    let header = ply_header::parse(&bytes).map_err(invalid)?;
    let mut body = PlyBody::new(&header, &bytes);
    let mut surface = Surface::default();
    let note = |words: String| format!("{}: {words}", path.display());
    for element in &header.elements {
        body.check_count(element).map_err(invalid)?;
        match (element.name.as_str(), list(element)) {
            ("vertex", _) => {
                let unread;
                (surface.vertices, unread) = vertices(path, &mut body, element)?;
                surface.notes.extend(unread.map(note));
            }
            ("face", Some(list)) => {
                Limit::Triangles.grown_in(path, earlier, element.count as u64)?;
                limits::reserve(&mut surface.faces, element.count, "triangles", path)?;
                let faces = &mut surface.faces;
                let has_normals = !surface.vertices.normals.is_empty();
                let take = |corners: &[f64]| fan(corners, has_normals, earlier, faces);
                body.lists(element, list, take).map_err(invalid)?;
                let others = element.properties.iter().enumerate().filter(|(i, _)| *i != list);
                let others: Vec<_> = others.map(|(_, property)| quoted(&property.name)).collect();
                if !others.is_empty() {
                    let names = others[..others.len().min(12)].join(", ");
                    surface.notes.push(note(format!("not read: properties {names} of faces")));
                }
            }
            _ => {
                body.skip(element).map_err(invalid)?;
                if element.count > 0 {
                    let name = quoted(&element.name);
                    surface
                        .notes
                        .push(note(format!("{} rows of {name} are not read", element.count)));
                }
            }
        }
    }
    surface.notes.extend(body.left_over().map(note));
    let tint = if surface.vertices.colors.is_empty() { GREY } else { 1.0 };
    surface.materials.push(Material {
        name: "mesh".to_owned(),
        transfer: Transfer::Opaque,
        tint: Vec3::splat(tint).extend(1.0),
        ..Material::default()
    });
    Ok(surface)
}

/// Triangles of a polygon around its first corner.
fn fan(
    corners: &[f64],
    has_normals: bool,
    earlier: u64,
    faces: &mut Vec<Face>,
) -> Result<(), Fault> {
    let vertex = |i: usize| if corners[i] >= 0.0 { corners[i] as usize } else { usize::MAX };
    let count = corners.len().saturating_sub(2);
    Limit::Triangles.grown(earlier + faces.len() as u64, count as u64)?;
    faces.extend((0..count).map(|i| {
        let positions = [vertex(0), vertex(i + 1), vertex(i + 2)];
        let normals = has_normals.then_some(positions);
        Face { positions, normals, uvs: None, material: 0, id: 0 }
    }));
    Ok(())
}

/// Vertices, and a note about columns that are not read.
fn vertices(
    path: &Path,
    body: &mut PlyBody<'_>,
    element: &Element,
) -> Result<(Vertices, Option<String>), SceneError> {
    let mut known = [None; NAMES.len()];
    let mut unread = Vec::new();
    let columns = element.properties.iter().map(|property| {
        let column = NAMES.iter().position(|name| *name == property.name);
        match (property.kind, column) {
            (PropertyKind::One(scalar), Some(column)) => {
                known[column] = Some(scalar);
                Some(column)
            }
            _ => {
                unread.push(quoted(&property.name));
                None
            }
        }
    });
    let table = ElementTable { columns: columns.collect(), width: NAMES.len() };
    if let Some(i) = (0..3).find(|i| known[*i].is_none()) {
        let message = format!("has no column `{}`", NAMES[i]);
        return Err(SceneError::invalid(path, message, "vertices need x, y and z"));
    }
    let has_normals = known[3..6].iter().all(Option::is_some);
    let has_colors = known[6..9].iter().all(Option::is_some);
    let is_byte = known[6].is_some_and(Scalar::is_whole);
    let has_alpha = known[9].is_some();
    let mut vertices = Vertices::default();
    limits::reserve(&mut vertices.positions, element.count, "vertices", path)?;
    if has_normals {
        limits::reserve(&mut vertices.normals, element.count, "normals", path)?;
    }
    if has_colors {
        limits::reserve(&mut vertices.colors, element.count, "colours", path)?;
    }
    let read = |_: usize, row: &[f64]| {
        let number = |i: usize| row[i] as f32;
        let three = |i: usize| Vec3::new(number(i), number(i + 1), number(i + 2));
        // Bytes are sRGB, floats are linear.
        let share = |i: usize| if is_byte { number(i) / 255.0 } else { number(i) };
        let color = |i: usize| if is_byte { linear_from_srgb(share(i)) } else { share(i) };
        let alpha = if has_alpha { share(9) } else { 1.0 };
        let rgba = Vec4::new(color(6), color(7), color(8), alpha);
        (three(0), three(3), VertexColor::new(rgba))
    };
    let take = |(position, normal, color)| {
        vertices.positions.push(position);
        if has_normals {
            vertices.normals.push(normal);
        }
        if has_colors {
            vertices.colors.push(color);
        }
        Ok(())
    };
    let invalid = |(message, help): Fault| SceneError::invalid(path, message, help);
    body.rows(element, &table, read, take).map_err(invalid)?;
    unread.truncate(12);
    let unread = (!unread.is_empty()).then(|| format!("not read: columns {}", unread.join(", ")));
    Ok((vertices, unread))
}
