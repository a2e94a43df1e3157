//! The lit picture.
mod air;
mod golden;
mod masks;
mod samples;
mod shade;
mod specks;
