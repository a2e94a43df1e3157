//! Shadow masks: per pixel of the picture, the light that each light still sends there.

/// The `[mask]` table of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaskSettings {
    /// Whether masks have half the picture's width and height.
    pub half: bool,
    /// Pixels of a mask that its blur asks along each axis: odd, 3..=15; 1 for none.
    pub taps: u32,
    /// Distance from the eye up to which the blur is as wide as its taps; farther away it narrows with the
    /// distance [m]. 0: as wide everywhere.
    pub depth_scale: f32,
    /// How far off a pixel's plane another surface counts no more: one over a share of the distance from
    /// the eye.
    pub sensitivity: f32,
    /// Masks of a picture, at most; lights beyond are shaded without one, and counted.
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
        Self { half: false, taps: 7, depth_scale: 0.0, sensitivity: 100.0, limit: 16 }
    }
}
