//! Python's dictionaries as tables of a scene file, so that both have the same keys, limits and messages.
use crate::fault::Fault;
use gobo_scene as scene;
use gobo_scene::{LoadOptions, Scene, SceneError};
use pyo3::{
    Bound, PyAny, PyResult, Python,
    types::{PyAnyMethods as _, PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple},
};
use std::path::Path;
use toml::{Table, Value};

/// Name of the scene file in messages: its files are relative to the working folder.
const NAME: &str = "<python>";
/// Deepest nesting of tables.
const MAX_DEPTH: usize = 8;
/// Longest list in a table.
const MAX_LENGTH: usize = 10_000;

/// A table from a dictionary, without `None` values. `what`: its name in messages.
pub(crate) fn table(what: &str, dict: &Bound<'_, PyDict>) -> PyResult<Table> {
    table_at(what, dict, 0)
}

fn refused<T>(py: Python<'_>, message: String, remedy: &str) -> PyResult<T> {
    Err(Fault::input(message, remedy).raised(py))
}

fn table_at(what: &str, dict: &Bound<'_, PyDict>, depth: usize) -> PyResult<Table> {
    let mut table = Table::new();
    for (key, given) in dict {
        let Ok(key) = key.extract::<String>() else {
            let message = format!("{what}: a key is no string");
            return refused(dict.py(), message, "use the keys of docs/scene.md");
        };
        if !given.is_none() {
            let name = format!("{what}: {key}");
            table.insert(key, value(&name, &given, depth)?);
        }
    }
    Ok(table)
}

fn value(what: &str, given: &Bound<'_, PyAny>, depth: usize) -> PyResult<Value> {
    let py = given.py();
    if depth > MAX_DEPTH {
        return refused(py, format!("{what} is too deep"), "use the keys of docs/scene.md");
    }
    if given.is_instance_of::<PyBool>() {
        return Ok(Value::Boolean(given.extract()?));
    }
    if given.is_instance_of::<PyInt>() {
        return match given.extract::<i64>() {
            Ok(whole) => Ok(Value::Integer(whole)),
            Err(_) => refused(py, format!("{what} is too large"), "use a smaller number"),
        };
    }
    if given.is_instance_of::<PyFloat>() {
        return Ok(Value::Float(given.extract()?));
    }
    if given.is_instance_of::<PyString>() {
        return Ok(Value::String(given.extract()?));
    }
    if let Ok(dict) = given.cast::<PyDict>() {
        return Ok(Value::Table(table_at(what, dict, depth + 1)?));
    }
    if given.is_instance_of::<PyList>() || given.is_instance_of::<PyTuple>() {
        let length = given.len()?;
        if length > MAX_LENGTH {
            return refused(py, format!("{what} has {length} values"), "use fewer");
        }
        let items = given.try_iter()?.map(|item| value(what, &item?, depth + 1));
        return Ok(Value::Array(items.collect::<PyResult<_>>()?));
    }
    // Numbers and arrays of numpy, tensors; paths.
    for method in ["tolist", "__fspath__"] {
        if let Ok(method) = given.getattr(method) {
            return value(what, &method.call0()?, depth + 1);
        }
    }
    let kind = given.get_type().to_string();
    refused(py, format!("{what} is a {kind}"), "use numbers, strings, lists or dictionaries")
}

/// A table that holds another.
pub(crate) fn within(name: &str, inner: impl Into<Value>) -> Table {
    Table::from_iter([(name.to_owned(), inner.into())])
}

/// A list with a single table.
pub(crate) fn only(name: &str, inner: Table) -> Table {
    within(name, Value::Array(vec![inner.into()]))
}

/// The scene of some tables. `what`: name of the table in messages.
pub(crate) fn scene_of(what: &str, tables: &Table) -> Result<Scene, Fault> {
    let text = tables.to_string();
    let mut options = LoadOptions::default();
    options.start = false;
    scene::load_text(&text, Path::new(NAME), &options).map_err(|error| match error {
        SceneError::Document { message, help, .. } => {
            let help = help.unwrap_or_default();
            Fault::input(
                format!("{what}: {message}"),
                help.replace("to the scene file", "to the working folder"),
            )
        }
        SceneError::Invalid { path, message, help } if path == Path::new(NAME) => {
            Fault::input(format!("{what}: {message}"), help.unwrap_or_default())
        }
        error => error.into(),
    })
}
