//! Stopping by signals: a job ends after the present frame, an abort with a status.
use super::failure::Failure;
use std::sync::atomic::{AtomicBool, Ordering};

static STOPPED: AtomicBool = AtomicBool::new(false);

/// Listens for SIGINT, SIGTERM and SIGHUP, and their equivalents elsewhere. A second signal ends the
/// program at once.
pub(super) fn listen() -> Result<(), Failure> {
    let stop = || {
        if STOPPED.swap(true, Ordering::Relaxed) {
            std::process::exit(1);
        }
    };
    ctrlc::set_handler(stop)
        .map_err(|error| Failure::Wrong(format!("cannot listen for signals: {error}")))
}

pub(super) fn is_stopped() -> bool {
    STOPPED.load(Ordering::Relaxed)
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
