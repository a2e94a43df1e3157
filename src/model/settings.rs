//! Shadow settings of a user.
use super::ShadowFilter;

/// How a receiver reads a shadow map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Receiver {
    /// The whole filter map behind the nearest translucent depth; nothing in front of it.
    Nearest,
    /// The transmittance curve: the product over only the casters in front of the receiver.
    #[default]
    Curve,
}

/// Where curves have room.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CurveMemory {
    /// In each texel of the maps.
    #[default]
    Whole,
    /// In pages of 16 x 16 texels, for tiles that casters touch: as many as the frames before needed, at
    /// first a quarter of all and at least 1024. While they do not suffice, curves of some tiles have a
    /// single node, which takes all light that is filtered at the nearest depth: `Counters::short_tiles` says
    /// so, and `Shadows::grow_from` makes room. With [`ShadowSettings::soften`] and
    /// [`ShadowSettings::blur`], which write curves where no caster is, it is [`Self::Whole`].
    Counted,
}

/// Settings by which shadow maps are made and read: the `[shadow]` table of a scene.
///
/// They are not meant to change from frame to frame. Another [`Self::filter`] or bias costs commands, made
/// anew of the same objects; [`Self::pair_budget`] and [`Self::texel_budget`] cost memory and commands; all
/// others render every view anew, into newly allocated maps, by kernels that may have to be compiled first
/// (`Shadows::pending`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowSettings {
    /// Edge of a view's map \[texels\], [`MIN_MAP_SIZE`]..=[`MAX_MAP_SIZE`]. Default 1024.
    pub size: u32,
    /// How receivers read the maps. Default [`Receiver::Curve`]. [`Receiver::Nearest`] takes a fifth of the
    /// memory of 8 nodes and less time, and gives the same light where casters are opaque or all in front of
    /// what they tint.
    pub receiver: Receiver,
    /// Nodes of a transmittance curve (K): 4, 8 or 16, of 8 bytes a texel each. Default 8.
    pub nodes: u32,
    /// Shadow filter of lights without their own. Default [`ShadowFilter::Spline`].
    pub filter: ShadowFilter,
    /// Distance behind a stored depth from which a receiver is shadowed, 0 or more \[m\]; for lights without
    /// their own. Default none: a quarter of a texel there, on slopes as much as [`Self::normal_bias`] asks
    /// for, for lights with a size four texels, within 2^-15 and 2^-9 of the view's depth range, so that
    /// scenes of any size have the same shadows.
    pub bias: Option<f32>,
    /// Slope-scaled bias: the depth by which the lit surface falls over so many texels, 0 or more \[texels\];
    /// for lights without their own. Default 0.
    pub slope_bias: f32,
    /// Normal offset of a lit point before the look-up, added to that of a filter wider than the default, 0
    /// or more \[texels\]; for lights without their own. Default 1.5.
    pub normal_bias: f32,
    /// Pair capacity of one batch of views, 16 bytes a pair, at most [`MAX_PAIRS`]; past it, tiles are walked
    /// some at a time, which changes no bit of filters and curves. Default [`MAX_PAIRS`]: a frame takes only
    /// the memory that it needs, for at most 2^26 pairs.
    pub pair_budget: u32,
    /// Texel capacity of the maps of all views together; maps are halved until they fit. Default 2^27: 1 GiB
    /// of filters and half as much for each kind of depths.
    pub texel_budget: u64,
    /// Most memory of the curves of all views together \[bytes\]: with more they have half of
    /// [`Self::nodes`], or four, and where these do not fit, receivers read nearest depths
    /// ([`Self::within_curve_budget`]); `Counters::nodes_dropped` says so. Default 2^31: 8 nodes for 32 maps
    /// of 1024 x 1024.
    pub curve_budget: u64,
    /// Where curves have room, within the budget. Default [`CurveMemory::Whole`]: nothing that casters do may
    /// exceed it. With [`CurveMemory::Counted`] a look-up takes a little longer, and the maps of scenes with
    /// few casters take a fraction of the memory.
    pub curve_memory: CurveMemory,
    /// Whether dithered surfaces become a grey filter, blurred over the window of their pattern. Default
    /// false.
    pub soften: bool,
    /// Whether dithered casters use a threshold of their own per channel. Default false.
    pub colored: bool,
    /// Radius of the window over which a Gaussian blurs filter maps and curves, 0..=[`MAX_BLUR`] \[texels\];
    /// the nearest translucent depth becomes the window's. Default 0: no blur.
    pub blur: u32,
    /// Whether pictures of a scene get further maps of finer texels where coarse ones would show at edges of
    /// shadows. Default false; true for a scene file. A host passes views of its own.
    pub detail: bool,
    /// Whether lights with a size get as many texels and viewpoints as their penumbrae need. Default false;
    /// true for a scene file. A host chooses its own.
    pub soft_detail: bool,
    /// Texel capacity of the maps of lights with a size, past which [`Self::soft_detail`] adds nothing.
    /// Default 6 * 2^22: six faces of 2048 x 2048.
    pub soft_budget: u64,
    /// Smaller levels of the filter map, for a host that samples it, 0..=[`MAX_MIPS`]. Default 0.
    pub mips: u32,
}

