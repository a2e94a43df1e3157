//! Reading of untrusted files.
use super::{
    SceneError,
    held::{HeldFile, held},
    limits,
};
use std::{
    fs,
    io::{self, BufRead, BufReader, Cursor, Read as _, Seek},
    path::{Component, Path},
    sync::OnceLock,
};

static WATCH: OnceLock<fn(&Path)> = OnceLock::new();

/// From now on, `watch` is called with each file before it is read: for a program that must not overwrite
/// them. Only the first call in a process counts.
#[doc(hidden)]
pub fn watch_files(watch: fn(&Path)) {
    let _ = WATCH.set(watch);
}

/// All bytes of a regular file; a pipe or a device might never end.
pub(super) fn bytes(path: &Path) -> Result<Vec<u8>, SceneError> {
    if let Some(file) = held(path) {
        return held_bytes(path, &file, u64::MAX);
    }
    check(path)?;
    fs::read(path).map_err(|source| failed(path, source))
}

fn held_bytes(path: &Path, file: &HeldFile, most: u64) -> Result<Vec<u8>, SceneError> {
    if !limits::has_memory(file.length().min(most)) {
        return Err(failed(path, io::ErrorKind::OutOfMemory.into()));
    }
    file.first(most).map_err(|source| failed(path, source))
}

/// The first bytes of a regular file, at most `most`, and its length.
pub(super) fn head(path: &Path, most: u64) -> Result<(Vec<u8>, u64), SceneError> {
    if let Some(file) = held(path) {
        return Ok((held_bytes(path, &file, most)?, file.length()));
    }
    let length = length(path)?;
    let mut bytes = Vec::new();
    let file = fs::File::open(path).map_err(|source| failed(path, source))?;
    file.take(most).read_to_end(&mut bytes).map_err(|source| failed(path, source))?;
    Ok((bytes, length))
}

/// Input of a decoder.
pub(super) trait Readable: BufRead + Seek {}

impl<T: BufRead + Seek> Readable for T {}

/// A regular file, to be read in parts.
pub(super) fn open(path: &Path) -> Result<Box<dyn Readable>, SceneError> {
    if let Some(file) = held(path) {
        return Ok(Box::new(Cursor::new(held_bytes(path, &file, u64::MAX)?)));
    }
    check(path)?;
    let file = fs::File::open(path).map_err(|source| failed(path, source))?;
    Ok(Box::new(BufReader::new(file)))
}

/// Whether there is a regular file.
pub(super) fn is_file(path: &Path) -> bool {
    held(path).is_some() || path.is_file()
}

/// Checks that the path is a regular file.
pub(super) fn check(path: &Path) -> Result<(), SceneError> {
    length(path).map(|_| ())
}

/// Length of a regular file that is about to be read \[bytes\].
pub(super) fn length(path: &Path) -> Result<u64, SceneError> {
    if let Some(file) = held(path) {
        return Ok(file.length());
    }
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
    if source.kind() == io::ErrorKind::Unsupported {
        let help = "give it together with the file that names it";
        return SceneError::invalid(path, "is not among the files that were given", help);
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
