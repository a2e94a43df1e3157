//! One stage at a time.
mod bin;
mod cluster;
mod cull;
mod dither;
mod filter;
mod occlude;
mod soften_curves;
mod sort;
