//! Store of a SOG's files: a zip, or a folder.
use super::sog::DAMAGED;
use crate::{
    SceneError,
    error::{Fault, quoted},
    read,
};
use std::{
    borrow::Cow,
    io::{Cursor, Read as _},
    path::{Path, PathBuf},
};
use zip::ZipArchive;

pub(super) enum Store<'a> {
    Zip(ZipArchive<Cursor<&'a [u8]>>),
    Folder(PathBuf),
}

impl<'a> Store<'a> {
    pub(super) fn zip(bytes: &'a [u8]) -> Result<Self, Fault> {
        let archive = ZipArchive::new(Cursor::new(bytes));
        archive.map(Self::Zip).map_err(|error| (format!("not a valid zip file: {error}"), DAMAGED))
    }

    pub(super) fn folder(path: &Path) -> Self {
        Self::Folder(path.to_owned())
    }

    /// Bytes of a file, at most `most`.
    pub(super) fn member(&mut self, name: &str, most: u64) -> Result<Vec<u8>, Fault> {
        match self {
            Self::Zip(archive) => member_of_zip(archive, name, most),
            Self::Folder(folder) => member_of_folder(folder, name, most),
        }
    }
}

fn member_of_zip(
    archive: &mut ZipArchive<Cursor<&[u8]>>,
    name: &str,
    most: u64,
) -> Result<Vec<u8>, Fault> {
    let named = quoted(name);
    let mut file = archive.by_name(name).map_err(|error| {
        let help = "a .sog is a zip with meta.json and the images that it names at its root";
        (format!("{named} in the zip: {error}"), help)
    })?;
    let long = || (format!("{named} in the zip has more than {most} bytes"), DAMAGED);
    if file.size() > most {
        return Err(long());
    }
    let mut bytes = Vec::new();
    let read = file.by_ref().take(most + 1).read_to_end(&mut bytes);
    read.map_err(|error| (format!("{named} in the zip: {error}"), DAMAGED))?;
    if bytes.len() as u64 > most { Err(long()) } else { Ok(bytes) }
}

fn member_of_folder(folder: &Path, name: &str, most: u64) -> Result<Vec<u8>, Fault> {
    let beside = "put the images beside meta.json, as they were written";
    let path = path_in(folder, name)?;
    let failed = |error: SceneError| match error {
        SceneError::Read { source, .. } => (format!("{}: {source}", quoted(name)), beside),
        SceneError::Invalid { message, .. } => (format!("{} {message}", quoted(name)), beside),
        other => (other.to_string(), "use a smaller file, or a machine with more memory"),
    };
    if read::length(&path).map_err(failed)? > most {
        return Err((format!("{} has more than {most} bytes", quoted(name)), DAMAGED));
    }
    read::bytes(&path).map_err(failed)
}

/// Path of a file in a folder or below.
pub(super) fn path_in(folder: &Path, name: &str) -> Result<PathBuf, Fault> {
    if name.contains(['\\', ':']) || read::leaves_folder(Path::new(name)) {
        let message = format!("{} leaves the folder of the file", quoted(name));
        return Err((message, "name files in the folder or below it"));
    }
    Ok(folder.join(name))
}

/// Last part of a path.
pub(super) fn file_name(path: &Path) -> Cow<'_, str> {
    path.file_name().unwrap_or_default().to_string_lossy()
}
