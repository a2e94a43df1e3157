//! `gobo info --formats` and `gobo info FILE`: the formats that are read, and the contents of a file.
use super::{failure::Failure, files};
use gobo_scene as scene;
use gobo_scene::{FORMATS, Format, Summary};
use serde::Serialize;
use std::{fmt::Write as _, path::Path};

#[derive(Serialize)]
struct Contents<'a> {
    format: Option<&'a Format>,
    /// Facts from the file's head.
    facts: Vec<(&'static str, String)>,
    /// Summary of the file as a scene.
    summary: Option<Summary>,
    /// Ignored parts, and choices made.
    notes: Vec<String>,
}

/// Lists the formats that are read.
pub(super) fn formats(json: bool) -> Result<(), Failure> {
    if json {
        return files::print(&serde_json::to_string_pretty(FORMATS).expect("plain data is JSON"));
    }
    let rows: Vec<[String; 5]> = FORMATS
        .iter()
        .map(|format| {
            // Some endings are whole names.
            let ending = |ending: &&str| {
                if ending.ends_with("json") { (*ending).to_owned() } else { format!(".{ending}") }
            };
            let endings: Vec<String> = format.endings.iter().map(ending).collect();
            [
                format.family.name().to_owned(),
                endings.join(" "),
                format.name.to_owned(),
                format!("by {}", format.known_by),
                format.read.to_owned(),
            ]
        })
        .collect();
    let width = |column: usize| rows.iter().map(|row| row[column].len()).max().unwrap_or(0);
    let widths = [0, 1, 2, 3].map(width);
    let mut text = String::new();
    for row in &rows {
        for (column, width) in widths.iter().enumerate() {
            let _ = write!(text, "{:<width$}  ", row[column]);
        }
        let _ = writeln!(text, "{}", row[4]);
    }
    files::print(text.trim_end())
}

/// Prints the contents of a file: the facts from its head, and its summary as a scene.
pub(super) fn file(path: &Path, json: bool) -> Result<(), Failure> {
    let format = scene::format_of(path);
    let is_scene = format.is_none_or(|format| format.family.is_alone());
    let scene = if is_scene { Some(scene::inspect(path)?) } else { None };
    let facts = scene::facts(path);
    let notes = scene.as_ref().map(|scene| scene.notes.clone()).unwrap_or_default();
    let summary = scene.as_ref().map(Summary::of);
    if json {
        let contents = Contents { format, facts, summary, notes };
        return files::print(&serde_json::to_string_pretty(&contents).expect("plain data is JSON"));
    }
    let mut text = String::new();
    if let Some(format) = format {
        let _ = writeln!(text, "format     {}, read as {}", format.name, format.family.name());
    }
    for (name, value) in &facts {
        let _ = writeln!(text, "{name:<10} {value}");
    }
    if let Some(summary) = &summary {
        let _ = writeln!(text, "{summary}");
    }
    for note in &notes {
        let _ = writeln!(text, "note       {note}");
    }
    files::print(text.trim_end())
}
