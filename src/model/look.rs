//! Looks of a picture: tone curve, occlusion and lens.

/// Tone curve from light to the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
#[repr(u32)]
pub enum Tone {
    /// Khronos PBR Neutral (2024): colours as they are, only highlights are compressed.
    #[default]
    Neutral,
    /// No curve: light up to 1; brighter light is cut.
    Linear,
    /// A film's toe and shoulder for each channel, which turn bright colours white: Narkowicz 2015, "ACES
    /// Filmic Tone Mapping Curve".
    Filmic,
}

/// Occlusion of ambient light by the visible surfaces around a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Occlusion {
    /// No occlusion: ambient light comes from everywhere.
    #[default]
    None,
    /// By surfaces nearer than a tenth of the picture's height at the surface's distance.
    Usual,
    /// By surfaces nearer than this, above 0 \[m\].
    Radius(f32),
}

/// Lens of a camera: it blurs what is out of focus.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lens {
    /// Radius \[m\]; 0, the default: everything is sharp.
    pub radius: f32,
    /// Distance of the focal plane along the axis \[m\]; the target's when `None`.
    pub focus: Option<f32>,
}
