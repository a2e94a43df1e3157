//! Renders every scene of data/gallery to pictures, a contact sheet and one page with descriptions, shadow
//! maps and costs: `make gallery`.
//!
//! `cargo run --release --example gallery [OUT=out/gallery] [NAME]... [KEY=VALUE]...`
//!
//! Fails if a picture is missing or flat, or a frame's capacity was too small.
mod page;
mod preview;

use gobo::host::Backend;
use gobo_picture::{DebugMode, Frame, RenderOptions, Renderer};
use gobo_scene::load_with;
use image::RgbImage;
use std::{
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

/// Results of a scene of the gallery, without its maps: those of all scenes are 20 GB.
struct Plate {
    path: PathBuf,
    /// The picture; a scene's masks are inset.
    image: RgbImage,
    /// Time of reading, rendering and reading back.
    time: Duration,
    /// Its part of the page.
    section: String,
    faults: Vec<String>,
}

fn main() -> Fallible<()> {
    let (set, words): (Vec<_>, Vec<_>) = std::env::args().skip(1).partition(|a| a.contains('='));
    let set: Vec<(String, String)> = set
        .iter()
        .filter_map(|pair| pair.split_once('='))
        .map(|(key, value)| (key.to_owned(), value.to_owned()))
        .collect();
    let out = words.first().map_or_else(|| PathBuf::from("out/gallery"), PathBuf::from);
    let only = words.get(1..).unwrap_or_default();
    fs::create_dir_all(&out)?;

    let mut renderer = Renderer::new(Backend::Auto, None)?;
    let device = renderer.device();
    println!("{device}");
    let mut plates = Vec::new();
    for scene in scenes(only)? {
        let plate = render(&mut renderer, &scene, &set, &out)?;
        println!("{:>7.1} s  {}", plate.time.as_secs_f64(), plate.path.display());
        plates.push(plate);
    }
    let sheet = preview::contact_sheet(&plates);
    sheet.save(out.join("sheet.png"))?;
    let whole: Duration = plates.iter().map(|plate| plate.time).sum();
    fs::write(out.join("index.html"), page::page(&plates, &device, whole))?;
    println!("{:>7.1} s  {} pictures", whole.as_secs_f64(), plates.len());
    println!("{}\n{}", out.join("sheet.png").display(), out.join("index.html").display());
    let faults: Vec<&str> =
        plates.iter().flat_map(|plate| &plate.faults).map(String::as_str).collect();
    if faults.is_empty() { Ok(()) } else { Err(faults.join("\n").into()) }
}

/// Scene files by name; all of them if `only` is empty.
fn scenes(only: &[String]) -> Fallible<Vec<PathBuf>> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("data/gallery");
    let mut found = Vec::new();
    for entry in fs::read_dir(&folder)? {
        let path = entry?.path();
        let is_wanted = |name: &str| only.is_empty() || only.iter().any(|wanted| wanted == name);
        if path.extension().is_some_and(|e| e == "toml") && is_wanted(&name(&path)) {
            found.push(path);
        }
    }
    found.sort();
    if found.is_empty() {
        return Err(format!("no such scene in {}", folder.display()).into());
    }
    Ok(found)
}

fn name(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn render(
    renderer: &mut Renderer,
    scene: &Path,
    set: &[(String, String)],
    out: &Path,
) -> Fallible<Plate> {
    let clock = Instant::now();
    let text = fs::read_to_string(scene)?;
    let about: Vec<&str> = text.lines().map_while(|line| line.strip_prefix("# ")).collect();
    let loaded = load_with(scene, set)?;
    let debug: &[DebugMode] = if loaded.mask.is_some() { &[DebugMode::Masks] } else { &[] };
    let options = RenderOptions { maps: true, curves_stay: true, debug, ..Default::default() };
    let frame = renderer.render(&loaded, &options)?;
    let time = clock.elapsed();
    let name = name(scene);
    let path = out.join(format!("{name}.png"));
    let mut image = preview::image(&frame.picture)?;
    for (_, masks) in &frame.debug {
        preview::inset(&mut image, &preview::image(masks)?);
    }
    image.save(&path)?;
    let section = page::section(&name, &about.join(" "), &image, &frame, time)?;
    let faults = faults(&name, &path, &frame);
    Ok(Plate { path, image, time, section, faults })
}

/// Whether the picture is missing or flat, nothing casts, or a capacity was too small.
fn faults(name: &str, path: &Path, frame: &Frame) -> Vec<String> {
    let mut faults = Vec::new();
    match image::open(path).map(|picture| picture.to_rgb8()) {
        Err(error) => faults.push(format!("{name}: {}: {error}", path.display())),
        Ok(picture) if is_flat(&picture) => faults.push(format!("{name}: the picture is flat")),
        Ok(_) => {}
    }
    let casts = |maps: &gobo_picture::ViewMaps| {
        maps.filter.iter().any(|filter| filter.iter().any(|&light| light < 0.9))
    };
    // Only solid casters appear in masks.
    if frame.debug.is_empty() && !frame.maps.iter().any(casts) {
        faults.push(format!("{name}: nothing translucent casts in any map"));
    }
    for (what, count) in
        [("shrunk", frame.counters.shrunk), ("unordered", frame.counters.unordered)]
    {
        if count > 0 {
            faults.push(format!("{name}: {count} {what}"));
        }
    }
    faults
}

/// Whether there are few tones: fewer than 64 of the picture's colours, in steps of 8.
fn is_flat(picture: &RgbImage) -> bool {
    let tones: std::collections::HashSet<[u8; 3]> =
        picture.pixels().map(|pixel| pixel.0.map(|v| v / 8)).collect();
    tones.len() < 64
}
