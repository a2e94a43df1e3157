//! Splat files of all kinds.
use super::{
    SceneError,
    error::Fault,
    gltf,
    limits::Limit,
    read,
    splats::{
        self, Detail, Harmonics, SplatCloud, SplatKind, files, kind_of, read_harmonics, read_kind,
    },
};
use std::{
    borrow::Cow,
    ops::Range,
    path::{Path, PathBuf},
};

/// Bytes at a file's beginning that tell its kind: longer than the header of any PLY.
const LONGEST_HEAD: u64 = 1 << 16;

/// Index files of a folder of splats: of levels of detail, or of one SOG.
const METAS: [&str; 2] = ["lod-meta.json", "meta.json"];

/// Splats of a file in a scene.
#[derive(Clone, Debug, Default)]
pub(super) struct FoundSplats {
    pub(super) range: Range<usize>,
    /// Id of the file's first row.
    pub(super) first_id: u32,
    pub(super) detail: Detail,
}

/// Reads a file or folder of splats, whatever its name. World space = the file's space.
pub fn load_splats(path: &Path) -> Result<SplatCloud, SceneError> {
    load_level(path, Detail::default())
}

/// Reads the higher harmonics of a file or folder of splats, one row for each of its rows. `None` where they
/// would have to be turned: of a glTF file whose nodes rotate or mirror splats.
pub fn load_harmonics(path: &Path) -> Result<Option<Harmonics>, SceneError> {
    harmonics_of_level(path, Detail::default())
}

/// Like [`load_harmonics`], at a level of detail as in [`load_level`].
pub(super) fn harmonics_of_level(
    path: &Path,
    detail: Detail,
) -> Result<Option<Harmonics>, SceneError> {
    let path = &*inside(path);
    let bytes = read::bytes(path)?;
    let of_file = |(message, help): Fault| SceneError::invalid(path, message, help);
    match kind_of(&bytes, bytes.len() as u64).or_else(|| kind_of_name(path)) {
        Some(kind) => read_harmonics(kind, path, &bytes, detail).map(Some).map_err(of_file),
        None if is_gltf(&bytes) => gltf::splats::harmonics(path),
        None => Ok(None),
    }
}

/// Like [`load_splats`], at a level of detail.
pub(super) fn load_level(path: &Path, detail: Detail) -> Result<SplatCloud, SceneError> {
    let path = &*inside(path);
    if let Some(count) = announced(path) {
        Limit::Splats.grown_in(path, 0, count)?;
    }
    let bytes = read::bytes(path)?;
    let of_file = |(message, help): (String, &str)| SceneError::invalid(path, message, help);
    match kind_of(&bytes, bytes.len() as u64).or_else(|| kind_of_name(path)) {
        Some(kind) => read_kind(kind, path, &bytes, detail).map_err(of_file),
        None if is_gltf(&bytes) => {
            if detail.lod.is_some() {
                return Err(of_file((
                    "lod of a file without levels of detail".to_owned(),
                    "remove it; a streamed SOG (lod-meta.json) has levels",
                )));
            }
            gltf::splats::read(path)
        }
        None => {
            let help = "splats are a .ply, .splat, .ksplat, .spz, .sog, .glb or .gltf file, or the \
                folder of a SOG";
            Err(of_file(("holds no splats of a known kind".to_owned(), help)))
        }
    }
}

/// Number of splats that a file's head announces; `None` if it has no splats, or only more of it tells.
pub(super) fn announced(path: &Path) -> Option<u64> {
    let (head, length) = read::head(path, LONGEST_HEAD).ok()?;
    splats::announced(kind_of(&head, length)?, &head, length)
}

/// The index file of a folder of splats, or the path itself.
pub(super) fn inside(path: &Path) -> Cow<'_, Path> {
    if !path.is_dir() {
        return path.into();
    }
    let mut metas = METAS.iter().map(|name| path.join(name));
    metas.find(|meta| read::is_file(meta)).map_or(path.into(), Cow::Owned)
}

/// Kind of splats in a file or folder, by its head; `None` if it has no splats or is glTF, or the file cannot
/// be read.
pub(super) fn kind_of_file(path: &Path) -> Option<SplatKind> {
    let path = inside(path);
    let (head, length) = read::head(&path, LONGEST_HEAD).ok()?;
    kind_of(&head, length).or_else(|| kind_of_name(&path))
}

/// All files of splats that belong to a path: the file itself or its index first, then those that it names.
pub(super) fn named_files(path: &Path) -> Result<Vec<PathBuf>, SceneError> {
    let path = inside(path).into_owned();
    let mut all = Vec::new();
    if let Some(kind @ (SplatKind::SogFolder | SplatKind::SogLevels)) = kind_of_file(&path) {
        let bytes = read::bytes(&path)?;
        let of_file = |(message, help): (String, &str)| SceneError::invalid(&path, message, help);
        all = files(kind, &path, &bytes).map_err(of_file)?;
    }
    all.insert(0, path);
    Ok(all)
}

/// Kind by a name that no other kind has.
fn kind_of_name(path: &Path) -> Option<SplatKind> {
    match path.file_name()?.to_str()? {
        "lod-meta.json" => Some(SplatKind::SogLevels),
        "meta.json" => Some(SplatKind::SogFolder),
        _ => None,
    }
}

/// Whether the bytes begin a glTF file of any contents.
fn is_gltf(bytes: &[u8]) -> bool {
    bytes.starts_with(b"glTF") || bytes.trim_ascii_start().starts_with(b"{")
}
