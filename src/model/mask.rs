//! Shadow masks: per pixel of the picture, the share of each light that arrives there.

/// The `[mask]` table of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaskSettings {
    /// Whether masks have half the picture's width and height. Default false.
    pub half: bool,
    /// Taps of the mask's blur along each axis: odd, 3..=15; 1 for no blur. Default 7.
    pub taps: u32,
    /// Distance from the eye up to which the blur has its full width \[m\]; beyond, it narrows with distance.
    /// 0, the default: full width everywhere.
    pub depth_scale: f32,
    /// Whether the blur narrows along the directions in which a surface is slanted on the screen, so that it
    /// spans the same distances on a floor seen at a grazing angle as on a wall that faces the eye. Default
    /// false.
    pub anisotropic: bool,
    /// Edge-stopping strength of the blur: the reciprocal of the distance from a pixel's plane beyond which
    /// another surface does not count, as a share of the distance from the eye; above 0. Default 100.
    pub sensitivity: f32,
    /// Most masks of a picture; further lights are shaded without one, and counted.
    /// 1..=64. Default 16.
    pub limit: u32,
}

impl MaskSettings {
    /// Most taps of a blur.
    pub const MAX_TAPS: u32 = 15;
    /// Most masks: a mask of 4,096 x 4,096 pixels takes 64 MiB.
    pub const MAX_LIMIT: u32 = 64;
}

impl Default for MaskSettings {
    fn default() -> Self {
        Self {
            half: false,
            taps: 7,
            depth_scale: 0.0,
            anisotropic: false,
            sensitivity: 100.0,
            limit: 16,
        }
    }
}
