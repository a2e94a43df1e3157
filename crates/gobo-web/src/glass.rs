//! The first scene of the page.
use gobo::Scene;
use gobo_scene::{LoadOptions, SceneError, load_text};
use std::path::Path;

/// A folding screen of coloured panes in the sun, and a plant behind it.
///
/// # Errors
/// None, unless the file of the scene is damaged.
pub fn stained_glass() -> Result<Scene, SceneError> {
    load_text(include_str!("glass.toml"), Path::new("glass.toml"), &LoadOptions::default())
}
