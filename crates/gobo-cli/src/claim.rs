//! Claims: of all processes that share a folder, only one at a time writes the files of a name.
use super::{failure::Failure, stop};
use same_file::Handle;
use std::{
    fs::{self, File, TryLockError},
    io,
    path::{Path, PathBuf},
    time::Duration,
};

/// Time between two attempts at a claim that another process holds.
pub(super) const PAUSE: Duration = Duration::from_millis(20);

/// A lock on `.NAME.lock`. The system releases it when its holder is killed.
#[derive(Debug)]
pub(super) struct Claim {
    path: PathBuf,
    /// Held until dropped.
    lock: Lock,
    /// Dropped after the file is removed.
    _swept: stop::Swept,
}

#[derive(Debug)]
enum Lock {
    Held {
        _file: Handle,
    },
    /// The file system has no locks.
    Unknown {
        _file: File,
    },
}

impl Claim {
    /// Whether the claim's file exists, held or not.
    pub(super) fn is_left(dir: &Path, name: &str) -> bool {
        path(dir, name).exists()
    }

    /// `None` while another process holds it.
    pub(super) fn attempt(dir: &Path, name: &str) -> Result<Option<Self>, Failure> {
        let path = path(dir, name);
        match stop::swept(|| Lock::attempt(&path).map(|lock| (lock, path.clone()))) {
            Ok((lock, _swept)) => Ok(Some(Self { path, lock, _swept })),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(None),
            Err(error) => Err(Failure::file(&path, error)),
        }
    }

    /// Removes temporary files that killed holders of this claim left behind.
    pub(super) fn sweep(&self, strays: impl IntoIterator<Item = PathBuf>) {
        if matches!(self.lock, Lock::Held { .. }) {
            for stray in strays {
                // A file that cannot be removed is no error of this run.
                let _ = fs::remove_file(stray);
            }
        }
    }
}

impl Lock {
    /// `WouldBlock` while another process holds it.
    fn attempt(path: &Path) -> io::Result<Self> {
        loop {
            let mut options = File::options();
            let file = options.read(true).write(true).create(true).truncate(false).open(path)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(io::ErrorKind::WouldBlock.into()),
                Err(TryLockError::Error(error)) => {
                    tracing::debug!("{}: {error}", path.display());
                    return Ok(Self::Unknown { _file: file });
                }
            }
            let held = Handle::from_file(file)?;
            // Otherwise its last holder removed it after this process opened it.
            if Handle::from_path(path).is_ok_and(|named| named == held) {
                return Ok(Self::Held { _file: held });
            }
        }
    }
}

fn path(dir: &Path, name: &str) -> PathBuf {
    dir.join(format!(".{name}.lock"))
}

impl Drop for Claim {
    /// Removes the file while the lock is held: a process that opens it later makes a new one.
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}
