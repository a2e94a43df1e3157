//! Stopping by signals: a job ends after the present frame.
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
