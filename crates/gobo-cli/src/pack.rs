//! `gobo pack`: a scene and all files that it names, in one archive.
use super::{
    failure::Failure,
    files, inputs,
    output::{self, Output},
};
use gobo_scene as scene;
use std::{
    fs::File,
    io,
    path::{Component, Path, PathBuf},
};
use zip::{CompressionMethod, DateTime, ZipWriter, write::SimpleFileOptions};

/// Writes the archive; the scene's file is its first entry. Names are relative to the closest folder around
/// all files, so that the unpacked scene finds them.
pub(crate) fn run(path: &Path, out: &Path) -> Result<(), Failure> {
    scene::check(path)?;
    let all = scene::files(path)?;
    all.iter().for_each(|file| inputs::add(file));
    let pending = Output::new(out)?;
    let failed = |source| Failure::file(out, source);
    let mut archive = ZipWriter::new(pending.writer().map_err(failed)?);
    for (file, name) in all.iter().zip(names(&all)?) {
        let mut from = File::open(file).map_err(|source| Failure::file(file, source))?;
        let length = from.metadata().map_err(|source| Failure::file(file, source))?.len();
        // The archive has the same bytes whenever it is packed.
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(DateTime::default())
            .large_file(length >= u64::from(u32::MAX));
        let started = archive.start_file(name, options).map_err(io::Error::from);
        started.and_then(|()| io::copy(&mut from, &mut archive).map(|_| ())).map_err(failed)?;
    }
    archive.finish().map_err(|error| failed(error.into()))?;
    pending.finish()?;
    output::print_name(out)
}

/// Paths relative to the closest folder around all files, with `/`.
fn names(all: &[PathBuf]) -> Result<Vec<String>, Failure> {
    let plain: Vec<PathBuf> =
        all.iter().map(|file| without_parents(file)).collect::<Result<_, _>>()?;
    let mut root = files::folder(&plain[0]);
    while let Some(parent) = root.parent()
        && !plain.iter().all(|file| file.starts_with(root))
    {
        root = parent;
    }
    let name = |file: &PathBuf| {
        let parts = file.strip_prefix(root).unwrap_or(file).components();
        let parts = parts.map(|part| part.as_os_str().to_str());
        let parts: Option<Vec<_>> = parts.collect();
        parts
            .map(|parts| parts.join("/"))
            .ok_or_else(|| Failure::refused(file, "the name is not UTF-8", "rename the file"))
    };
    plain.iter().map(name).collect()
}

/// The absolute path without `..`.
fn without_parents(file: &Path) -> Result<PathBuf, Failure> {
    let absolute = std::path::absolute(file).map_err(|source| Failure::file(file, source))?;
    let mut plain = PathBuf::new();
    for part in absolute.components() {
        if part == Component::ParentDir {
            plain.pop();
        } else {
            plain.push(part);
        }
    }
    Ok(plain)
}
