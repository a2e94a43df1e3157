//! Long calls run on a thread of their own, while the caller's thread waits without the interpreter's lock
//! and handles signals.
use crate::fault::Fault;
use pyo3::{PyResult, Python};
use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
        mpsc::{RecvTimeoutError, sync_channel},
    },
    time::Duration,
};

/// Longest delay of a signal.
const PAUSE: Duration = Duration::from_millis(50);

/// Whether the caller has stopped waiting.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Whether nobody waits any more.
    pub(crate) fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// An error once nobody waits any more.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        if self.is_asked() { Err(Fault::Stopped) } else { Ok(()) }
    }
}

/// Number of running jobs.
static RUNNING: Mutex<usize> = Mutex::new(0);
static ENDED: Condvar = Condvar::new();

fn running() -> MutexGuard<'static, usize> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether some call has made threads, and whether this process has lost them.
static USED: AtomicBool = AtomicBool::new(false);
static FORKED: AtomicBool = AtomicBool::new(false);

/// Marks this process as a forked copy, without its parent's threads.
pub(crate) fn forked() {
    FORKED.store(USED.load(Ordering::Relaxed), Ordering::Relaxed);
}

/// Whether threads and devices are those of another process.
pub(crate) fn is_forked() -> bool {
    FORKED.load(Ordering::Relaxed)
}

/// Counts a job until it is dropped.
struct Running;

impl Running {
    fn begin() -> Self {
        *running() += 1;
        Self
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        *running() -= 1;
        ENDED.notify_all();
    }
}

/// Returns the result of `work`. An exception of a signal's handler, such as `KeyboardInterrupt`, is raised
/// at once; the work ends at its next check of [`Stop`], or by itself.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Stop) -> Result<T, Fault> + Send + 'static,
) -> PyResult<T> {
    if is_forked() {
        let remedy = "start processes by multiprocessing.get_context(\"spawn\")";
        let message = "this process was forked from one that had used gobo_shadows";
        return Err(Fault::Process(message, remedy).raised(py));
    }
    USED.store(true, Ordering::Relaxed);
    let stop = Stop::default();
    let (sender, receiver) = sync_channel(1);
    let (ended, job) = (stop.clone(), Running::begin());
    let thread = std::thread::Builder::new().name("gobo".to_owned());
    let spawned = thread.spawn(move || {
        let result = catch_unwind(AssertUnwindSafe(|| work(&ended)));
        // Nobody receives it if the call was interrupted.
        let _ = sender.send(result.unwrap_or(Err(Fault::Panicked)));
        drop(job);
    });
    if let Err(error) = spawned {
        let message = format!("no thread could be started: {error}");
        return Err(Fault::input(message, "end other threads").raised(py));
    }
    // Only one thread may use a channel's end; the mutex shows the compiler that this is so.
    let receiver = Mutex::new(receiver);
    loop {
        let received = py
            .detach(|| receiver.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(PAUSE));
        match received {
            Ok(result) => return result.map_err(|fault| fault.raised(py)),
            Err(RecvTimeoutError::Timeout) => {
                if let Err(error) = py.check_signals() {
                    stop.0.store(true, Ordering::Relaxed);
                    return Err(error);
                }
            }
            Err(RecvTimeoutError::Disconnected) => return Err(Fault::Panicked.raised(py)),
        }
    }
}

/// Waits until no job is at work.
pub(crate) fn wait_for_all() {
    let mut count = running();
    while *count > 0 {
        count = ENDED.wait(count).unwrap_or_else(PoisonError::into_inner);
    }
}
