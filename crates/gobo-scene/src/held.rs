//! Files that a host holds in place of the file system: a browser's, or those of an archive.
use std::{
    collections::HashMap,
    fmt, io,
    ops::Range,
    path::{Component, Path, PathBuf},
    sync::{Arc, PoisonError, RwLock},
};

/// Reads a range of bytes.
type Read = dyn Fn(Range<u64>) -> io::Result<Vec<u8>> + Send + Sync;

/// A file that a host holds.
#[derive(Clone)]
pub struct HeldFile {
    /// Length \[bytes\].
    length: u64,
    read: Arc<Read>,
}

impl fmt::Debug for HeldFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HeldFile").field("length", &self.length).finish_non_exhaustive()
    }
}

impl HeldFile {
    /// A file of `length` bytes; `read` returns the bytes of a range.
    pub fn new(
        length: u64,
        read: impl Fn(Range<u64>) -> io::Result<Vec<u8>> + Send + Sync + 'static,
    ) -> Self {
        Self { length, read: Arc::new(read) }
    }

    /// A file of these bytes.
    pub fn of_bytes(bytes: impl Into<Arc<[u8]>>) -> Self {
        let bytes: Arc<[u8]> = bytes.into();
        Self::new(bytes.len() as u64, move |range| {
            Ok(bytes[range.start as usize..range.end as usize].to_vec())
        })
    }

    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Its first bytes, at most `most`.
    pub(super) fn first(&self, most: u64) -> io::Result<Vec<u8>> {
        let wanted = self.length.min(most);
        let bytes = (self.read)(0..wanted)?;
        let is_whole = bytes.len() as u64 == wanted;
        is_whole.then_some(bytes).ok_or_else(|| io::ErrorKind::UnexpectedEof.into())
    }
}

/// Files by path.
type FilesByPath = HashMap<PathBuf, HeldFile>;

static TABLE: RwLock<Option<FilesByPath>> = RwLock::new(None);

/// Files that are read in place of the file system's; see [`hold_files`].
#[derive(Debug)]
pub struct HeldFiles {
    paths: Vec<PathBuf>,
}

/// Makes every reader of this process use `files` for the paths that name them, until the result is dropped.
/// The files that a scene names lie beside it: `smoke.ply` of `hall/scene.toml` is `hall/smoke.ply`.
pub fn hold_files(files: impl IntoIterator<Item = (PathBuf, HeldFile)>) -> HeldFiles {
    let mut table = TABLE.write().unwrap_or_else(PoisonError::into_inner);
    let table = table.get_or_insert_default();
    let hold = |(path, file): (PathBuf, HeldFile)| {
        let path = plain(&path);
        table.insert(path.clone(), file);
        path
    };
    HeldFiles { paths: files.into_iter().map(hold).collect() }
}

impl Drop for HeldFiles {
    fn drop(&mut self) {
        let mut table = TABLE.write().unwrap_or_else(PoisonError::into_inner);
        if let Some(table) = &mut *table {
            self.paths.iter().for_each(|path| drop(table.remove(path)));
        }
    }
}

/// The held file of a path.
pub(super) fn held(path: &Path) -> Option<HeldFile> {
    let table = TABLE.read().unwrap_or_else(PoisonError::into_inner);
    table.as_ref().filter(|table| !table.is_empty())?.get(&plain(path)).cloned()
}

/// The path without `.` and, unless they leave a named folder, without `..`.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if plain.file_name().is_some() => drop(plain.pop()),
            other => plain.push(other),
        }
    }
    plain
}
