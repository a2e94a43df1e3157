//! What one frame yields.
use crate::{counters::Counters, cpu::curve::CurveMap, debug::DebugMode, view::View};
use glam::UVec2;

/// The maps of one view, read back. Texel `(x, y)` is at `y * size.x + x`; row 0 is the top.
#[derive(Clone, Debug)]
pub struct ViewMaps {
    pub view: View,
    /// `F`: product of the transmittances in front of the opaque surface, linear rgb.
    pub filter: Vec<[f32; 3]>,
    /// `D`: light depth of the nearest translucent hit, 1 where there is none.
    pub nearest: Vec<f32>,
    /// `Z`: light depth of the nearest opaque surface, 1 where there is none.
    pub opaque: Vec<f32>,
    /// `Z` by channel, where dithering is coloured; else empty. `opaque` is the last of the three.
    pub colored: Vec<[f32; 3]>,
    /// Light as a function of depth; in curve mode.
    pub curve: Option<CurveMap>,
    /// Whose `nearest` is, as [`crate::owner::owner_tag`] says; empty where no receiver asks.
    pub owner: Vec<u16>,
}

/// The lit picture.
#[derive(Clone, Debug)]
pub struct Picture {
    /// [pixels]
    pub size: UVec2,
    /// sRGB, rows from the top.
    pub rgb: Vec<[u8; 3]>,
}

/// One frame's results and what they cost.
#[derive(Clone, Debug)]
pub struct Frame {
    pub picture: Picture,
    /// Those that were asked for.
    pub debug: Vec<(DebugMode, Picture)>,
    /// Empty unless maps were asked for.
    pub maps: Vec<ViewMaps>,
    pub counters: Counters,
    /// Stage and its time [ms], in order.
    pub stages: Vec<(&'static str, f64)>,
    /// Buffer or texture and its size [bytes].
    pub memory: Vec<(&'static str, u64)>,
}
