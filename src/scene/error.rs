//! What is wrong with a scene, where, and what to do.
use std::{
    ops::Range,
    path::{Path, PathBuf},
};

/// Why a scene could not be loaded.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages name the fields")]
pub enum SceneError {
    #[error("{}: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    /// A value in a scene file.
    #[error("{}:{line}:{column}: {message}", path.display())]
    Document {
        path: PathBuf,
        /// From 1.
        line: usize,
        /// From 1 [characters].
        column: usize,
        message: String,
        #[source_code]
        text: String,
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
    pub(super) fn invalid(path: impl AsRef<Path>, message: impl Into<String>, help: &str) -> Self {
        let help = (!help.is_empty()).then(|| help.to_owned());
        Self::Invalid { path: path.as_ref().to_owned(), message: message.into(), help }
    }

    /// `span`: bytes of `text`, the whole scene file.
    pub(super) fn document(
        path: &Path,
        text: &str,
        span: Range<usize>,
        message: impl Into<String>,
        help: Option<String>,
    ) -> Self {
        let start =
            (0..=span.start.min(text.len())).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0);
        let before = &text[..start];
        Self::Document {
            path: path.to_owned(),
            line: 1 + before.matches('\n').count(),
            column: 1 + before.chars().rev().take_while(|&c| c != '\n').count(),
            message: message.into(),
            text: text.to_owned(),
            span: (start, span.end.min(text.len()).saturating_sub(start)).into(),
            help,
        }
    }
}
