//! A job that is asked to stop ends after the frame that it is at.
use super::failure::Failure;
use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// Listens for SIGINT, SIGTERM and SIGHUP, and for their like elsewhere. Whoever asks twice does not
/// wait for the frame.
pub(super) fn listen() -> Result<(), Failure> {
    let asked = || {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(1);
        }
    };
    ctrlc::set_handler(asked)
        .map_err(|error| Failure::Wrong(format!("cannot listen for signals: {error}")))
}

pub(super) fn is_asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
