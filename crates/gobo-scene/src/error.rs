//! Errors of scene files: the problem, its position and the remedy.
use std::{
    io,
    ops::Range,
    path::{Path, PathBuf},
};

/// A problem and its remedy, of a reader that knows no path.
pub(crate) type Fault = (String, &'static str);

/// Error of loading a scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages name the fields")]
pub enum SceneError {
    #[error("{}: {source}", named(path))]
    Read { path: PathBuf, source: io::Error },
    /// The scene is within all limits, but this machine has not enough memory.
    #[error("{}: {message}", named(path))]
    Memory { path: PathBuf, message: String },
    /// A value in a scene file.
    #[error("{}:{line}:{column}: {message}", named(path))]
    Document {
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1 \[characters\].
        column: usize,
        message: String,
        /// The line, or the part around the error if it is long.
        excerpt: String,
        /// Range of the error in the excerpt \[characters\].
        marked: Range<usize>,
        help: Option<String>,
    },
    /// An error of a file as a whole, or at a position that the message names.
    #[error("{}: {message}", named(path))]
    Invalid { path: PathBuf, message: String, help: Option<String> },
}

impl SceneError {
    /// The remedy.
    pub fn help(&self) -> Option<&str> {
        match self {
            Self::Read { .. } => Some("check the name, and that the file may be read"),
            Self::Memory { .. } => Some("use a smaller scene, or a machine with more memory"),
            Self::Document { help, .. } | Self::Invalid { help, .. } => help.as_deref(),
        }
    }

    pub(super) fn invalid(path: impl AsRef<Path>, message: impl AsRef<str>, help: &str) -> Self {
        let help = (!help.is_empty()).then(|| harmless(help));
        Self::Invalid { path: path.as_ref().to_owned(), message: harmless(message.as_ref()), help }
    }

    pub(super) fn memory(path: &Path, message: impl Into<String>) -> Self {
        Self::Memory { path: path.to_owned(), message: message.into() }
    }

    /// An error at `span`: bytes of `text`, the whole scene file.
    pub(super) fn document(
        path: &Path,
        text: &str,
        span: Range<usize>,
        message: impl AsRef<str>,
        help: Option<&str>,
    ) -> Self {
        let boundary = |at: usize| text.floor_char_boundary(at.min(text.len()));
        let start = boundary(span.start);
        let first = text[..start].rfind('\n').map_or(0, |newline| newline + 1);
        let line = text[first..].split('\n').next().unwrap_or_default();
        let before = text[first..start].chars().count();
        let length = text[start..boundary(span.end).max(start)].split('\n').next();
        let (excerpt, marked) = excerpt(line, before, length.map_or(0, |of| of.chars().count()));
        Self::Document {
            path: path.to_owned(),
            line: 1 + text[..first].matches('\n').count(),
            column: 1 + before,
            message: harmless(message.as_ref()),
            excerpt,
            marked,
            help: help.map(harmless),
        }
    }
}

/// Longest excerpt of a line \[characters\].
const EXCERPT: usize = 96;

/// Excerpt around the `length` characters that follow the first `before` of a line, and their range in the
/// excerpt.
fn excerpt(line: &str, before: usize, length: usize) -> (String, Range<usize>) {
    let skipped = before.saturating_sub(EXCERPT / 2);
    let strange = |c| if is_strange(c) { '\u{fffd}' } else { c };
    let text: String = line.chars().skip(skipped).take(EXCERPT).map(strange).collect();
    let start = before - skipped;
    let end = (start + length.max(1)).min(text.chars().count().max(start + 1));
    (text.trim_end().to_owned(), start..end)
}

/// Longest name that a message quotes in full \[characters\].
const NAME: usize = 60;
/// Longest message \[characters\].
const MESSAGE: usize = 700;

/// Part of the input, quoted for a message.
pub(super) fn quoted(name: &str) -> String {
    let short: String = name.chars().take(NAME).collect();
    let rest = if short.len() < name.len() { "..." } else { "" };
    format!("`{}{rest}`", escaped(&short))
}

/// Whether a terminal would move the cursor, or change the direction of writing.
fn is_strange(c: char) -> bool {
    c.is_control() || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

fn escaped(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if is_strange(c) {
            shown.extend(c.escape_unicode());
        } else {
            shown.push(c);
        }
    }
    shown
}

/// The message without control characters, whatever the input contains.
fn harmless(message: &str) -> String {
    let short: String = message.chars().take(MESSAGE).collect();
    let rest = if short.len() < message.len() { "..." } else { "" };
    escaped(&short) + rest
}

/// A path for messages: its end distinguishes it from others.
fn named(path: &Path) -> String {
    let text = path.to_string_lossy();
    let count = text.chars().count();
    if count <= MESSAGE / 2 {
        return escaped(&text);
    }
    format!("...{}", escaped(&text.chars().skip(count - MESSAGE / 2).collect::<String>()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_marked_in_its_line() {
        let text = "a = 1\nmüll = \"x\"\n";
        let at = text.find('"').unwrap();
        let error = SceneError::document(Path::new("s.toml"), text, at..at + 3, "no", None);
        let SceneError::Document { line, column, excerpt, marked, .. } = error else { panic!() };
        assert_eq!((line, column, excerpt.as_str(), marked), (2, 8, "müll = \"x\"", 7..10));
    }

    #[test]
    fn long_lines_are_cut_around_the_place() {
        let text = format!("{}HERE{}", "<".repeat(5000), ">".repeat(5000));
        let error = SceneError::document(Path::new("s.toml"), &text, 5000..5004, "no", None);
        let SceneError::Document { column, excerpt, marked, .. } = error else { panic!() };
        assert_eq!(column, 5001);
        let found: String = excerpt.chars().skip(marked.start).take(marked.len()).collect();
        assert_eq!((found.as_str(), excerpt.chars().count()), ("HERE", EXCERPT));
    }

    #[test]
    fn a_place_behind_the_end_is_the_end() {
        for text in ["", "a", "a\n"] {
            let error = SceneError::document(Path::new("s.toml"), text, 9..12, "no", None);
            let SceneError::Document { excerpt, marked, .. } = error else { panic!() };
            assert!(marked.start <= excerpt.chars().count() && marked.len() == 1, "{text:?}");
        }
    }

    #[test]
    fn what_is_strange_is_escaped() {
        assert_eq!(quoted("a\x1b[2J\u{202e}b"), "`a\\u{1b}[2J\\u{202e}b`");
        assert!(quoted(&"k".repeat(9999)).len() < 70);
        let error = SceneError::invalid("p\x07", "m\x1b", "h\u{9b}");
        assert!(!format!("{error}{}", error.help().unwrap()).contains(is_strange));
    }
}
