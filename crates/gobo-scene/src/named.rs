//! Files that a scene names, so that it can be copied as a whole.
use super::{
    SceneError, dense,
    document::{Document, TextureSource, VolumeTable},
    gltf::file::GltfFile,
    load::{document, scene_text},
    obj, read,
    source::SceneText,
    splat_file::named_files,
    volume_frame::numbered,
};
use std::{
    ops::Range,
    path::{Component, Path, PathBuf},
};
use toml::Spanned;

/// The file of a scene, and all files that it and its models name, each once. Names are relative to the
/// scene's folder; absolute names are refused.
pub fn files(path: &Path) -> Result<Vec<PathBuf>, SceneError> {
    let mut files = named_files(path)?;
    read::check(&files[0])?;
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    files.extend(named_by_model(path)?);
    if extension != "toml" {
        files.extend(dense::named(path));
    } else {
        let text = scene_text(path)?;
        let source = SceneText::parse(path, &text, text.len(), &[])?;
        let document = document(&source)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        for (table, key, name) in names(&document) {
            if !is_portable(&name) {
                let message = format!("{} is not relative to the scene", name.display());
                let help =
                    "name it by a path from the scene's folder, with `..` at most at its start";
                return Err(source.error_at(&table, key, message, help));
            }
            let file = folder.join(&name);
            if key == "file" {
                files.extend(named_by_model(&file)?);
            }
            if document.volume.iter().any(|volume| volume.span() == table) {
                files.extend(dense::named(&file));
            }
            files.extend(named_files(&file)?);
        }
    }
    files[1..].sort();
    files.dedup();
    Ok(files)
}

/// Files that a model names.
fn named_by_model(path: &Path) -> Result<Vec<PathBuf>, SceneError> {
    match path.extension().unwrap_or_default().to_ascii_lowercase().to_str() {
        Some("glb" | "gltf") => GltfFile::open(path)?.named(),
        Some("obj") => obj::named(path),
        _ => Ok(Vec::new()),
    }
}

/// Table, key and name of each file that a scene names.
fn names(document: &Document) -> Vec<(Range<usize>, &'static str, PathBuf)> {
    fn files<'a, T: 'a>(
        tables: impl IntoIterator<Item = &'a Spanned<T>>,
        file: impl Fn(&'a T) -> Option<&'a PathBuf>,
    ) -> impl Iterator<Item = (Range<usize>, &'static str, PathBuf)> {
        tables
            .into_iter()
            .filter_map(move |table| Some((table.span(), "file", file(table.get_ref())?.clone())))
    }
    let mut names: Vec<_> = files(&document.environment, |table| table.file.as_ref()).collect();
    for table in &document.material {
        if let Some(TextureSource::File(file)) = &table.get_ref().texture {
            names.push((table.span(), "texture", file.clone()));
        }
    }
    names.extend(files(&document.particles, |table| table.file.as_ref()));
    names.extend(files(&document.splats, |table| table.file.as_ref()));
    names.extend(files(&document.strands, |table| table.file.as_ref()));
    names.extend(files(&document.mesh, |table| Some(&table.file)));
    for table in &document.volume {
        let VolumeTable { file: Some(file), frames, .. } = table.get_ref() else { continue };
        let all = match *frames {
            None => vec![file.clone()],
            Some([first, last]) => (first..=last).filter_map(|i| numbered(file, i)).collect(),
        };
        names.extend(all.into_iter().map(|file| (table.span(), "file", file)));
    }
    names
}

/// Whether a name leads to the same file wherever the folders around the scene are copied to.
fn is_portable(name: &Path) -> bool {
    let mut rest = name.components().skip_while(|part| *part == Component::ParentDir);
    rest.all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
}
