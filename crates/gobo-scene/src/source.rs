//! Text of a scene: the file, and the values that replace its own from the command line, with positions.
use super::{
    SceneError,
    error::quoted,
    keys::dotted,
    plain::{explained, nearest},
};
use std::{borrow::Cow, cell::RefCell, ops::Range, path::Path};
use toml::{
    Spanned,
    de::{DeTable, DeValue, Error},
};

/// Most parts of a dotted key, more than in the longest valid one.
const MAX_KEY_PARTS: usize = 8;

/// The text of a scene file, followed by the values of the command line, a line each.
pub(super) struct SceneText<'a> {
    path: &'a Path,
    text: &'a str,
    /// Length of the scene file \[bytes\].
    file_length: usize,
    set: &'a [(String, String)],
    tree: DeTable<'a>,
    /// Keys that readers requested, if they are recorded.
    asked: Option<RefCell<Vec<String>>>,
}

/// The text that [`SceneText::parse`] reads.
pub(super) fn joined(file: &str, set: &[(String, String)]) -> String {
    set.iter().fold(file.to_owned(), |text, (_, value)| text + "\n" + value)
}

impl<'a> SceneText<'a> {
    /// Parses `text`, which [`joined`] made of a file of `file_length` bytes and `set`.
    pub(super) fn parse(
        path: &'a Path,
        text: &'a str,
        file_length: usize,
        set: &'a [(String, String)],
    ) -> Result<Self, SceneError> {
        let mut source = Self { path, text, file_length, set, tree: DeTable::new(), asked: None };
        source.tree = DeTable::parse(&text[..file_length])
            .map_err(|error| source.explain(&error, 0..0))?
            .into_inner();
        let mut start = file_length;
        for (key, value) in set {
            start += 1;
            let span = start..start + value.len();
            // A bare word is a string.
            let parsed = match DeValue::parse(&text[span.clone()]) {
                Ok(parsed) => shifted(parsed, start),
                Err(_) => {
                    Spanned::new(span.clone(), DeValue::String(Cow::Borrowed(&text[span.clone()])))
                }
            };
            put(&mut source.tree, key, parsed).map_err(|(message, help)| {
                let usual = "keys are like shadow.size, camera.size, light.NAME.intensity or \
                             material.0.tint";
                source.error(span.clone(), message, help.or_else(|| Some(usual.to_owned())))
            })?;
            start = span.end;
        }
        Ok(source)
    }

    /// The keys that `read` asks for, dotted.
    pub(super) fn asked(mut self, read: impl FnOnce(&Self)) -> Vec<String> {
        self.asked = Some(RefCell::default());
        read(&self);
        self.asked.unwrap_or_default().into_inner()
    }

    /// Records a request for a table's key.
    pub(super) fn ask(&self, table: &str, key: &str) {
        if let Some(asked) = &self.asked {
            asked.borrow_mut().push(dotted(table, key));
        }
    }

    pub(super) fn path(&self) -> &Path {
        self.path
    }

    pub(super) fn tree(&self) -> &DeTable<'a> {
        &self.tree
    }

    /// An error at `span`, bytes of the text.
    #[expect(clippy::needless_pass_by_value, reason = "callers make the help for this error")]
    pub(super) fn error(
        &self,
        span: Range<usize>,
        message: impl Into<String>,
        help: Option<String>,
    ) -> SceneError {
        if span.start <= self.file_length {
            let text = &self.text[..self.file_length];
            return SceneError::document(self.path, text, span, message.into(), help.as_deref());
        }
        let mut end = self.file_length;
        let set = self.set.iter().find(|(_, value)| {
            end += 1 + value.len();
            span.start <= end
        });
        let (key, value) = set.map_or(("", ""), |(key, value)| (key, value));
        let [key, value] = [key, value].map(|text| quoted(text).replace('`', ""));
        let message = format!("--set {key}={value}: {}", message.into());
        SceneError::invalid(self.path, message, help.as_deref().unwrap_or(""))
    }

    /// Like [`Self::error`], at the value of `key` in the table at `table`.
    pub(super) fn error_at(
        &self,
        table: &Range<usize>,
        key: &str,
        message: impl Into<String>,
        help: &str,
    ) -> SceneError {
        let span = self.tree.values().find_map(|value| value_span(value, table, key));
        let help = (!help.is_empty()).then(|| help.to_owned());
        self.error(span.unwrap_or_else(|| table.clone()), message, help)
    }

    /// A reader's error; `at`: position of an error without one.
    pub(super) fn explain(&self, error: &Error, at: Range<usize>) -> SceneError {
        let span = error.span().unwrap_or(at);
        let (message, help) = match self.text.get(span.clone()) {
            Some(key) if error.message().starts_with("duplicate key") => {
                let help = "remove one of them, or write [[...]] where there are several of a kind";
                (format!("the key {} is there twice", quoted(key)), help.to_owned())
            }
            _ => explained(error.message()),
        };
        self.error(span, message, Some(help))
    }
}

