//! The lit picture.
mod air;
mod environment;
mod golden;
mod masks;
mod samples;
mod shade;
mod specks;
