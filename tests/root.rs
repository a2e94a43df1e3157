//! One test binary: wgpu is linked once, helpers are shared.
mod cli;
mod common;
mod contract;
#[allow(dead_code, reason = "the example times it too")]
#[path = "../examples/measure/curves.rs"]
mod curves;
#[allow(dead_code, reason = "the example times it too")]
#[path = "../examples/measure/dither.rs"]
mod dither_study;
mod docs;
mod guest;
mod maps;
mod picture;
#[path = "../examples/measure/rivals.rs"]
mod rivals;
mod scene;
mod stages;
