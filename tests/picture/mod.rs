//! The lit picture.
mod air;
mod environment;
mod golden;
mod samples;
mod shade;
mod specks;
