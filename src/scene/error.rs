//! What is wrong with a scene, where, and what to do.
use std::path::PathBuf;

/// Why a scene could not be loaded.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum SceneError {
    #[error("{}: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    /// A value in a scene file.
    #[error("{message}")]
    Document {
        message: String,
        #[source_code]
        source_code: miette::NamedSource<String>,
        #[label("here")]
        span: miette::SourceSpan,
        #[help]
        help: Option<String>,
    },
    /// Anything wrong with a file as a whole, or at a place that the message names.
    #[error("{}: {message}", path.display())]
    Invalid {
        path: PathBuf,
        message: String,
        #[help]
        help: Option<String>,
    },
}

impl SceneError {
    pub fn invalid(path: impl Into<PathBuf>, message: impl Into<String>, help: &str) -> Self {
        let help = (!help.is_empty()).then(|| help.to_owned());
        Self::Invalid { path: path.into(), message: message.into(), help }
    }
}
