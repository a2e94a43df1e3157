//! Linker of kernels: collects an entry point and all declarations that it uses from the files of `wgsl/`.
//!
//! A file names the source of each foreign name:
//!
//! ```text
//! import package::records::tile::{Tile, tile_of};   wgsl/records/tile.wgsl
//! import choice::traversal::walk;                        the file that the kernel chose to walk by
//! import choice::root::open_rest;                   the file of the kernel's entry point
//! ```
//!
//! (The spelling is WESL's, where `choice` would be a package of its own.) Names stay unchanged and
//! declarations may come in any order, so a kernel is the declarations that it needs, one after another, each
//! once. Unused declarations are left out: a resource that is not used is not bound.
#[cfg(not(target_arch = "wasm32"))]
mod loaded;
mod parse;
#[cfg(any(target_arch = "wasm32", feature = "export"))]
mod printed;
mod pruned;
mod unrolled;

pub use parse::words;
#[cfg(any(target_arch = "wasm32", feature = "export"))]
pub use printed::{ENABLED, for_browsers, printed};
pub(super) use pruned::prune;

use parse::{File, Import};
use std::{collections::HashMap, sync::LazyLock};

/// Path in `wgsl/` and text.
type SourceFile = (&'static str, &'static str);

static LIBRARY: LazyLock<Result<Library, LinkError>> =
    LazyLock::new(|| Library::new(include!(concat!(env!("OUT_DIR"), "/wgsl.rs"))));

