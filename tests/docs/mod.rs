//! What the documents say.
mod dither_figures;
mod paths;
mod results;
mod stages;
