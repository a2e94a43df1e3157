//! How a picture looks.

/// Tone curve from light to the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
#[repr(u32)]
pub enum Tone {
    /// Khronos PBR Neutral (2024): colours as they are, only highlights are compressed.
    #[default]
    Neutral,
    /// None: light up to 1, the rest is cut.
    Linear,
    /// A film's toe and shoulder for each channel, by which bright colours turn white: Narkowicz 2015, "ACES
    /// Filmic Tone Mapping Curve".
    Filmic,
}

/// Occlusion of ambient light by what is seen around a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Occlusion {
    /// None: ambient light comes from everywhere.
    #[default]
    None,
    /// By what is nearer than a tenth of the picture's height at the surface's distance.
    Usual,
    /// By what is nearer than this, above 0 \[m\].
    Radius(f32),
}

/// Lens of a camera: what is not at its distance is blurred.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lens {
    /// Radius \[m\]; 0, the default: all is sharp.
    pub radius: f32,
    /// Distance along the axis of what is sharp \[m\]; that of the target when `None`.
    pub focus: Option<f32>,
}
