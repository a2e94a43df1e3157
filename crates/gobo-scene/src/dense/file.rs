//! A file of an array, and the files that it names.
use crate::{error::quoted, read, vdb::VolumeFault};
use std::path::{Component, Path, PathBuf};

/// A file that is read.
pub(super) struct DenseFile<'a> {
    pub(super) path: &'a Path,
    pub(super) bytes: Vec<u8>,
    /// Name of the requested array.
    pub(super) array: Option<&'a str>,
}

impl DenseFile<'_> {
    /// Refuses the name of an array in a file that holds a single one.
    pub(super) fn has_one_array(&self) -> Result<(), VolumeFault> {
        match self.array {
            None => Ok(()),
            Some(_) => Err(VolumeFault::new("a grid of a file that names none", "remove `grid`")),
        }
    }
}

/// Path of a file that another one names, in the same folder.
pub(super) fn beside(path: &Path, name: &str) -> Result<PathBuf, VolumeFault> {
    let is_plain = |part| matches!(part, Component::Normal(_) | Component::CurDir);
    if name.is_empty() || !Path::new(name).components().all(is_plain) {
        let message = format!("its data are in {}", quoted(name));
        return Err(VolumeFault::new(
            message,
            "put the data beside the header, and name them without a folder",
        ));
    }
    Ok(path.with_file_name(name))
}

/// Bytes of a file that another one names.
pub(super) fn bytes_beside(path: &Path, name: &str) -> Result<Vec<u8>, VolumeFault> {
    let path = beside(path, name)?;
    read::bytes(&path)
        .map_err(|error| VolumeFault::new(error.to_string(), "put the data beside the header"))
}
