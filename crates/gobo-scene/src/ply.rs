//! Particles of PLY files: the rows after the header.
use super::{
    SceneError,
    error::{Fault, quoted},
    particles::{BLANK, Columns, NAMES, Rows, Storage},
    ply_body::{ElementTable, PlyBody, most_rows},
    ply_header::{self, Element, PlyHeader, PropertyKind, Scalar},
};
use std::path::Path;

/// Reads the rows of the element `vertex`.
pub(super) fn read(path: &Path, bytes: &[u8], rows: &mut Rows<'_>) -> Result<(), SceneError> {
    let header = ply_header::parse(bytes)
        .map_err(|(message, help)| SceneError::invalid(path, message, help))?;
    refuse_splats(path, &header)?;
    let invalid = |(message, help): Fault| SceneError::invalid(path, message, help);
    let mut body = PlyBody::new(&header, bytes);
    let mut has_vertices = false;
    for element in &header.elements {
        body.check_count(element).map_err(invalid)?;
        if element.name == "vertex" {
            has_vertices = true;
            read_vertices(path, &mut body, element, rows)?;
        } else {
            body.skip(element).map_err(invalid)?;
            if element.count > 0 {
                let name = quoted(&element.name);
                rows.note(path, &format!("{} rows of {name} are not read", element.count));
            }
        }
    }
    if !has_vertices {
        let message = "there is no element `vertex` in the PLY header";
        return Err(SceneError::invalid(path, message, "name the particles' element `vertex`"));
    }
    if let Some(note) = body.left_over() {
        rows.note(path, &note);
    }
    Ok(())
}

/// Number of particles that a header announces, given the first bytes of a file and its length; `None` if the
/// file is too short for them.
pub(super) fn announced((head, length): (Vec<u8>, u64)) -> Option<u64> {
    let header = ply_header::parse(&head).ok()?;
    let vertices = header.elements.iter().find(|element| element.name == "vertex")?;
    let most = most_rows(vertices, header.encoding, length.saturating_sub(header.length as u64));
    let count = vertices.count as u64;
    (count <= most).then_some(count)
}

/// Encoding, elements and columns of a header.
pub(super) fn facts(head: &[u8]) -> Vec<(&'static str, String)> {
    let Ok(header) = ply_header::parse(head) else { return Vec::new() };
    let mut facts = vec![("encoding", format!("{:?}", header.encoding))];
    for element in &header.elements {
        let names: Vec<String> =
            element.properties.iter().map(|property| quoted(&property.name)).collect();
        let (shown, more) = names.split_at(names.len().min(24));
        let more =
            if more.is_empty() { String::new() } else { format!(" and {} more", more.len()) };
        let name = quoted(&element.name);
        facts.push(("element", format!("{} of {name}: {}{more}", element.count, shown.join(" "))));
    }
    facts
}

/// Columns of anisotropic Gaussians, as in 3D Gaussian splatting. Read as discs they would be wrong.
const SPLATS: [&str; 6] =
    ["scale_0", "rot_0", "f_dc_0", "packed_position", "packed_rotation", "packed_scale"];

fn refuse_splats(path: &Path, header: &PlyHeader) -> Result<(), SceneError> {
    let mut properties = header.elements.iter().flat_map(|element| &element.properties);
    let Some(found) = properties.find(|property| SPLATS.contains(&property.name.as_str())) else {
        return Ok(());
    };
    let message = format!("holds anisotropic Gaussians (splats): it has a column `{}`", found.name);
    let help = "name the file in a [[splats]] table";
    Err(SceneError::invalid(path, message, help))
}

fn read_vertices(
    path: &Path,
    body: &mut PlyBody<'_>,
    element: &Element,
    rows: &mut Rows<'_>,
) -> Result<(), SceneError> {
    let mut columns = Columns::default();
    let of_properties: Vec<Option<usize>> = element
        .properties
        .iter()
        .map(|property| match property.kind {
            PropertyKind::One(scalar) => columns.find(&property.name, storage_of(scalar)),
            PropertyKind::List { .. } => columns.unread(&property.name),
        })
        .collect();
    rows.begin(path, &columns, element.count)?;
    let table = ElementTable { columns: of_properties, width: NAMES.len() };
    let (kind, earlier) = (rows.kind, rows.count);
    let read = |number: usize, read: &[f64]| {
        let mut row = BLANK;
        for column in table.columns.iter().flatten() {
            row[*column] = read[*column];
        }
        kind.particle(&row, earlier.wrapping_add(number as u32))
    };
    body.rows(element, &table, read, |particle| {
        rows.push(particle);
        Ok(())
    })
    .map_err(|(message, help)| SceneError::invalid(path, message, help))
}

/// Storage of a column: integer colours of any width are bytes.
fn storage_of(scalar: Scalar) -> impl Fn(usize) -> Storage {
    move |column| {
        let is_color = matches!(NAMES[column], "red" | "green" | "blue" | "alpha");
        if scalar.is_whole() && is_color { Storage::Byte } else { Storage::Plain }
    }
}
