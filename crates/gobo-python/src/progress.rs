//! The function of a caller that hears how far its picture is.
use crate::{fault::Fault, job::Stop};
use pyo3::{Py, PyAny, PyErr, Python};
use std::{
    ops::ControlFlow,
    sync::{Mutex, PoisonError},
};

/// Function of Python, and the exception that it raised.
pub(crate) struct Progress {
    function: Option<Py<PyAny>>,
    raised: Mutex<Option<PyErr>>,
}

impl Progress {
    pub(crate) fn new(function: Option<Py<PyAny>>) -> Self {
        Self { function, raised: Mutex::new(None) }
    }

    /// Tells the share that is done. The work ends if the function raises an exception or nobody waits any
    /// more.
    pub(crate) fn tell(&self, stop: &Stop, share: f32) -> ControlFlow<()> {
        if stop.is_asked() {
            return ControlFlow::Break(());
        }
        let Some(function) = &self.function else { return ControlFlow::Continue(()) };
        match Python::attach(|py| function.call1(py, (share,))) {
            Ok(_) => ControlFlow::Continue(()),
            Err(error) => {
                *self.raised.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
                ControlFlow::Break(())
            }
        }
    }

    /// Exception of the function, if it raised one, instead of the fault that followed.
    pub(crate) fn cause_of(&self, fault: Fault) -> Fault {
        let raised = self.raised.lock().unwrap_or_else(PoisonError::into_inner).take();
        raised.map_or(fault, Fault::Raised)
    }
}
