//! The lit picture.
mod air;
mod golden;
mod shade;
mod specks;
