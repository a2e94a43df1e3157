//! Files that the scene was read from: whether one has changed since.
use crate::inputs;
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant, SystemTime},
};

/// Time between two looks: a change that has not gone on for so long is complete.
pub(super) const PERIOD: Duration = Duration::from_millis(250);

/// Time of the last change and length; `None` if the file is not there.
type Stamp = Option<(SystemTime, u64)>;
type FileStamps = BTreeMap<PathBuf, Stamp>;

static NOTED: Mutex<FileStamps> = Mutex::new(BTreeMap::new());

fn noted() -> MutexGuard<'static, FileStamps> {
    NOTED.lock().unwrap_or_else(PoisonError::into_inner)
}

fn stamp(path: &Path) -> Stamp {
    let metadata = fs::metadata(path).ok()?;
    Some((metadata.modified().ok()?, metadata.len()))
}

/// Called with each file before a scene reads it.
pub(super) fn note(path: &Path) {
    inputs::add(path);
    noted().insert(path.to_owned(), stamp(path));
}

/// Looks at the files now and then.
#[derive(Debug)]
pub(super) struct Watch {
    last: Instant,
    /// What the last look saw, if it differs from what was read.
    pending: Option<FileStamps>,
}

impl Watch {
    /// For files that are read from now on.
    pub(super) fn new() -> Self {
        noted().clear();
        Self { last: Instant::now(), pending: None }
    }

    /// Whether a file has changed, and then stayed for a period. Says so once for each change.
    pub(super) fn has_changed(&mut self) -> bool {
        if self.last.elapsed() < PERIOD {
            return false;
        }
        self.last = Instant::now();
        let mut noted = noted();
        let now: FileStamps = noted.keys().map(|path| (path.clone(), stamp(path))).collect();
        if now == *noted {
            self.pending = None;
            return false;
        }
        let stays = self.pending.as_ref() == Some(&now);
        if stays {
            *noted = now;
            self.pending = None;
        } else {
            self.pending = Some(now);
        }
        stays
    }
}
