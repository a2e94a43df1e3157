//! Errors on their way to Python; their classes are in `gobo_shadows/errors.py`.
use gobo::Error;
use gobo_scene::SceneError;
use pyo3::{PyErr, PyResult, Python, types::PyAnyMethods as _};
use std::path::Path;

/// An error, without Python's part.
#[derive(Debug)]
pub(crate) enum Fault {
    /// Error of a file.
    Scene(SceneError),
    /// Error of a device, or of a request to it.
    Library(Error),
    /// Error of an array or a table.
    Input { message: String, remedy: String },
    /// The host cannot allocate this much memory [bytes].
    Memory(u64),
    /// Error of the process: the problem and the remedy.
    Process(&'static str, &'static str),
    /// A bug; the message of its panic was printed.
    Panicked,
    /// The call was interrupted: nobody waits for its result.
    Stopped,
    /// Exception of the caller's own function.
    Raised(PyErr),
}

impl From<SceneError> for Fault {
    fn from(error: SceneError) -> Self {
        Self::Scene(error)
    }
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        Self::Library(error)
    }
}

impl Fault {
    pub(crate) fn input(message: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Input { message: message.into(), remedy: remedy.into() }
    }

    pub(crate) fn not_contiguous(name: &str) -> Self {
        Self::input(format!("{name} is not contiguous"), "pass numpy.ascontiguousarray of it")
    }

    pub(crate) fn raised(self, py: Python<'_>) -> PyErr {
        self.error(py).unwrap_or_else(|error| error)
    }

    fn error(self, py: Python<'_>) -> PyResult<PyErr> {
        let raised = |class: &str, message: String, remedy: Option<String>| {
            let class = py.import("gobo_shadows.errors")?.getattr(class)?;
            Ok(PyErr::from_value(class.call1((message, remedy))?))
        };
        match self {
            Self::Input { message, remedy } => raised("InputError", message, Some(remedy)),
            Self::Memory(bytes) => {
                let message = format!("no memory for {} MiB", bytes >> 20);
                let remedy = "use a smaller shadow size, fewer lights, points or pixels";
                raised("OutOfMemoryError", message, Some(remedy.to_owned()))
            }
            Self::Process(message, remedy) => {
                raised("GoboError", message.to_owned(), Some(remedy.to_owned()))
            }
            Self::Panicked => {
                let message = "a bug of gobo_shadows: its message is on standard error";
                raised("GoboError", message.to_owned(), Some("report it, please".to_owned()))
            }
            Self::Raised(error) => Ok(error),
            Self::Stopped => raised("GoboError", "interrupted".to_owned(), None),
            Self::Scene(error) => {
                let class = match error {
                    SceneError::Memory { .. } => "OutOfMemoryError",
                    _ => "SceneError",
                };
                let raised = raised(class, error.to_string(), error.help().map(str::to_owned))?;
                let value = raised.value(py);
                match &error {
                    SceneError::Document { path, line, column, .. } => {
                        value.setattr("path", text(path))?;
                        value.setattr("line", *line)?;
                        value.setattr("column", *column)?;
                    }
                    SceneError::Read { path, .. } | SceneError::Invalid { path, .. } => {
                        value.setattr("path", text(path))?;
                    }
                    _ => {}
                }
                Ok(raised)
            }
            Self::Library(error) => {
                let (class, remedy) = class_of(&error);
                raised(class, error.to_string(), remedy.map(str::to_owned))
            }
        }
    }
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

/// Python's class of an error, and the remedy that its message lacks.
fn class_of(error: &Error) -> (&'static str, Option<&'static str>) {
    const ON_CPU: Option<&str> = Some("use_adapter(\"cpu\") renders without a GPU");
    match error {
        Error::Adapter { .. }
        | Error::Unusable(_)
        | Error::Lacks(_)
        | Error::Device { .. }
        | Error::Limit { .. }
        | Error::Unsupported { .. } => ("AdapterError", ON_CPU),
        Error::Light(_) | Error::Clip(_) | Error::Invalid { .. } => ("InputError", None),
        Error::Memory(_) => ("OutOfMemoryError", ON_CPU),
        Error::Lost(_) => ("DeviceError", Some("ask less of it, or use_adapter(\"cpu\")")),
        _ => ("DeviceError", None),
    }
}
