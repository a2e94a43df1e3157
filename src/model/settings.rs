//! What a user may choose about shadows.
use super::ShadowFilter;

/// How a receiver reads a shadow map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "scene", derive(serde::Deserialize))]
#[cfg_attr(feature = "scene", serde(rename_all = "lowercase"))]
pub enum Receiver {
    /// The whole filter behind the nearest translucent depth, nothing before it.
    #[default]
    Nearest,
    /// The product over the casters in front of the receiver only.
    Curve,
}

/// The `[shadow]` table of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowSettings {
    /// Edge of a view's map [texels], 16..=4096.
    pub size: u32,
    /// How the maps are read.
    pub receiver: Receiver,
    /// Nodes of a transmittance curve (K).
    pub nodes: u32,
    /// Which texels a receiver asks; of lights that do not say for themselves.
    pub filter: ShadowFilter,
    /// How far behind a stored depth a receiver must be to count as behind it [m]; of lights that do not
    /// say for themselves.
    pub bias: f32,
    /// What the slope of a lit surface adds to that: the depth that it falls by over so many texels
    /// [texels]; of lights that do not say for themselves.
    pub slope_bias: f32,
    /// How far a lit surface's point is moved along its normal before the look-up, beyond what the reach of
    /// a wider filter than the default's asks for [texels]; of lights that do not say for themselves.
    pub normal_bias: f32,
    /// Pairs that one batch of views may hold; casters past it take the scatter path.
    pub pair_budget: u32,
    /// Texels that the maps of all views may take together; maps are halved until they fit.
    pub texel_budget: u64,
    /// Whether dithered surfaces become a grey filter, blurred over a window of their pattern.
    pub soften: bool,
    /// Whether dithered casters block each channel by a threshold of its own.
    pub colored: bool,
    /// Radius of the window over which filter maps and curves are blurred by a Gaussian,
    /// 0..=[`MAX_BLUR`]; the nearest translucent depth becomes that of the window [texels].
    pub blur: u32,
    /// Smaller levels of the filter map, for a host that samples it, 0..=[`MAX_MIPS`].
    pub mips: u32,
}

impl ShadowSettings {
    /// K of the curves that receivers read; 0 where they read none.
    pub fn curve_nodes(&self) -> u32 {
        if self.receiver == Receiver::Curve { self.nodes } else { 0 }
    }
}

impl Default for ShadowSettings {
    fn default() -> Self {
        Self {
            size: 1024,
            receiver: Receiver::Nearest,
            nodes: 8,
            filter: ShadowFilter::Spline,
            bias: 0.01,
            slope_bias: 0.0,
            normal_bias: 1.5,
            pair_budget: MAX_PAIRS,
            texel_budget: 1 << 27,
            soften: false,
            colored: false,
            blur: 0,
            mips: 0,
        }
    }
}

/// The `[air]` table of a scene: what scatters light on its way to the eye, once, everywhere alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Air {
    /// The share of the light that a short way scatters: linear rgb, 0 or more [1/m].
    pub scattering: glam::Vec3,
    /// The share that a short way takes from what is behind it: linear rgb, 0 or more [1/m]. Of air in
    /// nature at least what it scatters; with less, shafts are seen without a veil.
    pub extinction: glam::Vec3,
    /// How much of the light from everywhere is scattered beside that of the lights, 0..=1.
    pub ambient: f32,
    /// `g` of Henyey and Greenstein 1941: 0 alike in all directions, towards 1 forwards.
    pub anisotropy: f32,
    /// Slices of the way from the eye to the scene's end, 1..=[`MAX_AIR_STEPS`].
    pub steps: u32,
}

impl Default for Air {
    fn default() -> Self {
        let density = glam::Vec3::splat(0.05);
        Self { scattering: density, extinction: density, ambient: 1.0, anisotropy: 0.3, steps: 64 }
    }
}

/// Slices of the air: layers of a texture that every device has.
pub const MAX_AIR_STEPS: u32 = 256;

/// The `[clusters]` table of a scene: how the camera's frustum is cut for its lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClusterSettings {
    /// Edge of a cluster on the screen [pixels], 16..=256.
    pub tile: u32,
    /// Slices in depth, 1..=64.
    pub slices: u32,
    /// Where the first slice ends [m]; a hundredth of the camera's far plane when `None`.
    pub near: Option<f32>,
    /// Lights that the lists of all clusters together may hold; clusters past it are shaded with
    /// all lights. With 0, all are.
    pub budget: u32,
}

impl ClusterSettings {
    /// Most slices.
    pub const MAX_SLICES: u32 = 64;
    /// Largest budget.
    pub const MAX_BUDGET: u32 = 1 << 24;
}

impl Default for ClusterSettings {
    fn default() -> Self {
        Self { tile: 32, slices: 24, near: None, budget: 1 << 22 }
    }
}

/// Largest edge of a map: a tile's coordinate must fit 8 bits [texels].
pub const MAX_MAP_SIZE: u32 = 4096;
/// Smallest edge of a map: one tile [texels].
pub const MIN_MAP_SIZE: u32 = 16;

/// Most pairs that one batch may hold: those that a sort's textures have room for.
pub const MAX_PAIRS: u32 = 1 << 26;

/// Widest blur of maps [texels].
pub const MAX_BLUR: u32 = 16;
/// Standard deviations from the middle of a blur's window to its end.
pub const BLUR_DEVIATIONS: f32 = 2.0;
/// Most smaller levels of a filter map: in the last, a tile is one texel.
pub const MAX_MIPS: u32 = 4;
