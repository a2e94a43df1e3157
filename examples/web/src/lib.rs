//! Coloured puffs under a lamp, drawn by a fragment shader of the host that evaluates gobo's light look-up.
//! The same code runs natively and in a browser.
mod show;
#[cfg(target_arch = "wasm32")]
mod web;

pub use show::{Knobs, Show};
