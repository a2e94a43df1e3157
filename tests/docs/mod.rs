//! Checks of the documents against the project.
mod dither_figures;
mod embedding;
mod export;
mod interfaces;
mod links;
mod paths;
mod pictures;
mod results;
mod stages;
