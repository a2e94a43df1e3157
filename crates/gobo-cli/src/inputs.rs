//! Files that the command reads: no output may replace them.
use super::failure::Failure;
use std::{
    fs::{self, Metadata},
    io,
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
};

/// Identity of a file under any of its names: a link has that of its target.
#[cfg(unix)]
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Identity {
    device: u64,
    inode: u64,
}

#[cfg(unix)]
impl Identity {
    /// `metadata`: of the path, links followed.
    fn new(_path: &Path, metadata: &Metadata) -> io::Result<Self> {
        use std::os::unix::fs::MetadataExt as _;
        Ok(Self { device: metadata.dev(), inode: metadata.ino() })
    }
}

#[cfg(not(unix))]
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Identity(same_file::Handle);

#[cfg(not(unix))]
impl Identity {
    fn new(path: &Path, _metadata: &Metadata) -> io::Result<Self> {
        same_file::Handle::from_path(path).map(Self)
    }
}

impl Identity {
    pub(super) fn of(path: &Path) -> io::Result<Self> {
        Self::new(path, &fs::metadata(path)?)
    }
}

/// Inputs of this process, which runs one command.
static INPUTS: Mutex<Vec<(Identity, PathBuf)>> = Mutex::new(Vec::new());

fn inputs() -> MutexGuard<'static, Vec<(Identity, PathBuf)>> {
    INPUTS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From now on, every file that a scene reads is an input.
pub(crate) fn watch() {
    gobo_scene::watch_files(add);
}

/// Adds a file. A missing file is no input: its reader reports it.
pub(super) fn add(path: &Path) {
    let Ok(identity) = Identity::of(path) else { return };
    let mut inputs = inputs();
    if !inputs.iter().any(|(known, _)| *known == identity) {
        inputs.push((identity, path.to_owned()));
    }
}

/// The inputs so far, each once.
pub(super) fn all() -> Vec<PathBuf> {
    inputs().iter().map(|(_, path)| path.clone()).collect()
}

/// Refuses an output that is an input. `metadata`: of the output, links followed.
pub(super) fn check(output: &Path, metadata: &Metadata) -> Result<(), Failure> {
    let inputs = inputs();
    if inputs.is_empty() {
        return Ok(());
    }
    let identity = Identity::new(output, metadata).map_err(|error| Failure::file(output, error))?;
    match inputs.iter().find(|(known, _)| *known == identity) {
        None => Ok(()),
        Some((_, input)) => {
            let message = format!("is a file that this command reads, {}", input.display());
            Err(Failure::refused(output, message, "name another file to write"))
        }
    }
}

/// Refuses a folder in which an output would replace an input. `is_written`: whether the command writes a
/// path in the folder, with `/` as separator; for a path that ends with `/`, whether it writes below it.
pub(super) fn check_folder(
    folder: &Path,
    is_written: impl Fn(&str) -> bool,
) -> Result<(), Failure> {
    let mut pending = vec![(folder.to_owned(), String::new())];
    while let Some((dir, start)) = pending.pop() {
        // Folders that cannot be listed are new, or fail when they are written to.
        for entry in fs::read_dir(&dir).into_iter().flatten().flatten() {
            let name = start.clone() + &entry.file_name().to_string_lossy();
            let below = name.clone() + "/";
            let (is_file, is_folder) = (is_written(&name), is_written(&below));
            if is_file || is_folder {
                let Ok(metadata) = fs::metadata(entry.path()) else { continue };
                if metadata.is_dir() {
                    pending.push((entry.path(), below));
                } else if is_file {
                    check(&entry.path(), &metadata)?;
                }
            }
        }
    }
    Ok(())
}
