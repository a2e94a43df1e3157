//! Figures that the documents show.
mod dither_figures;
mod results;