fn value_span(
    value: &Spanned<DeValue<'_>>,
    table: &Range<usize>,
    key: &str,
) -> Option<Range<usize>> {
    match value.get_ref() {
        DeValue::Table(inner) if value.span() == *table && inner.contains_key(key) => {
            inner.get(key).map(Spanned::span)
        }
        DeValue::Table(inner) => inner.values().find_map(|v| value_span(v, table, key)),
        DeValue::Array(items) => items.iter().find_map(|v| value_span(v, table, key)),
        _ => None,
    }
}

/// The value with its spans shifted by `by` bytes.
fn shifted(value: Spanned<DeValue<'_>>, by: usize) -> Spanned<DeValue<'_>> {
    let moved = |span: Range<usize>| span.start + by..span.end + by;
    let span = moved(value.span());
    let inner = match value.into_inner() {
        DeValue::Array(items) => {
            DeValue::Array(items.into_iter().map(|item| shifted(item, by)).collect())
        }
        DeValue::Table(table) => DeValue::Table(
            table
                .into_iter()
                .map(|(key, item)| {
                    (Spanned::new(moved(key.span()), key.into_inner()), shifted(item, by))
                })
                .collect(),
        ),
        plain => plain,
    };
    Spanned::new(span, inner)
}

/// The problem of a key, and the remedy for a special one.
type KeyFault = (String, Option<String>);

/// Puts a value at a dotted key; array items are addressed by name or index.
fn put<'a>(
    table: &mut DeTable<'a>,
    key: &'a str,
    value: Spanned<DeValue<'a>>,
) -> Result<(), KeyFault> {
    let parts: Vec<&str> = key.split('.').collect();
    if parts.len() > MAX_KEY_PARTS || parts.iter().any(|part| part.is_empty()) {
        return Err(("no such key".to_owned(), None));
    }
    put_parts(table, &parts, value)
}

fn put_parts<'a>(
    table: &mut DeTable<'a>,
    parts: &[&'a str],
    value: Spanned<DeValue<'a>>,
) -> Result<(), KeyFault> {
    let span = value.span();
    let name = |part| Spanned::new(span.clone(), Cow::Borrowed(part));
    let [first, rest @ ..] = parts else { return Ok(()) };
    if rest.is_empty() {
        // The file's key is removed too: an error about it must point at the command line.
        table.remove(*first);
        table.insert(name(*first), value);
        return Ok(());
    }
    let inner = table
        .entry(name(*first))
        .or_insert_with(|| Spanned::new(span.clone(), DeValue::Table(DeTable::new())));
    match inner.get_mut() {
        DeValue::Table(inner) => put_parts(inner, rest, value),
        DeValue::Array(items) => {
            let [which, rest @ ..] = rest else { return Ok(()) };
            if rest.is_empty() {
                return Err((format!("which key of {first} {which}?"), None));
            }
            let name = |item: &Spanned<DeValue<'_>>| -> Option<String> {
                item.get_ref().get("name")?.get_ref().as_str().map(str::to_owned)
            };
            let names: Vec<Option<String>> = items.iter().map(name).collect();
            let index = names.iter().position(|name| name.as_deref() == Some(*which));
            let index = index.or_else(|| which.parse().ok().filter(|&i: &usize| i < items.len()));
            let item = index.and_then(|index| items.get_mut(index));
            match item.map(Spanned::get_mut) {
                Some(DeValue::Table(inner)) => put_parts(inner, rest, value),
                Some(_) => Err((format!("{first} {which} is no table"), None)),
                None => {
                    let known = names.iter().flatten().map(String::as_str);
                    let message = format!("there is no {first} {} in the scene", quoted(which));
                    Err((message, nearest(which, known)))
                }
            }
        }
        _ => Err((format!("{first} is no table"), None)),
    }
}
