//! Files of anisotropic Gaussians (splats), recognised by their contents.
//!
//! | file | coordinates | opacity | scale |
//! |---|---|---|---|
//! | `.ply` of 3D Gaussian splatting (Kerbl et al. 2023) | unchanged (not specified) | logit | logarithm |
//! | `.compressed.ply` (`PlayCanvas`) | unchanged, like its source `.ply` | 8 bits | logarithm |
//! | `.splat` | unchanged | 8 bits | plain |
//! | `.spz` 1 to 4 (Niantic) | x right, y up, z back, as here | 8 bits | logarithm |
//! | `.sog` 2 (`PlayCanvas`), folders, levels | unchanged, like its source `.ply` | 8 bits | logarithm |
//! | `.ksplat` 0.1 (mkkellogg) | unchanged | 8 bits | plain |
//! | `KHR_gaussian_splatting` in glTF | glTF's, as here | plain | plain; logarithm in drafts |
//! | `.ply` of volumetric primitives (Condor et al. 2024) | unchanged | extinction | logarithm |
mod bare;
mod cloud;
mod clusters;
mod harmonics;
mod kind;
mod ksplat;
mod packed;
mod place;
mod ply;
mod sog;
mod sog_levels;
mod sog_store;
mod spz;
mod write_ply;
mod write_sog;
mod write_spz;

pub(super) use cloud::HARMONIC;
pub use cloud::{SplatCloud, valid};
pub use harmonics::Harmonics;
pub use kind::SplatKind;
pub(super) use place::placed;
pub(super) use spz::Spz;
pub use write_ply::to_ply;
pub use write_sog::to_sog;
pub use write_spz::to_spz;

use crate::error::Fault;
use gobo::model::ShadowSettings;
use sog_store::{Store, file_name};
use std::path::{Path, PathBuf};

/// Choice of a level of detail, in a file with several.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct Detail {
    /// Level that is asked for; 0 is the finest.
    pub lod: Option<u32>,
    /// Texels of a map, or pixels of a picture, along the splats: levels finer than both are not read.
    pub across: u32,
}

impl Default for Detail {
    fn default() -> Self {
        Self { lod: None, across: ShadowSettings::default().size }
    }
}

/// Kind of splats in a file of `length` bytes, by its first bytes; `None` if it has none, or is glTF.
pub fn kind_of(start: &[u8], length: u64) -> Option<SplatKind> {
    if start.starts_with(b"ply") {
        return ply::kind_of(start);
    }
    if spz::is_spz(start) {
        return Some(SplatKind::Spz);
    }
    if start.starts_with(b"PK\x03\x04") {
        // The name of the first file: archives of USD begin with a scene.
        let name = String::from_utf8_lossy(start.get(30..start.len().min(300)).unwrap_or_default());
        return (!name.contains(".usd")).then_some(SplatKind::Sog);
    }
    if start.trim_ascii_start().starts_with(b"{") {
        return kind_of_json(start);
    }
    if ksplat::is_ksplat(start, length) {
        return Some(SplatKind::Ksplat);
    }
    // A file without a header is also recognised by its length.
    (bare::is_whole(length) && bare::is_bare(start)).then_some(SplatKind::Bare)
}

/// Keys of the two kinds of `meta.json`, all near its beginning.
const LEVELS: [&str; 2] = ["\"lodLevels\"", "\"filenames\""];
const IMAGES: [&str; 3] = ["\"means\"", "\"scales\"", "\"files\""];

fn kind_of_json(start: &[u8]) -> Option<SplatKind> {
    let text = String::from_utf8_lossy(start);
    let has = |keys: &[&str]| keys.iter().all(|key| text.contains(key));
    if has(&LEVELS) {
        return Some(SplatKind::SogLevels);
    }
    has(&IMAGES).then_some(SplatKind::SogFolder)
}

/// Number of splats that the first bytes of a file of `length` bytes announce, if the file is long enough for
/// them; `None` where only more of it tells.
pub(super) fn announced(kind: SplatKind, start: &[u8], length: u64) -> Option<u64> {
    match kind {
        SplatKind::Ply | SplatKind::Packed => crate::ply::announced((start.to_vec(), length)),
        SplatKind::Bare => Some(bare::count(length)),
        SplatKind::Spz => spz::announced(start),
        SplatKind::Ksplat => ksplat::announced(start),
        SplatKind::Sog | SplatKind::SogFolder | SplatKind::SogLevels => None,
    }
}

/// Reads the bytes of a file of a kind. `path`: of the file; the other files of a SOG are beside it.
pub fn read_kind(
    kind: SplatKind,
    path: &Path,
    bytes: &[u8],
    detail: Detail,
) -> Result<SplatCloud, Fault> {
    if detail.lod.is_some() && kind != SplatKind::SogLevels {
        let help = "remove it; a streamed SOG (lod-meta.json) has levels";
        return Err(("lod of a file without levels of detail".to_owned(), help));
    }
    match kind {
        SplatKind::Ply => ply::read(bytes),
        SplatKind::Packed => packed::read(bytes),
        SplatKind::Bare => bare::read(bytes),
        SplatKind::Spz => spz::read(bytes),
        SplatKind::Sog => sog::read(&mut Store::zip(bytes)?, sog::META),
        SplatKind::SogFolder => sog::read(&mut Store::folder(folder(path)), &file_name(path)),
        SplatKind::SogLevels => sog_levels::read(path, bytes, detail),
        SplatKind::Ksplat => ksplat::read(bytes),
    }
}

/// Reads the higher harmonics of a file, a row for each of its rows; parameters as of [`read_kind`].
pub(crate) fn read_harmonics(
    kind: SplatKind,
    path: &Path,
    bytes: &[u8],
    detail: Detail,
) -> Result<Harmonics, Fault> {
    match kind {
        SplatKind::Ply => ply::harmonics(bytes),
        SplatKind::Packed => packed::harmonics(bytes),
        SplatKind::Bare => Ok(Harmonics::default()),
        SplatKind::Spz => Spz::open_whole(bytes)?.all_harmonics(),
        SplatKind::Sog => Ok(sog::harmonics(&mut Store::zip(bytes)?, sog::META)?.0),
        SplatKind::SogFolder => {
            let mut store = Store::folder(folder(path));
            Ok(sog::harmonics(&mut store, &file_name(path))?.0)
        }
        SplatKind::SogLevels => sog_levels::harmonics(path, bytes, detail),
        SplatKind::Ksplat => ksplat::harmonics(bytes),
    }
}

/// Files beside one of a kind that are read with it.
pub(super) fn files(kind: SplatKind, path: &Path, bytes: &[u8]) -> Result<Vec<PathBuf>, Fault> {
    match kind {
        SplatKind::SogFolder => {
            let folder = folder(path);
            sog::images(folder, &file_name(path))?
                .iter()
                .map(|name| sog_store::path_in(folder, name))
                .collect()
        }
        SplatKind::SogLevels => sog_levels::files(path, bytes),
        _ => Ok(Vec::new()),
    }
}

fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}
