//! `gobo check`: reads and validates a scene; no GPU is touched.
use super::{curves, failure::Failure, files};
use std::path::Path;

pub(crate) fn run(path: &Path) -> Result<(), Failure> {
    let scene = gobo_scene::check(path)?;
    if let Some(warning) = gobo_scene::rounding_warning(&scene) {
        tracing::warn!("{warning}");
    }
    curves::warn_before(&scene);
    files::warn(&scene.notes);
    files::print(&gobo_scene::Summary::of(&scene).to_string())
}
