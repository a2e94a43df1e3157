//! How far long work is, and its end before it is done.
use gobo::Error;
use std::{fmt, ops::ControlFlow};

/// Function that long work calls between its parts, with the share that is done, 0 to 1. `Break` ends the
/// work with [`Error::Stopped`]; the renderer can be used again.
#[derive(Clone, Copy)]
pub struct Watch<'a>(pub &'a (dyn Fn(f32) -> ControlFlow<()> + Sync + 'a));

impl fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Watch").finish_non_exhaustive()
    }
}

/// Tells `watch` that `done` of `all` parts are done.
pub(crate) fn tell(watch: Option<Watch<'_>>, done: u32, all: u32) -> Result<(), Error> {
    match watch.map(|watch| (watch.0)(done as f32 / all as f32)) {
        Some(ControlFlow::Break(())) => Err(Error::Stopped),
        _ => Ok(()),
    }
}
