//! Errors of commands, and exit status.
use gobo_scene::SceneError;
use std::{
    io::Write as _,
    path::{Path, PathBuf},
};

#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Gpu(#[from] gobo::Error),
    #[error("{}: {source}", .path.display())]
    File { path: PathBuf, source: std::io::Error },
    #[error("{0}")]
    Usage(String),
    /// A file that does not suit an option.
    #[error("{}: {message}", .path.display())]
    Refused { path: PathBuf, message: String, help: &'static str },
    /// A benchmark whose maps are wrong.
    #[error("{0}")]
    Wrong(String),
    /// The host cannot allocate so much memory [bytes].
    #[error("no memory for {} MiB of shadow maps, casters, pixels and points", .0 >> 20)]
    Memory(u64),
    /// No window can be opened.
    #[error("no window can be opened: {0}")]
    #[cfg(feature = "view")]
    Window(String),
    /// Stopped by a signal before this frame.
    #[error("stopped before frame {frame}")]
    Stopped { frame: u32 },
    #[error("standard output: {0}")]
    Output(std::io::Error),
}

impl Failure {
    pub(crate) fn file(path: &Path, source: std::io::Error) -> Self {
        Self::File { path: path.to_owned(), source }
    }

    pub(crate) fn refused(path: &Path, message: impl Into<String>, help: &'static str) -> Self {
        Self::Refused { path: path.to_owned(), message: message.into(), help }
    }

    /// Prints the error to stderr, for a scene file with the line and the remedy. Errors of stderr itself
    /// (full or closed) are ignored.
    pub(crate) fn print(&self) {
        let text = format!("gobo: {}", self.explained());
        let _ = std::io::stderr().lock().write_all(text.as_bytes());
    }

    /// The error, with the place and the remedy.
    pub(crate) fn explained(&self) -> String {
        let mut text = harmless(&self.to_string()) + "\n";
        if let Some(remedy) = self.remedy() {
            text += &format!("  help: {remedy}\n");
        }
        if let Self::Scene(error) = self {
            if let SceneError::Document { line, excerpt, marked, .. } = error {
                let number = line.to_string();
                let margin = " ".repeat(number.len());
                let before = " ".repeat(marked.start);
                let mark = "^".repeat(marked.len().max(1));
                text +=
                    &format!(" {margin} |\n {number} | {excerpt}\n {margin} | {before}{mark}\n");
            }
            if let Some(help) = error.help() {
                text += &format!("  help: {help}\n");
            }
        }
        text
    }

    /// Remedy on the command line.
    fn remedy(&self) -> Option<&'static str> {
        use gobo::Error;
        match self {
            Self::Gpu(Error::Adapter { found, .. }) if !found.is_empty() => {
                Some("`gobo info` lists the adapters; --backend cpu renders without one")
            }
            Self::Gpu(
                Error::Adapter { .. }
                | Error::Unusable(_)
                | Error::Device { .. }
                | Error::Limit { .. }
                | Error::Unsupported { .. },
            ) => Some("--backend cpu renders without a GPU"),
            Self::Gpu(Error::Memory(_)) => {
                Some("--set shadow.size=512 takes less memory, --backend cpu none of the GPU's")
            }
            Self::Gpu(Error::Lost(_)) => {
                Some("--set shadow.size=512 asks less of it, --backend cpu renders without a GPU")
            }
            Self::Memory(_) => {
                Some("--set shadow.size=512 takes less, as do fewer lights and pixels")
            }
            Self::Refused { help, .. } => Some(help),
            #[cfg(feature = "view")]
            Self::Window(_) => Some(
                "a desktop is needed: DISPLAY or WAYLAND_DISPLAY names it on Linux; `gobo render` needs none",
            ),
            Self::Stopped { .. } => Some(
                "the same command with --skip-existing goes on, where it was given from the start",
            ),
            _ => None,
        }
    }

    /// Exit status: 2 for bad usage or input, 3 without a usable adapter or device, 1 for anything else.
    pub(crate) fn status(&self) -> u8 {
        use gobo::Error;
        match self {
            Self::Scene(SceneError::Memory { .. }) => 1,
            Self::Scene(_) | Self::Usage(_) | Self::Refused { .. } => 2,
            Self::Gpu(
                Error::Adapter { .. }
                | Error::Unusable(_)
                | Error::Device { .. }
                | Error::Limit { .. }
                | Error::Unsupported { .. },
            ) => 3,
            #[cfg(feature = "view")]
            Self::Window(_) => 3,
            Self::Gpu(_)
            | Self::File { .. }
            | Self::Memory(_)
            | Self::Wrong(_)
            | Self::Stopped { .. }
            | Self::Output(_) => 1,
        }
    }
}

/// The text without control characters, which could affect a terminal.
pub(crate) fn harmless(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() && c != '\n' {
            shown.extend(c.escape_unicode());
        } else {
            shown.push(c);
        }
    }
    shown
}
