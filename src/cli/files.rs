//! Files that are written atomically, and output streams that may be closed.
use super::failure::{Failure, harmless};
use std::{
    collections::HashMap,
    ffi::OsString,
    fs,
    io::{self, Write as _},
    path::{Path, PathBuf},
};

/// A file in the making: it appears complete under its name, or not at all.
#[derive(Debug)]
pub(crate) struct Pending {
    path: PathBuf,
    temporary: PathBuf,
    file: fs::File,
}

impl Pending {
    pub(crate) fn new(path: &Path) -> Result<Self, Failure> {
        let mut name = OsString::from(".");
        name.push(path.file_name().unwrap_or_default());
        name.push(format!(".{}.tmp", std::process::id()));
        let temporary = path.with_file_name(name);
        let file = fs::File::create(&temporary).map_err(|source| Failure::file(path, source))?;
        // The lock tells other runs that this file is not abandoned; not all file systems have locks.
        let _ = file.lock();
        Ok(Self { path: path.to_owned(), temporary, file })
    }

    /// Its name in the end.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Where its contents go.
    pub(crate) fn writer(&self) -> io::Result<fs::File> {
        self.file.try_clone()
    }

    /// Gives the file its name.
    pub(crate) fn finish(self) -> Result<(), Failure> {
        fs::rename(&self.temporary, &self.path).map_err(|source| Failure::file(&self.path, source))
    }
}

impl Drop for Pending {
    /// What was not finished is of no use.
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.temporary);
    }
}

/// Writes a file atomically: it appears complete under its name, or stays untouched.
pub(crate) fn write(path: &Path, contents: &[u8]) -> Result<(), Failure> {
    let mut pending = Pending::new(path)?;
    pending.file.write_all(contents).map_err(|source| Failure::file(path, source))?;
    pending.finish()
}

/// Creates the folder, and removes temporary files of killed runs.
pub(crate) fn create_dir(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path).map_err(|source| Failure::file(path, source))?;
    // Entries that cannot be listed or removed are no error of this run.
    for entry in fs::read_dir(path).into_iter().flatten().flatten() {
        let stray = entry.path();
        let is_ours = entry.file_name().to_str().is_some_and(is_temporary);
        if is_ours && entry.file_type().is_ok_and(|kind| kind.is_file()) && is_abandoned(&stray) {
            let _ = fs::remove_file(stray);
        }
    }
    Ok(())
}

/// Files of a folder, unsorted, without temporary ones.
pub(crate) fn entries(dir: &Path) -> Result<Vec<PathBuf>, Failure> {
    let failed = |source| Failure::file(dir, source);
    let mut files = Vec::new();
    for entry in fs::read_dir(dir).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let is_own = entry.file_name().to_str().is_some_and(|name| !is_temporary(name));
        if is_own && entry.file_type().map_err(failed)?.is_file() {
            files.push(entry.path());
        }
    }
    Ok(files)
}

/// Whether a name has the form `.NAME.PROCESS.tmp`.
fn is_temporary(name: &str) -> bool {
    let inner = name.strip_prefix('.').and_then(|rest| rest.strip_suffix(".tmp"));
    let process = inner.and_then(|inner| inner.rsplit_once('.')).map(|(_, process)| process);
    process.is_some_and(|p| !p.is_empty() && p.bytes().all(|byte| byte.is_ascii_digit()))
}

/// Whether the writer of a temporary file is gone: it holds a lock, and loses it when killed.
fn is_abandoned(path: &Path) -> bool {
    fs::File::open(path).is_ok_and(|file| file.try_lock().is_ok())
}

/// Writes warnings to standard error, a line each.
pub(crate) fn warn(notes: &[String]) {
    for note in notes {
        tracing::warn!("{}", harmless(note));
    }
}

/// Standard error that may be full or closed: errors are ignored.
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
    /// Names in lower case, as many file systems ignore case; with the last number of each.
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
