//! Pictures in the documents: docs/pictures.toml names the command of each, the page prints it, and it makes
//! the picture.
use crate::common::{TIERS, gpu};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene as scene;
use image::RgbImage;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};
use toml::{Table, Value};

/// Tolerance of a channel [of 255], as other drivers round differently, and the share of pixels that may
/// differ by more: edges fall to one side or the other.
const APART: u8 = 8;
const MOST: f64 = 0.005;
const ENDINGS: [&str; 4] = ["png", "webp", "svg", "jpg"];

fn root() -> &'static Path {
    Path::new(crate::common::ROOT)
}

/// A picture's files and their commands, with the words of its row.
struct Made {
    files: Vec<String>,
    page: String,
    commands: Vec<String>,
    /// Commands in the table, before the words are filled in.
    printed: Vec<String>,
    is_cheap: bool,
}

fn texts(value: Option<&Value>) -> Vec<String> {
    let values = value.and_then(Value::as_array).into_iter().flatten();
    values.map(|value| value.as_str().unwrap().to_owned()).collect()
}

/// `text` with the values of a row in place of its words.
fn filled(text: &str, row: &Table) -> String {
    row.iter().fold(text.to_owned(), |text, (word, value)| match value {
        Value::String(value) => text.replace(word, value),
        _ => text,
    })
}

fn table() -> (Vec<Made>, Vec<String>) {
    let text = fs::read_to_string(root().join("docs/pictures.toml")).unwrap();
    let table: Table = text.parse().unwrap();
    let mut all = Vec::new();
    for entry in table["picture"].as_array().unwrap() {
        let entry = entry.as_table().unwrap();
        let rows = entry.get("each").and_then(Value::as_array).cloned();
        for row in rows.unwrap_or_else(|| vec![Value::Table(Table::new())]) {
            let row = row.as_table().unwrap();
            let of = |key: &str| texts(entry.get(key)).iter().map(|it| filled(it, row)).collect();
            all.push(Made {
                files: of("files"),
                page: entry["page"].as_str().unwrap().to_owned(),
                commands: of("commands"),
                printed: texts(entry.get("commands")),
                is_cheap: row.get("cheap").and_then(Value::as_bool).unwrap_or(false),
            });
        }
    }
    let drawn = table["drawn"].as_array().unwrap().iter();
    (all, drawn.map(|it| it["file"].as_str().unwrap().to_owned()).collect())
}

/// Words of a command, without line ends and without the options for `tools/pictures.py` alone.
fn plain(command: &str) -> String {
    command.replace("\\\n", " ").split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Files with one of the endings, in a folder and those below it.
fn files(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    paths
        .flat_map(|path| {
            let ends = |ending: &&str| path.extension().is_some_and(|it| it == *ending);
            if path.is_dir() {
                files(&path, endings)
            } else {
                endings.iter().any(ends).then_some(path).into_iter().collect()
            }
        })
        .collect()
}

/// Pictures in a document, as paths from the root.
fn shown(page: &str, text: &str) -> Vec<String> {
    let folder = Path::new(page).parent().unwrap();
    let links =
        text.split("![").skip(1).filter_map(|rest| rest.split_once("](")?.1.split_once(')'));
    let local = links.map(|(target, _)| target).filter(|target| !target.contains("://"));
    local
        // Rust's `vec![..]` is no picture.
        .filter(|target| ENDINGS.iter().any(|ending| target.ends_with(ending)))
        .map(|target| {
            let mut path = folder.to_owned();
            for part in Path::new(target).components() {
                match part {
                    std::path::Component::ParentDir => drop(path.pop()),
                    part => path.push(part),
                }
            }
            path.to_str().unwrap().replace('\\', "/")
        })
        .collect()
}

/// Scene and overrides of a `gobo render` command; `None` if it does more.
fn render_of(command: &str) -> Option<(String, Vec<(String, String)>)> {
    let words: Vec<_> = command.split_whitespace().map(|word| word.trim_matches('\'')).collect();
    let ["gobo", "render", scene, rest @ ..] = &words[..] else { return None };
    let pairs = rest.chunks(2).map(|pair| match pair {
        ["--set", set] => {
            set.split_once('=').map(|(key, value)| (key.to_owned(), value.to_owned()))
        }
        _ => None,
    });
    Some(((*scene).to_owned(), pairs.collect::<Option<_>>()?))
}

/// Share of pixels that differ; 1 if the sizes differ.
fn apart(a: &RgbImage, b: &RgbImage) -> f64 {
    if a.dimensions() != b.dimensions() {
        return 1.0;
    }
    let is_apart = |(a, b): (&image::Rgb<u8>, &image::Rgb<u8>)| {
        a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > APART)
    };
    a.pixels().zip(b.pixels()).filter(|&pair| is_apart(pair)).count() as f64
        / f64::from(a.width() * a.height())
}

