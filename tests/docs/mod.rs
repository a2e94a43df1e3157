//! Checks of the documents against the project.
mod dither_figures;
mod embedding;
mod links;
mod paths;
mod results;
mod stages;
