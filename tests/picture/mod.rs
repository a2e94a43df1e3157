//! The lit picture.
mod air;
mod asides;
mod bloom;
mod bricks;
mod emitters;
mod environment;
mod golden;
mod host_masks;
mod masks;
mod occlusion;
mod renderer;
mod samples;
mod shade;
mod specks;
mod steady;
