//! Stops by signals, and the exit status of aborts.
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
/// Whether the command polls [`is_stopped`].
static IS_JOB: AtomicBool = AtomicBool::new(false);
/// Files that are removed when a signal ends the program.
static TEMPORARIES: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn temporaries() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    TEMPORARIES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A temporary file that a signal removes. Otherwise its maker removes it, before this is dropped.
#[derive(Debug)]
pub(super) struct Swept(PathBuf);

/// Makes a temporary file: no signal comes between its creation and its registration.
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

/// Listens for SIGINT, SIGTERM and SIGHUP, and their equivalents elsewhere. They end the program at once and
/// remove its temporary files; only the first one during a job lets the present frame finish.
pub(super) fn listen() -> Result<(), Failure> {
    handle(|| {
        if STOPPED.swap(true, Ordering::Relaxed) || !IS_JOB.load(Ordering::Relaxed) {
            // Held until the end, so that no further file is made.
            let temporaries = temporaries();
            for path in &*temporaries {
                let _ = fs::remove_file(path);
            }
            exit();
        }
    })
    .map_err(|error| Failure::Wrong(format!("cannot listen for signals: {error}")))
}

/// Declares that the command ends by itself once it [`is_stopped`].
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
    // Signals that `nohup`, or a shell without job control, made ignored stay ignored.
    let heeded = signals.into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
    let mut signals = Signals::new(heeded)?;
    std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        for _ in signals.forever() {
            stop();
        }
    })?;
    Ok(())
}

/// Signals that the program was started to ignore, a bit each from the first, if the system tells.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    line.and_then(|bits| u64::from_str_radix(bits.trim(), 16).ok()).unwrap_or(0)
}

/// Exits without the exit handlers of drivers, whose threads are still running.
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

/// Gives aborts the exit status of other failures. A failed allocation aborts the program after a message:
/// commands probe their own memory first, but not that of libraries and drivers.
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

/// Suppresses the messages of panics in decoders, which are reported as errors of their files.
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
