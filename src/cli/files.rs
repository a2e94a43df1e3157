//! Files that are written whole or not at all, and standard output that may be closed.
use super::failure::Failure;
use std::{
    ffi::OsString,
    fs,
    io::{self, Write as _},
    path::Path,
};

/// The file appears complete under its name, or is not touched.
pub(crate) fn write(path: &Path, contents: &[u8]) -> Result<(), Failure> {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.tmp", std::process::id()));
    let temporary = path.with_file_name(name);
    fs::write(&temporary, contents).and_then(|()| fs::rename(&temporary, path)).map_err(|source| {
        // What is left of it is of no use; that it may not exist is fine.
        let _ = fs::remove_file(&temporary);
        Failure::file(path, source)
    })
}

pub(crate) fn create_dir(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path).map_err(|source| Failure::file(path, source))
}

/// One result on standard output.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    match writeln!(io::stdout().lock(), "{text}") {
        // Whoever read has seen enough.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => result.map_err(Failure::Output),
    }
}

/// `name`, or `name` with a number where it is in `taken`; no case is told apart, as on many file
/// systems.
pub(crate) fn unique(name: &str, taken: &[String]) -> String {
    let is_free = |name: &String| !taken.iter().any(|other| other.eq_ignore_ascii_case(name));
    std::iter::once(name.to_owned())
        .chain((2..).map(|number| format!("{name}_{number}")))
        .find(is_free)
        .expect("numbers do not end")
}
