//! The lit picture.
mod air;
mod environment;
mod golden;
mod host_masks;
mod masks;
mod samples;
mod shade;
mod specks;
