//! Outputs of commands. A regular file is replaced as a whole, devices and pipes are written into, and files
//! that the command reads are refused. A link stands for its target.
use super::{claim, failure::Failure, files, inputs, stop};
use std::{
    ffi::OsString,
    fs,
    io::{self, Seek as _, Write as _},
    path::{Path, PathBuf},
};
use tempfile::NamedTempFile;

/// Suffix of temporary names.
pub(super) const TEMPORARY: &str = ".tmp";

/// Longest chain of links.
const MOST_LINKS: usize = 40;

/// An output in progress: it appears complete under its name, or not at all. Its temporary name is unique
/// among all processes and machines.
#[derive(Debug)]
pub(crate) struct Output {
    path: PathBuf,
    place: Place,
    file: NamedTempFile,
    /// Dropped after the file.
    _swept: stop::Swept,
}

/// Kind of an output's target.
#[derive(Debug)]
enum Place {
    /// A regular file or nothing yet, by the name at the end of all links.
    File(PathBuf),
    /// A device or a pipe.
    Stream,
}

impl Place {
    fn of(path: &Path) -> Result<Self, Failure> {
        let refused = |message| Err(Failure::refused(path, message, "name a file to write"));
        match fs::metadata(path) {
            Ok(metadata) if metadata.is_file() => {
                inputs::check(path, &metadata)?;
                Ok(Self::File(behind_links(path)))
            }
            Ok(metadata) if metadata.is_dir() => {
                Err(Failure::file(path, io::ErrorKind::IsADirectory.into()))
            }
            Ok(metadata) if is_stream(&metadata) => Ok(Self::Stream),
            Ok(_) => refused("is no file, device or pipe"),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let target = behind_links(path);
                match fs::metadata(files::folder(&target)) {
                    Ok(_) => Ok(Self::File(target)),
                    Err(error) => Err(Failure::file(path, error)),
                }
            }
            Err(error) => Err(Failure::file(path, error)),
        }
    }
}

#[cfg(unix)]
fn is_stream(metadata: &fs::Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    let kind = metadata.file_type();
    kind.is_fifo() || kind.is_char_device() || kind.is_block_device()
}

#[cfg(not(unix))]
fn is_stream(_metadata: &fs::Metadata) -> bool {
    true
}

/// The name at the end of a chain of links, even if nothing is there.
fn behind_links(path: &Path) -> PathBuf {
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(target) = fs::read_link(&path) else { break };
        path = files::folder(&path).join(target);
    }
    path
}

impl Output {
    /// Refuses a name that cannot be written, before the work is done.
    pub(crate) fn check(path: &Path) -> Result<(), Failure> {
        Place::of(path).map(|_| ())
    }

    /// Whether the name is that of a device or a pipe.
    pub(crate) fn is_stream(path: &Path) -> Result<bool, Failure> {
        Ok(matches!(Place::of(path)?, Place::Stream))
    }

    pub(crate) fn new(path: &Path) -> Result<Self, Failure> {
        let place = Place::of(path)?;
        let folder = match &place {
            Place::File(target) => files::folder(target).to_owned(),
            Place::Stream => std::env::temp_dir(),
        };
        let mut prefix = OsString::from(".");
        prefix.push(path.file_name().unwrap_or_default());
        prefix.push(".");
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(TEMPORARY);
        // The user's umask decides who else may read it.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let (file, swept) = stop::swept(|| {
            let file = builder.tempfile_in(folder)?;
            let path = file.path().to_owned();
            Ok((file, path))
        })
        .map_err(|source| Failure::file(path, source))?;
        Ok(Self { path: path.to_owned(), place, file, _swept: swept })
    }

    /// Its final name.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Its temporary name.
    pub(crate) fn temporary(&self) -> &Path {
        self.file.path()
    }

    /// Writer of its contents.
    pub(crate) fn writer(&self) -> io::Result<fs::File> {
        self.file.as_file().try_clone()
    }

    /// Gives a file its final name, or sends the contents to the device or pipe.
    pub(crate) fn finish(self) -> Result<(), Failure> {
        let Self { path, place, file, _swept } = self;
        match place {
            Place::File(target) => {
                file.persist(target).map_err(|error| Failure::file(&path, error.error))?;
                Ok(())
            }
            Place::Stream => {
                let mut stream = opened(&path)?;
                let mut from = file.as_file();
                let sent = from
                    .rewind()
                    .and_then(|()| io::copy(&mut from, &mut stream))
                    .and_then(|_| stream.flush());
                sent.map_err(|source| Failure::file(&path, source))
            }
        }
    }
}

/// Opens a device or a pipe; a named pipe once it has a reader.
#[cfg(unix)]
fn opened(path: &Path) -> Result<fs::File, Failure> {
    use std::os::unix::fs::OpenOptionsExt as _;
    let failed = |source| Failure::file(path, source);
    loop {
        let mut options = fs::File::options();
        match options.write(true).custom_flags(libc::O_NONBLOCK).open(path) {
            // While this is open the pipe has a reader, so a plain pipe opens at once.
            Ok(_reads) => return fs::File::options().write(true).open(path).map_err(failed),
            Err(error) if error.raw_os_error() == Some(libc::ENXIO) => {
                if stop::is_stopped() {
                    return Err(failed(io::Error::other("stopped before anyone read the pipe")));
                }
                std::thread::sleep(claim::PAUSE);
            }
            Err(error) => return Err(failed(error)),
        }
    }
}

#[cfg(not(unix))]
fn opened(path: &Path) -> Result<fs::File, Failure> {
    fs::File::options().write(true).open(path).map_err(|source| Failure::file(path, source))
}

/// Writes an output's contents, in pieces that are not small.
pub(crate) type Fill<'a> = &'a mut dyn FnMut(&mut dyn io::Write) -> io::Result<()>;

/// Writes an output.
pub(crate) fn write(path: &Path, contents: &[u8]) -> Result<(), Failure> {
    fill(path, &mut |out| out.write_all(contents))
}

/// Like [`write()`], with the contents on the disk before the name is.
pub(crate) fn write_synced(path: &Path, contents: &[u8]) -> Result<(), Failure> {
    fill_synced(path, &mut |out| out.write_all(contents))
}

/// Like [`write()`], for contents that are not in memory at once.
pub(crate) fn fill(path: &Path, contents: Fill<'_>) -> Result<(), Failure> {
    put(path, contents, |_| Ok(()))
}

/// Like [`write_synced()`], for contents that are not in memory at once.
pub(crate) fn fill_synced(path: &Path, contents: Fill<'_>) -> Result<(), Failure> {
    put(path, contents, fs::File::sync_all)
}

fn put(
    path: &Path,
    contents: Fill<'_>,
    sync: impl Fn(&fs::File) -> io::Result<()>,
) -> Result<(), Failure> {
    let mut output = Output::new(path)?;
    let file = output.file.as_file_mut();
    let written = contents(file).and_then(|()| sync(file));
    written.map_err(|source| Failure::file(path, source))?;
    output.finish()
}

/// Prints the name of an output, unless the output itself went to standard output.
pub(crate) fn print_name(path: &Path) -> Result<(), Failure> {
    let is_printed = || {
        let printed = inputs::Identity::of(Path::new("/dev/fd/1")).ok()?;
        Some(printed == inputs::Identity::of(path).ok()?)
    };
    if cfg!(unix) && is_printed() == Some(true) {
        return Ok(());
    }
    files::print(&path.display().to_string())
}
