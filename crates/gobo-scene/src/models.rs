//! Models of all formats: glTF, PLY with faces, OBJ.
use super::{
    SceneError,
    faces::Surface,
    gltf::{self, Earlier, Model, Wanted, file::GltfFile, mesh::cofactors},
    limits::Limit,
    obj,
    particles::FARTHEST,
    ply_mesh, read,
    rig::Rig,
};
use glam::{Mat3, Mat4, Vec3};
use gobo::model::Triangle;
use std::path::Path;

/// Bytes at a file's beginning that tell its kind: longer than the header of any PLY.
const LONGEST_HEAD: u64 = 1 << 16;

/// Kind of a model file other than glTF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ModelKind {
    Ply,
    Obj,
}

/// Kind of a file by its head and name; `None` for glTF, for other files, and if the file cannot be read.
pub(super) fn kind_of_file(path: &Path) -> Option<ModelKind> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("obj")) {
        return Some(ModelKind::Obj);
    }
    let (head, _) = read::head(path, LONGEST_HEAD).ok()?;
    ply_mesh::is_mesh(&head).then_some(ModelKind::Ply)
}

/// Loads a file; the parameters are those of [`gltf::load`].
pub(super) fn load(
    path: &Path,
    transform: Mat4,
    earlier: &Earlier,
    wanted: Wanted<'_>,
) -> Result<Model, SceneError> {
    let Some(kind) = kind_of_file(path) else {
        return gltf::load(path, transform, earlier, wanted);
    };
    if wanted.variant.is_some() {
        let help = "remove `variant`: only glTF files have some";
        return Err(SceneError::invalid(path, "has no variants of materials", help));
    }
    let surface = match kind {
        ModelKind::Ply => ply_mesh::read(path, earlier.triangles as u64)?,
        ModelKind::Obj => obj::read(path, earlier, wanted.blend)?,
    };
    Limit::Triangles.grown_in(path, earlier.triangles as u64, surface.faces.len() as u64)?;
    Ok(model(surface, transform, wanted.is_keyed))
}

/// World space = `transform` * the file's space; a model with keys stays in its own space.
fn model(surface: Surface, transform: Mat4, is_keyed: bool) -> Model {
    let Surface { vertices, faces, materials, textures, mut skipped, notes } = surface;
    let mut triangles = vertices.triangles(&faces, &mut skipped);
    drop((vertices, faces));
    if !is_keyed {
        let count = triangles.len();
        place(&mut triangles, transform);
        if triangles.len() < count {
            let far = (count - triangles.len()) as u64;
            *skipped.entry("triangle not finite").or_default() += far;
        }
    }
    let rig = is_keyed.then(|| Rig::whole(triangles.len()));
    Model {
        materials,
        textures,
        triangles,
        lights: Vec::new(),
        camera: None,
        skipped,
        notes,
        has_splats: false,
        rig,
    }
}

/// Transforms triangles to world space, without those that are too far from the origin there.
fn place(triangles: &mut Vec<Triangle>, world: Mat4) {
    let normal_from_local = cofactors(Mat3::from_mat4(world));
    triangles.retain_mut(|triangle| {
        triangle.positions = triangle.positions.map(|p| world.transform_point3(p));
        triangle.normals = triangle.normals.map(|n| (normal_from_local * n).normalize_or(Vec3::Y));
        let near = |p: &Vec3| p.is_finite() && p.abs().max_element() <= FARTHEST;
        triangle.positions.iter().all(near)
    });
}

/// Contents of a glTF file: names and counts.
pub(super) fn facts(path: &Path) -> Vec<(&'static str, String)> {
    let Ok(file) = GltfFile::open(path) else { return Vec::new() };
    let document = &file.document;
    let counts = [
        ("nodes", document.nodes().len()),
        ("meshes", document.meshes().len()),
        ("materials", document.materials().len()),
        ("textures", document.textures().len()),
        ("animations", document.animations().len()),
        ("skins", document.skins().len()),
        ("cameras", document.cameras().len()),
        ("primitives of splats", file.splats.len()),
    ];
    let counts = counts.into_iter().filter(|(_, count)| *count > 0);
    let mut facts: Vec<_> = counts.map(|(name, count)| (name, count.to_string())).collect();
    let used: Vec<&str> = document.extensions_used().collect();
    if !used.is_empty() {
        facts.push(("extensions", used.join(", ")));
    }
    facts
}
