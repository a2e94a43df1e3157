//! Stopping by signals, and an abort's status.
use super::failure::Failure;
use std::{
    collections::BTreeSet,
    fs, io,
    path::PathBuf,
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

static STOPPED: AtomicBool = AtomicBool::new(false);
/// Whether the command looks at [`is_stopped`].
static IS_JOB: AtomicBool = AtomicBool::new(false);
/// Files that are removed where a signal ends the program.
static TEMPORARIES: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn temporaries() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    TEMPORARIES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A temporary file that a signal removes. Whoever makes it removes it otherwise, before this is dropped.
#[derive(Debug)]
pub(super) struct Swept(PathBuf);

/// Makes a temporary file: no signal comes between its making and its entry.
pub(super) fn swept<T>(make: impl FnOnce() -> io::Result<(T, PathBuf)>) -> io::Result<(T, Swept)> {
    let mut temporaries = temporaries();
    let (made, path) = make()?;
    temporaries.insert(path.clone());
    Ok((made, Swept(path)))
}

impl Drop for Swept {
    fn drop(&mut self) {
        temporaries().remove(&self.0);
    }
}

/// Listens for SIGINT, SIGTERM and SIGHUP, and their equivalents elsewhere: they end the program at once and
/// leave no temporary files, but a job's first one, which the job ends by after the present frame.
pub(super) fn listen() -> Result<(), Failure> {
    handle(|| {
        if STOPPED.swap(true, Ordering::Relaxed) || !IS_JOB.load(Ordering::Relaxed) {
            // Held until the end: nothing is made any more.
            let temporaries = temporaries();
            for path in &*temporaries {
                let _ = fs::remove_file(path);
            }
            exit();
        }
    })
    .map_err(|error| Failure::Wrong(format!("cannot listen for signals: {error}")))
}

/// Says that the command ends by itself once it [`is_stopped`].
pub(super) fn begin_job() {
    IS_JOB.store(true, Ordering::Relaxed);
}

pub(super) fn is_stopped() -> bool {
    STOPPED.load(Ordering::Relaxed)
}

#[cfg(unix)]
fn handle(stop: impl Fn() + Send + 'static) -> io::Result<()> {
    use signal_hook::{consts, iterator::Signals};
    let ignored = ignored();
    let signals = [consts::SIGINT, consts::SIGTERM, consts::SIGHUP];
    // What `nohup` and shells without jobs ignore stays so.
    let heeded = signals.into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
    let mut signals = Signals::new(heeded)?;
    std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        for _ in signals.forever() {
            stop();
        }
    })?;
    Ok(())
}

/// Signals that the program was started to ignore, a bit each from the first, where the system says so.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    line.and_then(|bits| u64::from_str_radix(bits.trim(), 16).ok()).unwrap_or(0)
}

/// Without the exit handlers of drivers, whose threads still work.
#[cfg(unix)]
fn exit() -> ! {
    signal_hook::low_level::exit(1)
}

#[cfg(not(unix))]
fn handle(stop: impl FnMut() + Send + 'static) -> io::Result<()> {
    ctrlc::set_handler(stop).map_err(io::Error::other)
}

#[cfg(not(unix))]
fn exit() -> ! {
    std::process::exit(1)
}

/// Gives an abort the status of other failures. An allocation that fails aborts the program after a message:
/// commands ask for memory first, but not for what libraries and drivers allocate.
#[cfg(unix)]
pub(crate) fn give_aborts_a_status() {
    use signal_hook::{consts::SIGABRT, flag::register_conditional_shutdown};
    let always = std::sync::Arc::new(AtomicBool::new(true));
    if let Err(error) = register_conditional_shutdown(SIGABRT, 1, always) {
        tracing::debug!("aborts keep their status: {error}");
    }
}

#[cfg(not(unix))]
pub(crate) fn give_aborts_a_status() {}

/// Says nothing of panics of decoders, which are errors of the files that they read.
pub(crate) fn hush_decoders() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        const CAUGHT: [&str; 5] = ["basisu", "e57-", "exr-", "laz-", "tobj-"];
        let is_caught = |file: &str| CAUGHT.iter().any(|name| file.contains(name));
        if !panic.location().is_some_and(|place| is_caught(place.file())) {
            usual(panic);
        }
    }));
}
