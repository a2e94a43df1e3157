//! The lit picture.
mod air;
mod bricks;
mod emitters;
mod environment;
mod golden;
mod host_masks;
mod masks;
mod renderer;
mod samples;
mod shade;
mod specks;
mod steady;
