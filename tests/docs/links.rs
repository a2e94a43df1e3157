//! Relative links of the documents: their files, and the headings they name.
use std::{
    fs,
    path::{Path, PathBuf},
};

fn documents(root: &Path) -> Vec<PathBuf> {
    let folders = ["", "docs", "data", "data/gallery", "data/issues", "benches", "tools/farm"];
    let entries = folders.iter().filter_map(|folder| fs::read_dir(root.join(folder)).ok());
    let files = entries.flatten().map(|entry| entry.unwrap().path());
    files.filter(|file| file.extension().is_some_and(|extension| extension == "md")).collect()
}

/// Lines outside of fenced code.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut is_code = false;
    text.lines().filter(move |line| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence
    })
}

/// Anchor of a heading as forges make it: lower case, spaces to hyphens, punctuation left out.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|&c| c.is_alphanumeric() || " -_".contains(c));
    kept.collect::<String>().trim().to_lowercase().replace(' ', "-")
}

fn anchors(text: &str) -> Vec<String> {
    let headings = prose(text).filter(|line| line.starts_with('#'));
    headings.map(|line| anchor(line.trim_start_matches('#'))).collect()
}

/// Targets of Markdown links in `text`.
fn targets(text: &str) -> Vec<&str> {
    let links = prose(text).flat_map(|line| line.split("](").skip(1));
    links.filter_map(|rest| rest.split_once(')').map(|(target, _)| target)).collect()
}

/// Links of the document `file` that lead nowhere.
fn broken(file: &Path, text: &str) -> Vec<String> {
    let is_elsewhere = |target: &&str| target.contains("://") || target.starts_with("mailto:");
    let leads = |target: &str| {
        let (path, heading) = target.split_once('#').unwrap_or((target, ""));
        let named = if path.is_empty() { file.into() } else { file.parent().unwrap().join(path) };
        if heading.is_empty() {
            return named.exists();
        }
        let there = if path.is_empty() { Ok(text.to_owned()) } else { fs::read_to_string(named) };
        there.is_ok_and(|text| anchors(&text).iter().any(|anchor| anchor == heading))
    };
    let all = targets(text).into_iter().filter(|target| !is_elsewhere(target));
    all.filter(|target| !leads(target)).map(|it| format!("{}: {it}", file.display())).collect()
}

#[test]
fn links_lead_to_files_and_headings() {
    let root = Path::new(crate::common::ROOT);
    let files = documents(root);
    assert!(files.iter().any(|file| file.ends_with("docs/pipeline.md")));
    let read = |file: &PathBuf| broken(file, &fs::read_to_string(file).unwrap());
    let found: Vec<_> = files.iter().flat_map(read).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn broken_links_are_noticed() {
    let file = Path::new(crate::common::ROOT).join("README.md");
    for wrong in ["[a](docs/none.md)", "[a](docs/scene.md#no-such-heading)", "[a](#none)"] {
        assert_eq!(broken(&file, wrong).len(), 1, "{wrong}");
    }
    let fine = "## One `x`, two\n[a](#one-x-two) [b](docs/scene.md) [c](https://example.org/#none)";
    assert!(broken(&file, fine).is_empty());
}
