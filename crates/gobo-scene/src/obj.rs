//! Wavefront OBJ with the materials of its MTL files.
use super::{
    SceneError,
    error::quoted,
    faces::{Face, Surface},
    gltf::Earlier,
    limits::{self, Limit},
    obj_materials::{ObjMaterials, beside},
    particles::linear_from_srgb,
    read,
};
use glam::{Vec2, Vec3};
use gobo::model::{Transfer, VertexColor};
use std::{
    cell::RefCell,
    collections::{HashMap, HashSet},
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
};
use tobj::{LoadError, LoadOptions, Mesh};

const DAMAGED: &str = "the file is cut off or damaged: export it again";

/// Bound of the memory for parsed vertices and faces, in lengths of the file.
const PARSED: u64 = 24;

/// Most bytes of an MTL file.
const MAX_MTL: u64 = 1 << 24;

const OPTIONS: LoadOptions =
    LoadOptions { single_index: false, triangulate: true, ignore_points: true, ignore_lines: true };

/// Files that an OBJ file names, and its contents as the `tobj` crate parses them.
struct Parsed {
    models: Vec<tobj::Model>,
    materials: Vec<tobj::Material>,
    /// MTL files.
    files: Vec<PathBuf>,
    notes: Vec<String>,
}

/// Reads a file. `blend`: transfer of partly transparent materials, if not the usual one.
pub(super) fn read(
    path: &Path,
    earlier: &Earlier,
    blend: Option<Transfer>,
) -> Result<Surface, SceneError> {
    let Parsed { models, materials, notes, .. } = parse(path)?;
    let mut surface = Surface { notes, ..Surface::default() };
    let mut made = ObjMaterials::new(path, earlier, blend, materials);
    let count = models.iter().fold(0, |sum: u64, model| sum + model.mesh.indices.len() as u64 / 3);
    Limit::Triangles.grown_in(path, earlier.triangles as u64, count)?;
    limits::reserve(&mut surface.faces, count as usize, "triangles", path)?;
    for (id, model) in models.into_iter().enumerate() {
        let material = made.add(model.mesh.material_id)?;
        add(&mut surface, &model.mesh, material, id as u32);
    }
    // Meshes without normals get those of their faces, also beside meshes with normals.
    (surface.materials, surface.textures) = made.finish(&mut surface.notes);
    Ok(surface)
}

/// MTL files and images that a file names.
pub(super) fn named(path: &Path) -> Result<Vec<PathBuf>, SceneError> {
    let Parsed { materials, mut files, .. } = parse(path)?;
    files.extend(materials.iter().flat_map(|material| ObjMaterials::images(path, material)));
    files.retain(|file| read::is_file(file));
    Ok(files)
}

fn parse(path: &Path) -> Result<Parsed, SceneError> {
    let bytes = read::bytes(path)?;
    if !limits::has_memory(PARSED * bytes.len() as u64) {
        return Err(SceneError::memory(path, "no memory for its vertices and faces"));
    }
    let name = path.display();
    let (notes, files) = (RefCell::new(Vec::new()), RefCell::new(Vec::new()));
    let known = RefCell::new(HashSet::new());
    let mtl = |named: &Path| {
        // Without this, files that are named again would be read again.
        if !known.borrow_mut().insert(named.to_owned()) {
            return Ok(Default::default());
        }
        let file = beside(path, &named.to_string_lossy());
        let bytes = file.as_deref().and_then(|file| {
            let is_short = read::length(file).is_ok_and(|length| length <= MAX_MTL);
            is_short.then(|| read::bytes(file).ok()).flatten()
        });
        let read = bytes.map_or(Err(LoadError::OpenFileFailed), |bytes| {
            // A line that cannot be parsed is skipped; the other materials stay.
            Ok(materials_of(&bytes))
        });
        if read.is_err() {
            let named = quoted(&named.to_string_lossy());
            notes.borrow_mut().push(format!("{name}: materials of {named} cannot be read"));
        }
        files.borrow_mut().extend(file);
        read
    };
    let parsed =
        catch_unwind(AssertUnwindSafe(|| tobj::load_obj_buf(&mut &bytes[..], &OPTIONS, mtl)));
    let invalid =
        |what: String| SceneError::invalid(path, format!("not a valid OBJ file: {what}"), DAMAGED);
    let (models, materials) = match parsed {
        Err(_) => return Err(invalid("its faces are damaged".to_owned())),
        Ok(Err(error)) => return Err(invalid(error.to_string())),
        Ok(Ok((models, materials))) => (models, materials.unwrap_or_default()),
    };
    let (files, notes) = (files.into_inner(), notes.into_inner());
    Ok(Parsed { models, materials, files, notes })
}

/// Materials of an MTL file, and their names; lines that cannot be parsed are skipped.
fn materials_of(bytes: &[u8]) -> (Vec<tobj::Material>, HashMap<String, usize>) {
    let text = String::from_utf8_lossy(bytes);
    if let Ok(materials) = tobj::load_mtl_buf(&mut text.as_bytes()) {
        return materials;
    }
    let is_sound = |line: &&str| {
        let alone = format!("newmtl m\n{line}\n");
        line.trim_start().starts_with("newmtl") || tobj::load_mtl_buf(&mut alone.as_bytes()).is_ok()
    };
    let sound: Vec<&str> = text.lines().filter(is_sound).collect();
    tobj::load_mtl_buf(&mut sound.join("\n").as_bytes()).unwrap_or_default()
}

/// Adds the faces of a mesh.
fn add(surface: &mut Surface, mesh: &Mesh, material: u32, id: u32) {
    let vertices = &mut surface.vertices;
    let (first, first_normal, first_uv) =
        (vertices.positions.len(), vertices.normals.len(), vertices.uvs.len());
    let positions = mesh.positions.as_chunks::<3>().0;
    vertices.positions.extend(positions.iter().map(|p| Vec3::from_array(*p)));
    vertices.normals.extend(mesh.normals.as_chunks::<3>().0.iter().map(|n| Vec3::from_array(*n)));
    // Row 0 of a texture is at v = 1.
    let uvs = mesh.texcoords.as_chunks::<2>().0.iter();
    vertices.uvs.extend(uvs.map(|[u, v]| Vec2::new(*u, 1.0 - v)));
    let colors = mesh.vertex_color.as_chunks::<3>().0;
    if colors.len() == positions.len() && !colors.is_empty() {
        vertices.colors.resize(first, VertexColor::WHITE);
        // sRGB, as in other files with colours in bytes.
        let color =
            |rgb: &[f32; 3]| Vec3::from_array(rgb.map(|c| linear_from_srgb(c.clamp(0.0, 1.0))));
        vertices.colors.extend(colors.iter().map(|rgb| VertexColor::new(color(rgb).extend(1.0))));
    } else if !vertices.colors.is_empty() {
        vertices.colors.resize(first + positions.len(), VertexColor::WHITE);
    }
    let three = |indices: &[u32], i: usize, first: usize| {
        let corners: &[u32; 3] = indices.get(3 * i..)?.first_chunk()?;
        Some(corners.map(|corner| corner as usize + first))
    };
    let count = mesh.indices.len() / 3;
    let faces = (0..count).filter_map(|i| {
        Some(Face {
            positions: three(&mesh.indices, i, first)?,
            normals: three(&mesh.normal_indices, i, first_normal),
            uvs: three(&mesh.texcoord_indices, i, first_uv),
            material,
            id,
        })
    });
    surface.faces.extend(faces);
}
