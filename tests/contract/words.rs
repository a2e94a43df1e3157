//! Words of the sources: one type a name, comments that begin with their subject, lines that fit beside
//! another file.
use super::sources::{CRATES, files};
use crate::common::ROOT;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};
use syn::{Attribute, File, Ident, Item};

/// Columns of a line that two editors side by side show.
const COLUMNS: usize = 110;
/// Words that stand for a noun which the reader has to look for.
const PRONOUNS: [&str; 3] = ["What", "Of", "That"];

/// Names of the types that a file declares outside of its tests, and whether a configuration chooses the
/// declaration.
fn types(items: &[Item]) -> Vec<(String, bool)> {
    let has =
        |attributes: &[Attribute], name: &str| attributes.iter().any(|a| a.path().is_ident(name));
    let named =
        |ident: &Ident, attributes: &[Attribute]| vec![(ident.to_string(), has(attributes, "cfg"))];
    let of_item = |item: &Item| match item {
        Item::Enum(it) => named(&it.ident, &it.attrs),
        Item::Struct(it) => named(&it.ident, &it.attrs),
        Item::Trait(it) => named(&it.ident, &it.attrs),
        Item::Type(it) => named(&it.ident, &it.attrs),
        Item::Union(it) => named(&it.ident, &it.attrs),
        Item::Mod(it) if !has(&it.attrs, "cfg") => {
            types(it.content.as_ref().map_or(&[], |(_, items)| items))
        }
        _ => Vec::new(),
    };
    items.iter().flat_map(of_item).collect()
}

/// Names that several types of a crate have, with the files that declare them.
fn shared_names(sources: &[(String, String)]) -> Vec<(String, BTreeSet<String>)> {
    let mut declared: BTreeMap<String, Vec<(&String, bool)>> = BTreeMap::new();
    for (file, text) in sources {
        let File { items, .. } = syn::parse_file(text).unwrap();
        for (name, chosen) in types(&items) {
            declared.entry(name).or_default().push((file, chosen));
        }
    }
    let is_shared = |places: &[(&String, bool)]| {
        places.len() > 1 && !places.iter().all(|&(file, chosen)| chosen && file == places[0].0)
    };
    let shared = declared.into_iter().filter(|(_, places)| is_shared(places));
    shared
        .map(|(name, places)| (name, places.into_iter().map(|(file, _)| file.clone()).collect()))
        .collect()
}

fn with_extension(folder: &Path, extensions: &[&str]) -> Vec<(String, String)> {
    let is_source = |file: &PathBuf| {
        file.extension().is_some_and(|e| extensions.iter().any(|wanted| e == *wanted))
    };
    let read = |file: PathBuf| (file.display().to_string(), fs::read_to_string(&file).unwrap());
    files(folder).into_iter().filter(is_source).map(read).collect()
}

#[test]
fn a_type_name_has_one_meaning_in_a_crate() {
    let beside: Vec<_> = CRATES.iter().map(|(_, folder)| format!("crates/{folder}/src")).collect();
    for folder in beside.iter().map(String::as_str).chain(["src"]) {
        let shared = shared_names(&with_extension(&Path::new(ROOT).join(folder), &["rs"]));
        assert!(shared.is_empty(), "{folder}: {shared:#?}");
    }
}

#[test]
fn names_of_several_types_are_noticed() {
    let source = |file: &str, text: &str| (file.to_owned(), text.to_owned());
    let shared = |texts: [&str; 2]| {
        shared_names(&[source("a.rs", texts[0]), source("b.rs", texts[1])]).len()
    };
    assert_eq!(shared(["struct Kind;", "pub(super) enum Kind { A }"]), 1);
    assert_eq!(shared(["struct Kind;", "mod inner { type Kind = u32; }"]), 1);
    assert_eq!(shared(["struct Kind;", "#[cfg(test)] mod tests { struct Kind; }"]), 0);
    assert_eq!(shared(["#[cfg(unix)] struct Id; #[cfg(not(unix))] struct Id;", ""]), 0);
    assert_eq!(shared(["#[cfg(unix)] struct Id;", "#[cfg(not(unix))] struct Id;"]), 1);
}

/// Text of a line's comment, if the line has nothing else.
fn comment(line: &str) -> Option<&str> {
    Some(line.trim_start().strip_prefix("//")?.trim_start_matches(['/', '!']).trim_start())
}

/// Problem of a line of a source.
fn problem(line: &str) -> Option<&'static str> {
    let first = comment(line).and_then(|text| text.split_whitespace().next());
    if first.is_some_and(|word| PRONOUNS.contains(&word)) {
        return Some("begins with a pronoun: name the subject");
    }
    // A link cannot be broken, nor the text of a literal.
    let is_whole = line.contains("https://") || comment(line).is_none() && line.contains('"');
    (line.chars().count() > COLUMNS && !is_whole).then_some("has more than 110 columns")
}

#[test]
fn comments_name_their_subject_and_lines_are_short() {
    let mut problems = Vec::new();
    for folder in ["src", "wgsl", "tests", "examples", "benches", "crates"] {
        let of_folder = with_extension(&Path::new(ROOT).join(folder), &["rs", "wgsl"]);
        for (file, text) in of_folder.iter().filter(|(file, _)| !file.contains("/target/")) {
            let lines = (1..).zip(text.lines());
            let found = lines.filter_map(|(number, line)| Some((number, problem(line)?)));
            problems.extend(found.map(|(number, problem)| format!("{file}:{number} {problem}")));
        }
    }
    assert!(problems.is_empty(), "{} lines:\n{}", problems.len(), problems.join("\n"));
}

#[test]
fn pronouns_and_long_lines_are_noticed() {
    for line in ["/// What a texel sees.", "    // Of a light.", "//! That kind.", &"x".repeat(111)]
    {
        assert!(problem(line).is_some(), "{line}");
    }
    for line in
        ["/// Whatever moves.", "let what = 1; // What", &"x".repeat(110), "/// Offset of it."]
    {
        assert!(problem(line).is_none(), "{line}");
    }
}
