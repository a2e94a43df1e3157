//! Dither patterns, and the window over which their coverage equals the opacity.
use super::{Material, Transfer};

/// Pattern by which a `dither` caster chooses the texels that it blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Pattern {
    /// A mask of 4x4 cells in 16 levels, chosen once per caster by its opacity.
    Checkerboard,
    /// Ordered dither of 2x2 cells (Bayer 1973).
    Bayer2,
    /// Ordered dither of 4x4 cells.
    Bayer4,
    /// Ordered dither of 8x8 cells.
    #[default]
    Bayer8,
    /// Ordered dither of 16x16 cells.
    Bayer16,
    /// Interleaved gradient noise (Jimenez 2014).
    Ign,
    /// Void and cluster (Ulichney 1993), 64x64 cells.
    Blue,
    /// Hashed alpha testing, anchored in the caster's own space (Wyman and McGuire 2017).
    Hashed,
}

impl Pattern {
    /// All patterns.
    pub const ALL: [Self; 8] = [
        Self::Checkerboard,
        Self::Bayer2,
        Self::Bayer4,
        Self::Bayer8,
        Self::Bayer16,
        Self::Ign,
        Self::Blue,
        Self::Hashed,
    ];

    /// Name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Checkerboard => "checkerboard",
            Self::Bayer2 => "bayer2",
            Self::Bayer4 => "bayer4",
            Self::Bayer8 => "bayer8",
            Self::Bayer16 => "bayer16",
            Self::Ign => "ign",
            Self::Blue => "blue",
            Self::Hashed => "hashed",
        }
    }

    /// Base-2 logarithm of the edge of an ordered pattern.
    pub fn order(self) -> u32 {
        match self {
            Self::Bayer2 => 1,
            Self::Checkerboard | Self::Bayer4 => 2,
            Self::Bayer8 => 3,
            Self::Bayer16 => 4,
            Self::Ign | Self::Blue | Self::Hashed => 0,
        }
    }

    /// Levels of an ordered pattern; noise has none.
    pub fn levels(self) -> Option<u32> {
        (self.order() > 0).then(|| 1 << (2 * self.order()))
    }

    /// Edge of the window over which the coverage of the pattern equals its opacity \[cells\].
    pub fn window(self) -> u32 {
        match self {
            Self::Ign | Self::Blue => 8,
            // Its own cells are up to 2.83 of these cells wide.
            Self::Hashed => 16,
            _ => 1 << self.order(),
        }
    }
}

/// Largest [`Material::pattern_scale`] \[texels\].
pub const MAX_SCALE: u32 = 64;

/// Widest [`window`] \[texels\].
pub const MAX_WINDOW: u32 = 64;

/// Edge of the window over which the coverage of every dithered material equals its opacity \[texels\], even;
/// 0 if no material is dithered.
pub fn window(materials: &[Material]) -> u32 {
    let dithered = materials.iter().filter(|material| material.transfer == Transfer::Dither);
    let windows = dithered.map(|material| material.pattern.window() * material.pattern_scale);
    windows.max().unwrap_or(0).min(MAX_WINDOW)
}
