//! Folders, file names, and output streams that may be closed.
use super::{
    failure::{Failure, harmless},
    output::TEMPORARY,
};
use sha2::{Digest as _, Sha256};
use std::{
    collections::HashMap,
    fs,
    io::{self, Write as _},
    path::{Path, PathBuf},
};

/// Folder of a file.
pub(super) fn folder(path: &Path) -> &Path {
    path.parent().filter(|parent| *parent != Path::new("")).unwrap_or(Path::new("."))
}

/// Flushes the names in a folder to the disk, where the system can.
pub(crate) fn sync_dir(path: &Path) {
    if cfg!(unix)
        && let Ok(dir) = fs::File::open(path)
        && let Err(error) = dir.sync_all()
    {
        tracing::debug!("{}: {error}", path.display());
    }
}

pub(crate) fn create_dir(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path).map_err(|source| Failure::file(path, source))
}

/// Plain files of a folder, unsorted, without hidden ones: our own are hidden while they are written.
pub(crate) fn entries(dir: &Path) -> Result<Vec<PathBuf>, Failure> {
    let failed = |source| Failure::file(dir, source);
    let mut files = Vec::new();
    for entry in fs::read_dir(dir).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let is_shown = !entry.file_name().as_encoded_bytes().starts_with(b".");
        if is_shown && entry.file_type().map_err(failed)?.is_file() {
            files.push(entry.path());
        }
    }
    Ok(files)
}

/// Temporary files in a folder for names that begin with `start`; none if the folder cannot be listed.
pub(super) fn temporaries(dir: &Path, start: &str) -> Vec<PathBuf> {
    let start = format!(".{start}");
    let entries = fs::read_dir(dir).into_iter().flatten().flatten();
    let is_temporary = |entry: &fs::DirEntry| {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        name.starts_with(&start)
            && name.ends_with(TEMPORARY)
            && entry.file_type().is_ok_and(|kind| kind.is_file())
    };
    entries.filter(is_temporary).map(|entry| entry.path()).collect()
}

/// A digest in hexadecimal digits.
pub(super) fn hex(bytes: impl AsRef<[u8]>) -> String {
    bytes.as_ref().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A file, and the digest of the bytes written to it.
pub(super) struct Digesting<W> {
    pub(super) file: W,
    pub(super) digest: Sha256,
}

impl<W: io::Write> Digesting<W> {
    pub(super) fn new(file: W) -> Self {
        Self { file, digest: Sha256::new() }
    }
}

impl<W: io::Write> io::Write for Digesting<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.digest.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Writes warnings to standard error, a line each.
pub(crate) fn warn(notes: &[String]) {
    for note in notes {
        tracing::warn!("{}", harmless(note));
    }
}

/// Standard error, which may be full or closed: errors are ignored.
#[derive(Debug)]
pub(crate) struct Quiet;

impl io::Write for Quiet {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let _ = io::stderr().lock().write_all(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Prints one result to standard output.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    match writeln!(io::stdout().lock(), "{text}") {
        // The reader has closed the pipe.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => result.map_err(Failure::Output),
    }
}

/// Unique names of files.
#[derive(Debug, Default)]
pub(crate) struct Unique {
    /// Names in lower case, as many file systems ignore case, each with its last number.
    taken: HashMap<String, u32>,
}

impl Unique {
    /// `name`, or `name` with a number if it is taken.
    pub(crate) fn of(&mut self, name: &str) -> String {
        let key = name.to_ascii_lowercase();
        let Some(&last) = self.taken.get(&key) else {
            self.taken.insert(key, 1);
            return name.to_owned();
        };
        let numbered = |number: u32| format!("{name}_{number}");
        let is_free =
            |number: &u32| !self.taken.contains_key(&numbered(*number).to_ascii_lowercase());
        let number = (last + 1..).find(is_free).unwrap_or(u32::MAX);
        self.taken.insert(key, number);
        self.taken.insert(numbered(number).to_ascii_lowercase(), 1);
        numbered(number)
    }
}
