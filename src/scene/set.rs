//! Values from the command line, written into the scene file before it is read.
use super::SceneError;
use std::path::Path;
use toml::{Table, Value};

/// The text of the scene file with the values of `set` in it; the text itself where there are none.
pub(super) fn apply(
    path: &Path,
    text: String,
    set: &[(String, String)],
) -> Result<String, SceneError> {
    if set.is_empty() {
        return Ok(text);
    }
    let mut table: Table = toml::from_str(&text).map_err(|error| {
        let span = error.span().unwrap_or(0..0);
        SceneError::document(path, &text, span, error.message(), None)
    })?;
    for (key, value) in set {
        // A bare word is a string.
        let value = toml::from_str::<Table>(&format!("value = {value}"))
            .ok()
            .and_then(|mut parsed| parsed.remove("value"))
            .unwrap_or_else(|| Value::String(value.clone()));
        put(&mut table, key, value).map_err(|message| {
            let help = "keys are like shadow.size, camera.size, light.NAME.intensity or \
                        material.0.tint";
            SceneError::invalid(path, format!("--set {key}: {message}"), help)
        })?;
    }
    toml::to_string(&table).map_err(|error| SceneError::invalid(path, error.to_string(), ""))
}

fn put(table: &mut Table, key: &str, value: Value) -> Result<(), String> {
    let (first, rest) = match key.split_once('.') {
        Some((first, rest)) => (first, Some(rest)),
        None => (key, None),
    };
    let Some(rest) = rest else {
        table.insert(first.to_owned(), value);
        return Ok(());
    };
    let entry = table.entry(first).or_insert_with(|| Value::Table(Table::new()));
    match entry {
        Value::Table(inner) => put(inner, rest, value),
        Value::Array(items) => {
            let (which, rest) = rest
                .split_once('.')
                .ok_or_else(|| format!("which {first}, and which key of it?"))?;
            let named = |item: &Value| {
                item.get("name").and_then(Value::as_str).is_some_and(|name| name == which)
            };
            let index = items
                .iter()
                .position(named)
                .or_else(|| which.parse().ok().filter(|&i: &usize| i < items.len()))
                .ok_or_else(|| format!("there is no {first} {which:?} in the scene"))?;
            match &mut items[index] {
                Value::Table(inner) => put(inner, rest, value),
                _ => Err(format!("{first} {which:?} is no table")),
            }
        }
        _ => Err(format!("{first} is no table")),
    }
}
