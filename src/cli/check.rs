//! `gobo check`: reads and validates a scene; no GPU is touched.
use super::{failure::Failure, files};
use std::path::Path;

pub(crate) fn run(path: &Path) -> Result<(), Failure> {
    files::print(&gobo::scene::load(path)?.summary().to_string())
}