impl ShadowSettings {
    /// Nodes (K) of the curves that receivers read; 0 if they read none.
    pub fn curve_nodes(&self) -> u32 {
        if self.receiver == Receiver::Curve { self.nodes } else { 0 }
    }

    /// The first field that is out of its range.
    pub(crate) fn problem(&self) -> Option<&'static str> {
        let biases = [self.bias.unwrap_or(0.0), self.slope_bias, self.normal_bias];
        let is_bias = |bias: &f32| bias.is_finite() && *bias >= 0.0;
        [
            (self.receiver == Receiver::Nearest || matches!(self.nodes, 4 | 8 | 16), {
                "a curve has 4, 8 or 16 nodes"
            }),
            (biases.iter().all(is_bias), "its biases must be finite and not negative"),
            (self.pair_budget <= MAX_PAIRS, "a pair budget is at most 67,108,864"),
            (self.blur <= MAX_BLUR, "a blur reaches 16 texels at most"),
            (self.mips <= MAX_MIPS, "a filter map has 4 smaller levels at most"),
        ]
        .into_iter()
        .find_map(|(is_met, problem)| (!is_met).then_some(problem))
        .or_else(|| self.filter.problem())
    }
}

impl Default for ShadowSettings {
    fn default() -> Self {
        Self {
            size: 1024,
            receiver: Receiver::Curve,
            nodes: 8,
            filter: ShadowFilter::Spline,
            bias: None,
            slope_bias: 0.0,
            normal_bias: 1.5,
            pair_budget: MAX_PAIRS,
            texel_budget: 1 << 27,
            curve_budget: 1 << 31,
            curve_memory: CurveMemory::Whole,
            soften: false,
            colored: false,
            blur: 0,
            detail: false,
            soft_detail: false,
            soft_budget: 6 << 22,
            mips: 0,
        }
    }
}

/// The `[air]` table of a scene: homogeneous air that scatters light once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Air {
    /// Scattering coefficient: linear rgb, 0 or more [1/m]. Default 0.05.
    pub scattering: glam::Vec3,
    /// Extinction coefficient: linear rgb, 0 or more [1/m]. Real air has at least its scattering
    /// coefficient; with less, shafts are seen without a veil. Default 0.05.
    pub extinction: glam::Vec3,
    /// Share of the ambient light that is scattered too, 0..=1. Default 1.
    pub ambient: f32,
    /// Anisotropy `g` (Henyey and Greenstein 1941): 0 isotropic, towards 1 forward. Default 0.3.
    pub anisotropy: f32,
    /// Slices from the eye to the scene's end, 1..=[`MAX_AIR_STEPS`]. Default 64.
    pub steps: u32,
}

impl Default for Air {
    fn default() -> Self {
        let density = glam::Vec3::splat(0.05);
        Self { scattering: density, extinction: density, ambient: 1.0, anisotropy: 0.3, steps: 64 }
    }
}

/// Most slices of the air: layers of a texture that every device has.
pub const MAX_AIR_STEPS: u32 = 256;

/// The `[clusters]` table of a scene: the froxels of the camera's lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClusterSettings {
    /// Edge of a cluster on the screen \[pixels\], 16..=256. Default 32.
    pub tile: u32,
    /// Slices in depth, 1..=64. Default 24.
    pub slices: u32,
    /// End of the first slice \[m\]; a hundredth of the camera's far plane when `None`.
    pub near: Option<f32>,
    /// Capacity of the light lists of all clusters together; clusters past it are shaded with all lights.
    /// 0: all clusters are. Default 2^22, of 4 bytes each.
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

/// Largest edge of a map: a tile's coordinates must fit 8 bits \[texels\].
pub const MAX_MAP_SIZE: u32 = 4096;
/// Smallest edge of a map: one tile \[texels\].
pub const MIN_MAP_SIZE: u32 = 16;

/// Largest pair capacity of one batch: the size of a sort's textures.
pub const MAX_PAIRS: u32 = 1 << 26;

/// Widest blur of maps \[texels\].
pub const MAX_BLUR: u32 = 16;
/// Standard deviations from the middle of a blur's window to its end.
pub const BLUR_DEVIATIONS: f32 = 2.0;
/// Most smaller levels of a filter map: in the last, a tile is one texel.
pub const MAX_MIPS: u32 = 4;