#[test]
fn each_picture_has_its_command() {
    let (made, drawn) = table();
    let named: Vec<_> = made.iter().flat_map(|made| &made.files).chain(&drawn).cloned().collect();
    let once: BTreeSet<_> = named.iter().cloned().collect();
    assert_eq!(named.len(), once.len(), "a picture has two commands");
    let is_there = |path: &String| root().join(path).is_file();
    let missing: Vec<_> = once.iter().filter(|path| !is_there(path)).collect();
    assert!(missing.is_empty(), "no such files: {missing:?}");
    let from_root =
        |path: PathBuf| path.strip_prefix(root()).unwrap().to_str().unwrap().replace('\\', "/");
    let stored = files(&root().join("docs"), &ENDINGS).into_iter();
    let mut pages: Vec<_> = files(&root().join("docs"), &["md"]);
    pages.extend(["README.md", "data/README.md", "benches/NOTES.md"].map(|page| root().join(page)));
    let linked = pages.into_iter().flat_map(|page| {
        let text = fs::read_to_string(&page).unwrap();
        shown(&from_root(page), &text)
    });
    let wanted: BTreeSet<_> = stored.map(from_root).chain(linked).collect();
    let without: Vec<_> = wanted.difference(&once).collect();
    assert!(without.is_empty(), "pictures without a command in docs/pictures.toml: {without:?}");
}

#[test]
fn pages_print_the_commands_of_their_pictures() {
    let (made, _) = table();
    let mut pages = BTreeMap::new();
    let mut wrong = Vec::new();
    for Made { files, page, commands, printed, .. } in made {
        let text = pages
            .entry(page.clone())
            .or_insert_with(|| plain(&fs::read_to_string(root().join(&page)).unwrap()));
        for (command, printed) in commands.iter().zip(&printed) {
            if !text.contains(&plain(command)) && !text.contains(&plain(printed)) {
                wrong.push(format!(
                    "{page} does not print what makes {files:?}: {}",
                    plain(printed)
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The first frame of a scene with a stated picture size has its proportions.
#[test]
fn first_frames_have_the_proportions_of_their_scenes() {
    let first = |made: &Made| made.files[0].starts_with("docs/scenes/");
    for Made { files, commands, .. } in table().0.into_iter().filter(first) {
        let (path, set) = render_of(&plain(&commands[0])).unwrap();
        let text = fs::read_to_string(root().join(path)).unwrap();
        let scene: Table = text.parse().unwrap();
        let edge = |value: &Value, i: usize| value[i].as_integer().unwrap();
        let size = &scene["camera"]["size"];
        let set = set.iter().find(|(key, _)| key == "camera.size");
        let given: Value = set.map_or_else(
            || size.clone(),
            |(_, value)| format!("size = {value}").parse::<Table>().unwrap()["size"].clone(),
        );
        let [a, b] = [edge(size, 0) * edge(&given, 1), edge(size, 1) * edge(&given, 0)];
        assert_eq!(a, b, "{}: {size} as {given}", files[0]);
        let (width, height) = image::image_dimensions(root().join(&files[0])).unwrap();
        assert_eq!(
            [width, height].map(i64::from),
            [edge(&given, 0), edge(&given, 1)],
            "{}",
            files[0]
        );
    }
}

#[test]
fn cheap_pictures_are_as_their_commands_make_them() {
    let mut renderer = Renderer::on(gpu(TIERS[1])).unwrap();
    let cheap: Vec<_> = table().0.into_iter().filter(|made| made.is_cheap).collect();
    assert!(cheap.len() >= 10, "{} are rendered", cheap.len());
    let mut rendered: Vec<(String, RgbImage)> = Vec::new();
    for Made { files, commands, .. } in cheap {
        let (path, set) = render_of(&plain(&commands[0])).expect("it is rendered by one command");
        let scene =
            scene::load_with(&root().join(path), &set).unwrap_or_else(|error| panic!("{error}"));
        let picture = renderer.render(&scene, &RenderOptions::default()).unwrap().picture;
        let bytes = picture.rgb.as_flattened().to_vec();
        let image = RgbImage::from_raw(picture.size.x, picture.size.y, bytes).unwrap();
        rendered.push((files[0].clone(), image));
    }
    let stored = |path: &str| image::open(root().join(path)).unwrap().into_rgb8();
    let differ: Vec<_> = rendered
        .iter()
        .map(|(path, image)| (path, apart(image, &stored(path))))
        .filter(|&(_, share)| share > MOST)
        .collect();
    assert!(differ.is_empty(), "make pictures; shares of pixels that are off: {differ:?}");
    // The next one has a different picture.
    for (i, (path, _)) in rendered.iter().enumerate() {
        let (_, other) = &rendered[(i + 1) % rendered.len()];
        assert!(apart(other, &stored(path)) > MOST, "{path}");
    }
}
