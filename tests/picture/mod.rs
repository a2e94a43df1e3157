//! The lit picture.
mod air;
mod environment;
mod golden;
mod masks;
mod renderer;
mod samples;
mod shade;
mod specks;
