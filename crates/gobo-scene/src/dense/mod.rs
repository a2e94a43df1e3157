//! Files of dense voxel arrays, recognised by their contents.
//!
//! | file | axes | unit |
//! |---|---|---|
//! | `.npy`, `.npz` (`NumPy`) | `a[z, y, x]`, with colours `a[z, y, x, channel]` | none: a voxel is 1 |
//! | `.nrrd`, `.nhdr` (teem) | the fastest is x; by `space`, if that is of a body | `space units` |
//! | `.vti` (VTK) | x is right, y and z unchanged | none |
//! | `.nii`, `.nii.gz`, `.hdr` (NIfTI-1) | of a body | `xyzt_units` |
//! | `.mhd`, `.mha` (`MetaImage`) | of a body, by `AnatomicalOrientation` | `DistanceUnits`, mm of a body |
//! | `.tif`, `.tiff` (TIFF 6.0, pages are slices) | rows go down, pages back | of `ImageJ`'s description |
mod array;
mod bricks;
mod file;
mod meta;
mod nifti;
mod npy;
mod nrrd;
mod packed;
mod space;
mod text;
mod tiff;
mod voxels;
mod vti;

pub(super) use bricks::{DenseBricks, fitting_bricks};
pub(super) use voxels::Dense;

use super::{SceneError, read, vdb::VolumeFault};
use file::DenseFile;
use std::path::{Path, PathBuf};

/// A file format.
pub(super) struct DenseFormat {
    /// Endings of file names.
    pub(super) extensions: &'static [&'static str],
    /// Whether a file's first bytes are of this format.
    is: fn(&[u8]) -> bool,
    read: fn(&mut DenseFile<'_>) -> Result<Dense, VolumeFault>,
    /// Other file that a file names.
    named: fn(&[u8], &Path) -> Option<PathBuf>,
}

/// All formats of dense arrays.
pub(super) const FORMATS: [DenseFormat; 7] = [
    DenseFormat { extensions: &["npy"], is: npy::is, read: npy::read, named: no_file },
    DenseFormat {
        extensions: &["npz"],
        is: npy::is_archive,
        read: npy::read_archive,
        named: no_file,
    },
    DenseFormat {
        extensions: &["nrrd", "nhdr"],
        is: nrrd::is,
        read: nrrd::read,
        named: nrrd::named,
    },
    DenseFormat { extensions: &["vti"], is: vti::is, read: vti::read, named: no_file },
    DenseFormat {
        extensions: &["nii", "nii.gz", "hdr"],
        is: nifti::is,
        read: nifti::read,
        named: nifti::named,
    },
    DenseFormat { extensions: &["mhd", "mha"], is: meta::is, read: meta::read, named: meta::named },
    DenseFormat { extensions: &["tif", "tiff"], is: tiff::is, read: tiff::read, named: no_file },
];

/// Bytes at a file's beginning that tell its format and may name another file.
const HEAD: u64 = 1 << 16;

fn no_file(_: &[u8], _: &Path) -> Option<PathBuf> {
    None
}

/// Format of a file by its first bytes; `None` if it has another format or cannot be read.
pub(super) fn format_of(path: &Path) -> Option<&'static DenseFormat> {
    let (head, _) = read::head(path, HEAD).ok()?;
    FORMATS.iter().find(|format| (format.is)(&head))
}

/// The other file that this file names, if any.
pub(super) fn named(path: &Path) -> Option<PathBuf> {
    let (head, _) = read::head(path, HEAD).ok()?;
    FORMATS.iter().find(|format| (format.is)(&head)).and_then(|format| (format.named)(&head, path))
}

impl DenseFormat {
    /// Reads a file; `array`: the requested name.
    pub(super) fn read(&self, path: &Path, array: Option<&str>) -> Result<Dense, SceneError> {
        let mut file = DenseFile { path, bytes: read::bytes(path)?, array };
        (self.read)(&mut file)
            .map_err(|VolumeFault { message, help }| SceneError::invalid(path, message, help))
    }
}
