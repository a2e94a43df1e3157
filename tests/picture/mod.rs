//! The lit picture.
mod air;
mod golden;
mod samples;
mod shade;
mod specks;
