//! Reading of untrusted files.
use super::SceneError;
use std::{
    fs,
    io::{self, Read as _},
    path::{Component, Path},
    sync::OnceLock,
};

static WATCH: OnceLock<fn(&Path)> = OnceLock::new();

/// From now on, `watch` is called with each file before it is read: for a program that must not write over them. The
/// first call in a process counts.
#[cfg(feature = "internals")]
#[doc(hidden)]
pub fn watch_files(watch: fn(&Path)) {
    let _ = WATCH.set(watch);
}

/// All bytes of a regular file. A pipe or a device might never end.
pub(super) fn bytes(path: &Path) -> Result<Vec<u8>, SceneError> {
    check(path)?;
    fs::read(path).map_err(|source| failed(path, source))
}

/// The first bytes of a regular file, at most so many, and its length.
pub(super) fn head(path: &Path, most: u64) -> Result<(Vec<u8>, u64), SceneError> {
    let length = length(path)?;
    let mut bytes = Vec::new();
    let file = fs::File::open(path).map_err(|source| failed(path, source))?;
    file.take(most).read_to_end(&mut bytes).map_err(|source| failed(path, source))?;
    Ok((bytes, length))
}

/// Checks that the path is a regular file.
pub(super) fn check(path: &Path) -> Result<(), SceneError> {
    length(path).map(|_| ())
}

/// Length of a regular file that is about to be read [bytes].
pub(super) fn length(path: &Path) -> Result<u64, SceneError> {
    let metadata = fs::metadata(path).map_err(|source| failed(path, source))?;
    let kind = metadata.file_type();
    if kind.is_file() {
        if let Some(watch) = WATCH.get() {
            watch(path);
        }
        return Ok(metadata.len());
    }
    let message = if kind.is_dir() { "is a folder" } else { "is a device or a pipe" };
    Err(SceneError::invalid(path, message, "name a plain file"))
}

fn failed(path: &Path, source: io::Error) -> SceneError {
    if source.kind() == io::ErrorKind::OutOfMemory {
        return SceneError::memory(path, "no memory for the file");
    }
    SceneError::Read { path: path.to_owned(), source }
}

/// Whether a path is absolute, or climbs above its start.
pub(super) fn leaves_folder(path: &Path) -> bool {
    let mut depth = 0i64;
    path.components().any(|component| {
        match component {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir => depth -= 1,
            Component::RootDir | Component::Prefix(_) => return true,
        }
        depth < 0
    }) || depth == 0
}
