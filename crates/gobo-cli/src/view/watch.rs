//! Changes of the files that the scene was read from.
use crate::inputs;
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant, SystemTime},
};

/// Time between two looks: a change is complete once it has stopped for as long.
pub(super) const PERIOD: Duration = Duration::from_millis(250);

/// Time of the last change, and length; `None` if the file does not exist.
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

/// Looks at the files periodically.
#[derive(Debug)]
pub(super) struct Watch {
    last: Instant,
    /// Stamps at the last look, if they differ from those of the reading.
    pending: Option<FileStamps>,
}

impl Watch {
    /// Watches files that are read from now on.
    pub(super) fn new() -> Self {
        noted().clear();
        Self { last: Instant::now(), pending: None }
    }

    /// Whether a file has changed and has then stayed the same for a period. True once for each change.
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
