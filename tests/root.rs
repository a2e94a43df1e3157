mod common;
mod scene;
mod docs;
mod contract;
