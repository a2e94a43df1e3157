//! Files of `wgsl/` as imports and declarations.
use super::{Item, LinkError};
use std::collections::HashMap;

/// Imports and declarations of a file.
#[derive(Clone, Debug)]
pub(super) struct File {
    pub imports: HashMap<&'static str, Import>,
    pub items: Vec<Item>,
}

/// Source of an imported name.
#[derive(Clone, Copy, Debug)]
pub(super) struct Import {
    pub module: &'static str,
    pub line: usize,
}

impl File {
    pub(super) fn new(path: &'static str, text: &'static str) -> Result<Self, LinkError> {
        let (mut imports, mut items) = (HashMap::new(), Vec::new());
        let (mut start, mut lines) = (0, 0);
        while let Some(end) = item_end(text, start) {
            let (whole, item) = (&text[start..end], text[start..end].trim_start());
            let before = &whole[..whole.len() - item.len()];
            let line = 1 + lines + before.matches('\n').count();
            let fail = |reason: String| LinkError { file: path, line, reason };
            (start, lines) = (end, lines + whole.matches('\n').count());
            if let Some((at, module, names)) = import(item) {
                let line = line + item[..at].matches('\n').count();
                let import = Import { module, line };
                imports.extend(names.into_iter().map(|name| (name, import)));
                continue;
            }
            let (keyword, name) =
                declared(item).ok_or_else(|| fail("a declaration without a name".to_owned()))?;
            items.push(Item { name, keyword, text: item, file: path, line });
        }
        Ok(Self { imports, items })
    }
}

/// End of the declaration that starts at `start`, including a comment on its last line.
fn item_end(text: &str, start: usize) -> Option<usize> {
    let mut depth = 0_i32;
    for (at, c) in code(text, start) {
        depth += match c {
            '{' | '(' => 1,
            '}' | ')' => -1,
            ';' => 0,
            _ => continue,
        };
        let rest = &text[at + 1..];
        // The names of an import stand in braces before its end.
        if depth == 0 && c != ')' && !rest.starts_with(';') {
            let line = rest.split('\n').next().unwrap_or_default();
            let is_comment = line.trim_start().starts_with("//");
            return Some(at + 1 + if is_comment { line.len() } else { 0 });
        }
    }
    None
}

/// Characters outside comments.
pub(super) fn code(text: &str, start: usize) -> impl Iterator<Item = (usize, char)> {
    let mut is_comment = false;
    text[start..].char_indices().map(move |(at, c)| (start + at, c)).filter(move |&(at, c)| {
        is_comment = if is_comment { c != '\n' } else { c == '/' && text[at..].starts_with("//") };
        !is_comment
    })
}

/// Identifiers and keywords of the code with their positions, without member accesses.
pub fn words(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut before = ' ';
    code(text, 0).filter_map(move |(at, c)| {
        let is_in = |c: char| c.is_alphanumeric() || c == '_';
        let starts = is_in(c) && !is_in(before) && before != '.';
        before = c;
        let rest = &text[at..];
        starts.then(|| (at, &rest[..rest.find(|c| !is_in(c)).unwrap_or(rest.len())]))
    })
}

/// Keyword and name of a declaration.
fn declared(item: &'static str) -> Option<(&'static str, &'static str)> {
    let keywords = ["fn", "struct", "const", "override", "var", "alias"];
    let mut words = words(item).skip_while(|(_, word)| !keywords.contains(word));
    let (_, keyword) = words.next()?;
    // `var<storage, read_write> name: type`
    let is_name = |at: usize, word: &str| {
        keyword != "var" || item[at + word.len()..].trim_start().starts_with(':')
    };
    words.find(|&(at, word)| is_name(at, word)).map(|(_, name)| (keyword, name))
}

/// Start of an import after its comment, its module and its names.
fn import(item: &'static str) -> Option<(usize, &'static str, Vec<&'static str>)> {
    let (start, word) = words(item).next()?;
    let path = item[start..].strip_prefix("import ").filter(|_| word == "import")?;
    let (module, names) = path.split(';').next()?.rsplit_once("::")?;
    Some((start, module.trim(), words(names).map(|(_, name)| name).collect()))
}
