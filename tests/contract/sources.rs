//! The files of `src/` as modules, and which of them name what is declared in others.
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};
use syn::visit::{self, Visit};

/// A path of modules from the crate's root, or of a name in one.
pub(super) type Module = Vec<String>;

/// What a file names of others.
#[derive(Debug, Default)]
pub(super) struct Source {
    /// The file's module.
    module: Module,
    /// Paths from the root of what it uses.
    pub(super) used: Vec<Module>,
    /// What others may name through it, as it imports it: a name, and the path from the root.
    pub(super) passed: Vec<(String, Module)>,
    /// Modules of another folder, by `#[path]`.
    pub(super) elsewhere: Vec<String>,
}

impl Source {
    /// Unit tests apart.
    pub(super) fn of(module: &[String], text: &str) -> Self {
        let mut source = Self { module: module.to_vec(), ..Self::default() };
        source.visit_file(&syn::parse_file(text).unwrap());
        source
    }

    /// Of a path's segments as they are written; `None`: of another crate, or of what a `use` named.
    fn absolute(&self, path: &[String]) -> Option<Module> {
        let mut from = match path[0].as_str() {
            "crate" => Module::new(),
            "self" | "super" => self.module.clone(),
            _ => return None,
        };
        for part in path {
            match part.as_str() {
                "crate" | "self" => {}
                "super" => drop(from.pop()),
                _ => from.push(part.clone()),
            }
        }
        Some(from)
    }

    fn visit_tree(&mut self, passes_on: bool, before: &[String], tree: &syn::UseTree) {
        let with = |ident: &syn::Ident| [before, &[ident.to_string()]].concat();
        // The name that others know it by; none for all of a module.
        let (name, path) = match tree {
            syn::UseTree::Path(path) => {
                return self.visit_tree(passes_on, &with(&path.ident), &path.tree);
            }
            syn::UseTree::Group(group) => {
                let trees = group.items.iter();
                return trees.for_each(|tree| self.visit_tree(passes_on, before, tree));
            }
            syn::UseTree::Name(name) => (Some(&name.ident), with(&name.ident)),
            syn::UseTree::Rename(rename) => (Some(&rename.rename), with(&rename.ident)),
            syn::UseTree::Glob(_) => (None, before.to_vec()),
        };
        // `use child::Name` is of a module's own child.
        let path = self.absolute(&path).unwrap_or_else(|| [&self.module[..], &path].concat());
        self.passed.extend(name.map(|name| (name.to_string(), path.clone())));
        if !passes_on || name.is_none() {
            self.used.push(path);
        }
    }
}

impl Visit<'_> for Source {
    fn visit_item_mod(&mut self, item: &syn::ItemMod) {
        if item.attrs.iter().any(|attribute| attribute.path().is_ident("path")) {
            self.elsewhere.push(item.ident.to_string());
        }
        if item.ident != "tests" {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &syn::ItemUse) {
        let passes_on = !matches!(item.vis, syn::Visibility::Inherited);
        self.visit_tree(passes_on, &[], &item.tree);
    }

    fn visit_path(&mut self, path: &syn::Path) {
        let segments: Vec<_> =
            path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        self.used.extend(self.absolute(&segments));
        visit::visit_path(self, path);
    }

    fn visit_visibility(&mut self, _: &syn::Visibility) {}
}

/// All files of `folder`.
pub(super) fn files(folder: &Path) -> Vec<PathBuf> {
    if folder.is_file() {
        return vec![folder.to_owned()];
    }
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|entry| files(&entry)).collect()
}

/// The modules of `src/`.
pub(super) fn sources() -> BTreeMap<Module, Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let of_file = |file: PathBuf| {
        let inside = file.strip_prefix(&root).unwrap().with_extension("");
        let mut module: Module =
            inside.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        if ["mod", "lib", "main"].contains(&module[module.len() - 1].as_str()) {
            module.pop();
        }
        let source = Source::of(&module, &fs::read_to_string(&file).unwrap());
        (module, source)
    };
    files(&root).into_iter().filter(|file| !file.ends_with("main.rs")).map(of_file).collect()
}

/// Files whose declarations each file names, also through `pub use`.
pub(super) fn arrows(sources: &BTreeMap<Module, Source>) -> BTreeMap<Module, BTreeSet<Module>> {
    let declared_in = |path: &Module| -> Option<Module> {
        let mut path = path.clone();
        for _ in 0..8 {
            let length = (0..=path.len()).rev().find(|&n| sources.contains_key(&path[..n]))?;
            let (file, rest) = path.split_at(length);
            let source = &sources[file];
            if rest.first().is_some_and(|name| source.elsewhere.contains(name)) {
                return None;
            }
            let passed = rest.first().and_then(|name| {
                let (_, to) = source.passed.iter().find(|(passed, _)| passed == name)?;
                Some([to, &rest[1..]].concat())
            });
            match passed {
                Some(to) => path = to,
                None => return Some(file.to_vec()),
            }
        }
        None
    };
    let of_file = |(module, source): (&Module, &Source)| {
        let to: BTreeSet<_> = source.used.iter().filter_map(declared_in).collect();
        (module.clone(), to.into_iter().filter(|to| to != module).collect())
    };
    sources.iter().map(of_file).collect()
}
