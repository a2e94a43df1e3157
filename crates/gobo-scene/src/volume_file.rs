//! Volume files, recognised by their contents.
use super::{
    SceneError,
    dense::{self, Dense},
    read,
    vdb::{Vdb, VolumeFault},
};
use std::path::Path;

/// A volume file in memory.
#[derive(Debug)]
pub(super) enum VolumeFile {
    Vdb(Vdb),
    Dense(Dense),
}

impl VolumeFile {
    /// Extensions of volume files.
    pub(super) fn extensions() -> impl Iterator<Item = &'static str> {
        let dense = dense::FORMATS.iter().flat_map(|format| format.extensions);
        ["vdb", "nvdb"].into_iter().chain(dense.copied())
    }

    /// Extensions of a file's format, by its head; `None` if it holds no volume.
    pub(super) fn endings_of(path: &Path) -> Option<&'static [&'static str]> {
        if let Some(dense) = dense::format_of(path) {
            return Some(dense.extensions);
        }
        let (head, _) = read::head(path, 8).ok()?;
        let endings: &[&str] = if Vdb::is_nano(&head) { &["nvdb"] } else { &["vdb"] };
        Vdb::is(&head).then_some(endings)
    }

    /// Whether a file holds a volume, by its head.
    pub(super) fn is(path: &Path) -> bool {
        Self::endings_of(path).is_some()
    }

    /// Reads a file. `grid`: the requested name.
    pub(super) fn open(path: &Path, grid: Option<&str>) -> Result<Self, SceneError> {
        let _phase = tracing::debug_span!("read").entered();
        read::check(path)?;
        if let Some(format) = dense::format_of(path) {
            return format.read(path, grid).map(Self::Dense);
        }
        let bytes = read::bytes(path)?;
        let is_named =
            path.extension().is_some_and(|extension| extension == "vdb" || extension == "nvdb");
        if !is_named && !Vdb::is(&bytes) {
            let endings: Vec<_> = Self::extensions().map(|ending| format!(".{ending}")).collect();
            let help = format!("volumes are files of these kinds: {}", endings.join(" "));
            return Err(SceneError::invalid(path, "a volume of no known kind", &help));
        }
        let vdb = Vdb::new(bytes);
        let of_file = |VolumeFault { message, help }| SceneError::invalid(path, message, help);
        vdb.map(Self::Vdb).map_err(of_file)
    }

    /// Colour channels of each voxel, or 1.
    pub(super) fn channels(&self) -> usize {
        match self {
            Self::Dense(dense) if dense.channels() > 1 => 3,
            _ => 1,
        }
    }
}
