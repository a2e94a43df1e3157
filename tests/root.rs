//! One test binary: wgpu is linked once, helpers are shared.
#[path = "../examples/measure/avsm.rs"]
mod avsm;
mod cli;
mod common;
mod contract;
#[allow(dead_code, reason = "the example times it too")]
#[path = "../examples/measure/curves.rs"]
mod curves;
#[path = "../examples/measure/deep.rs"]
mod deep;
#[allow(dead_code, reason = "the example times it too")]
#[path = "../examples/measure/dither.rs"]
mod dither_study;
mod docs;
#[allow(dead_code, reason = "the example makes tables of it")]
#[path = "../examples/measure/grids.rs"]
mod grids;
mod guest;
#[allow(dead_code, reason = "the example makes a table of it")]
#[path = "../examples/measure/kernels.rs"]
mod kernels;
use common::{grid_truth, strand_truth};
mod maps;
#[path = "../examples/measure/moments.rs"]
mod moments;
mod picture;
#[allow(dead_code, reason = "the example reads files too")]
#[path = "../examples/measure/rays.rs"]
mod rays;
#[path = "../examples/measure/rivals.rs"]
mod rivals;
mod scene;
#[allow(dead_code, reason = "the example makes tables of it")]
#[path = "../examples/measure/splats.rs"]
mod splats;
mod stages;
#[path = "../examples/measure/strands.rs"]
mod strands;