/// A WGSL `override` and its value.
pub type Constant = (&'static str, f64);

/// Choice whose file declares sampled textures as storage textures.
pub const SAMPLED: &str = "sampled";

/// Choice of kernels whose marked loops are all unrolled; its file marks them.
pub const UNROLLED: &str = "unrolled";

/// Most turns of marked loops that are unrolled in every kernel: a column's texels, a triangle's edges. On an
/// H100, one index that was not constant made a walk take nearly twice as long.
pub const FEW_TURNS: u32 = 4;

/// Module name for imports that a text of the host declares.
pub(super) const HOST_TEXT: &str = "";

/// Error of linking a kernel.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("wgsl/{file}:{line}: {reason}")]
pub struct LinkError {
    /// File of a folder `wgsl/`.
    pub file: &'static str,
    /// Line, counted from 1.
    pub line: usize,
    /// The fault.
    pub reason: String,
}

/// The files that kernels are linked from.
#[derive(Clone, Debug)]
pub struct Library(HashMap<&'static str, File>);

/// A declaration, with the comment before it.
#[derive(Clone, Debug)]
pub struct Item {
    /// The declared name.
    pub name: &'static str,
    /// `fn`, `struct`, `const`, `override`, `var` or `alias`.
    pub keyword: &'static str,
    /// Comment and declaration.
    pub text: &'static str,
    /// File of a folder `wgsl/`.
    pub file: &'static str,
    /// Line of the file where the declaration begins.
    pub line: usize,
}

/// A kernel's source.
#[derive(Debug)]
pub struct Linked {
    /// The source.
    pub wgsl: String,
    /// Declarations in the order of `wgsl`.
    pub items: Vec<Item>,
    /// First line of each item in `wgsl`.
    lines: Vec<usize>,
}

impl Library {
    /// The files of `wgsl/`.
    pub fn embedded() -> Result<&'static Self, LinkError> {
        LIBRARY.as_ref().map_err(Clone::clone)
    }

    /// A library of files.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn new(sources: &[SourceFile]) -> Result<Self, LinkError> {
        Self(HashMap::new()).with(sources)
    }

    /// These files and those of another crate.
    ///
    /// # Errors
    /// A file that cannot be read, or whose path exists already.
    pub fn with(&self, sources: &[SourceFile]) -> Result<Self, LinkError> {
        let mut all = self.clone();
        for &(path, text) in sources {
            if all.0.insert(path, File::new(path, text)?).is_some() {
                let reason = "another crate has a file of this path".to_owned();
                return Err(LinkError { file: path, line: 1, reason });
            }
        }
        Ok(all)
    }

    /// Links the entry point `name` of the file `root`; `choices`: file of each choice.
    pub fn link(
        &self,
        root: &'static str,
        name: &'static str,
        choices: &[(&str, &'static str)],
    ) -> Result<Linked, LinkError> {
        let mut owners = HashMap::from([(name, root)]);
        let mut reached = vec![(root, name)];
        let mut files = vec![root];
        let mut next = 0;
        while let Some(&(file, name)) = reached.get(next) {
            next += 1;
            let item = self.item(file, name, (file, 1))?;
            for word in words(item.text).map(|(_, word)| word) {
                let Some(found) = self.find(item.file, word, root, choices)? else { continue };
                if !files.contains(&found.file) {
                    files.push(found.file);
                }
                match owners.insert(word, found.file) {
                    None => reached.push((found.file, word)),
                    Some(other) if other == found.file => {}
                    Some(other) => {
                        let reason = format!("`{word}` is in wgsl/{other} too");
                        return Err(LinkError { file: found.file, line: found.line, reason });
                    }
                }
            }
        }
        let reached_in = |file| {
            let owners = &owners;
            self.0[file].items.iter().filter(move |item| owners.get(item.name) == Some(&file))
        };
        Ok(Linked::new(files.into_iter().flat_map(reached_in).cloned().collect()))
    }

    /// File and name that `word` refers to in a file; `None` for a local name or one of the language.
    fn find(
        &self,
        file: &'static str,
        word: &'static str,
        root: &'static str,
        choices: &[(&str, &'static str)],
    ) -> Result<Option<&Item>, LinkError> {
        let File { items, imports } = &self.0[file];
        if let Some(item) = items.iter().find(|item| item.name == word) {
            return Ok(Some(item));
        }
        let Some(&Import { module, line }) = imports.get(word) else { return Ok(None) };
        let fail = |reason| LinkError { file, line, reason };
        let target = match module.split_once("::") {
            Some(("choice", "root")) => root,
            Some(("choice", choice)) => {
                let chosen = choices.iter().find(|(name, _)| *name == choice);
                match chosen
                    .ok_or_else(|| fail(format!("the kernel does not choose `{choice}`")))?
                    .1
                {
                    HOST_TEXT => return Ok(None),
                    file => file,
                }
            }
            Some(("package", path)) => {
                let path = path.replace("::", "/") + ".wgsl";
                let known = self.0.get_key_value(path.as_str());
                known.ok_or_else(|| fail(format!("there is no wgsl/{path}")))?.0
            }
            _ => return Err(fail(format!("`{module}` is neither of package:: nor of choice::"))),
        };
        self.item(target, word, (file, line)).map(Some)
    }

    /// Declaration `name` of a file; `from`: file and line of the reference.
    fn item(
        &self,
        target: &'static str,
        name: &'static str,
        (file, line): (&'static str, usize),
    ) -> Result<&Item, LinkError> {
        let items = self.0.get(target).map(|file| &file.items);
        items.and_then(|items| items.iter().find(|item| item.name == name)).ok_or_else(|| {
            LinkError { file, line, reason: format!("`{name}` is not in wgsl/{target}") }
        })
    }

    /// Every declaration of every file.
    pub fn items(&self) -> impl Iterator<Item = &Item> {
        self.0.values().flat_map(|file| &file.items)
    }

    /// The names that a file imports.
    pub fn imports(&self, file: &str) -> impl Iterator<Item = &'static str> {
        self.0.get(file).into_iter().flat_map(|file| file.imports.keys().copied())
    }
}

impl Item {
    /// The comment before an override, and its declaration as a constant: `NAME: u32 = 8u;`. `None` if it has
    /// no value.
    pub(super) fn constant(&self, constants: &[Constant]) -> Option<(&'static str, String)> {
        let name = self.name;
        let at = self.text.find(&format!("override {name}:"));
        let (comment, code) = self.text.split_at(at.filter(|_| self.keyword == "override")?);
        let mut sides = code.split_once(':')?.1.split(';').next()?.split('=').map(str::trim);
        let (kind, default) = (sides.next()?, sides.next());
        let given =
            constants.iter().find(|(known, _)| *known == name).map(|&(_, value)| match kind {
                "bool" => (value != 0.0).to_string(),
                "u32" => format!("{value}u"),
                _ => format!("{value:?}"),
            });
        Some((comment, format!("{name}: {kind} = {};", given.as_deref().or(default)?)))
    }
}

impl Linked {
    fn new(items: Vec<Item>) -> Self {
        let (mut wgsl, mut lines, mut line) = (String::new(), Vec::new(), 1);
        for item in &items {
            lines.push(line);
            wgsl += item.text;
            wgsl += "\n\n";
            line += item.text.matches('\n').count() + 2;
        }
        Self { wgsl, items, lines }
    }

    /// The source with constants in place of overrides: the values in `constants`, or else their defaults.
    /// Lines keep their positions.
    pub(super) fn with_values(&self, constants: &[Constant]) -> String {
        self.items.iter().fold(String::new(), |mut wgsl, item| {
            match item.constant(constants) {
                Some((comment, constant)) => wgsl.extend([comment, "const ", &constant]),
                None => wgsl += item.text,
            }
            wgsl + "\n\n"
        })
    }

    /// Names of the overrides.
    pub fn overrides(&self) -> impl Iterator<Item = &'static str> {
        self.items.iter().filter(|item| item.keyword == "override").map(|item| item.name)
    }

    /// File and line for a line of `wgsl`, counted from 1.
    pub fn locate(&self, line: usize) -> Option<(&'static str, usize)> {
        let at = self.lines.partition_point(|&first| first <= line).checked_sub(1)?;
        let item = self.items.get(at)?;
        Some((item.file, item.line + line - self.lines[at]))
    }

    /// A compiler error with positions in `wgsl/` instead of the linked source. wgpu names the source
    /// `wgsl` or by its `label`.
    pub fn located(&self, error: &str, label: &str) -> String {
        located(error, label, |line| {
            self.locate(line).map(|(file, line)| format!("wgsl/{file}:{line}"))
        })
    }
}

/// A compiler error with the lines of the source replaced by `place`.
pub(super) fn located(error: &str, label: &str, place: impl Fn(usize) -> Option<String>) -> String {
    ["wgsl:", &format!("{label}:")].iter().fold(error.to_owned(), |error, mark| {
        let mut parts = error.split(mark);
        let mut text = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            let rest = part.trim_start_matches(|c: char| c.is_ascii_digit());
            let line = part[..part.len() - rest.len()].parse().ok();
            text += &match line.and_then(&place) {
                Some(place) => format!("{place}{rest}"),
                None => format!("{mark}{part}"),
            };
        }
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOT: SourceFile = (
        "a/root.wgsl",
        "// A kernel.\n\nimport package::b::{size, unused_here};\nimport choice::way::{\n    go,\n    \
         stop,\n};\n\nconst OWN: u32 = 1u; // its own\n\n// Enters.\n@compute @workgroup_size(1)\n\
         fn root() {\n    go(size() + OWN); // no_name\n}\n",
    );
    const B: SourceFile = (
        "b.wgsl",
        "fn size() -> u32 { return rest(); }\nfn rest() -> u32 { return 2u; }\n\nfn unused() {}\n",
    );
    const WAY: SourceFile =
        ("way/one.wgsl", "import choice::root::OWN;\nfn go(a: u32) {}\nconst stop: u32 = OWN;\n");

    fn linked(files: &[SourceFile]) -> Result<Linked, LinkError> {
        Library::new(files)?.link("a/root.wgsl", "root", &[("way", "way/one.wgsl")])
    }

    #[test]
    fn what_is_reached_is_linked_once() {
        let linked = linked(&[ROOT, B, WAY]).unwrap();
        let names: Vec<_> = linked.items.iter().map(|item| item.name).collect();
        assert_eq!(names, ["OWN", "root", "go", "size", "rest"]);
        assert!(!linked.wgsl.contains("import"), "{}", linked.wgsl);
        for item in ["fn size", "fn rest", "const OWN"] {
            assert_eq!(linked.wgsl.matches(item).count(), 1, "{item}");
        }
    }

    #[test]
    fn lines_lead_back_to_their_files() {
        let linked = linked(&[ROOT, B, WAY]).unwrap();
        let lines = linked.wgsl.lines();
        for (line, text) in (1..).zip(lines).filter(|(_, text)| !text.is_empty()) {
            let (file, at) = linked.locate(line).unwrap();
            let source = [ROOT, B, WAY].into_iter().find(|source| source.0 == file).unwrap().1;
            assert_eq!(source.lines().nth(at - 1), Some(text), "{file}:{at}");
        }
        let line = 1 + linked.wgsl.lines().position(|line| line.contains("go(size")).unwrap();
        for name in ["wgsl", "root"] {
            let error = linked.located(&format!("no\n  ┌─ {name}:{line}:5\n"), "root");
            assert_eq!(error, "no\n  ┌─ wgsl/a/root.wgsl:14:5\n");
        }
        assert_eq!(
            linked.located("wgsl:x wgsl:, 'root': root:", "root"),
            "wgsl:x wgsl:, 'root': root:"
        );
    }

    #[test]
    fn what_cannot_be_linked_names_its_line() {
        let fails = |files: &[SourceFile]| linked(files).err().map(|error| error.to_string());
        let with = |b: &'static str| fails(&[ROOT, ("b.wgsl", b), WAY]).unwrap_or_default();
        assert_eq!(with("fn other() {}"), "wgsl/a/root.wgsl:3: `size` is not in wgsl/b.wgsl");
        let error = fails(&[ROOT, WAY]).unwrap_or_default();
        assert_eq!(error, "wgsl/a/root.wgsl:3: there is no wgsl/b.wgsl");
        assert_eq!(
            with("import choice::other::x;\nfn size() { x(); }"),
            "wgsl/b.wgsl:1: the kernel does not choose `other`"
        );
        assert_eq!(
            with("import b::x;\nfn size() { x(); }"),
            "wgsl/b.wgsl:1: `b` is neither of package:: nor of choice::"
        );
        assert_eq!(
            with("fn size() { go(); }\nfn go() {}"),
            "wgsl/b.wgsl:2: `go` is in wgsl/way/one.wgsl too"
        );
        assert_eq!(with("\nstruct;"), "wgsl/b.wgsl:2: a declaration without a name");
        assert_eq!(
            fails(&[B, WAY]).unwrap_or_default(),
            "wgsl/a/root.wgsl:1: `root` is not in wgsl/a/root.wgsl"
        );
    }
}
