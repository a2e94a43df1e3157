//! Shadow look-up of a light: filter and biases.

/// Shadow filter: the texels around a receiver that are compared, each on its own, and their weights. The
/// same for opaque and translucent casters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ShadowFilter {
    /// The receiver's own texel.
    None,
    /// 2 x 2 texels, weighted as in hardware PCF.
    Bilinear,
    /// 3 x 3 texels, weighted by a quadratic B-spline: no visible texel steps.
    #[default]
    Spline,
    /// A box of `taps` x `taps` bilinear taps, which are `taps + 1` texels a side.
    Pcf {
        /// Bilinear taps per side, 2..=[`ShadowFilter::MAX_PCF`].
        taps: u32,
    },
    /// A Vogel disc of texels (Vogel 1979), rotated per pixel of a picture.
    Vogel {
        /// Number of texels, 1..=[`ShadowFilter::MAX_VOGEL`].
        taps: u32,
        /// Radius of the disc \[texels\], kept in 1/256: 0..=[`ShadowFilter::MAX_RADIUS`].
        radius: f32,
    },
}

impl ShadowFilter {
    /// Most bilinear taps per side.
    pub const MAX_PCF: u32 = 11;
    /// Most texels of a disc.
    pub const MAX_VOGEL: u32 = 64;
    /// Largest radius of a disc \[texels\].
    pub const MAX_RADIUS: f32 = 32.0;

    pub(super) fn problem(&self) -> Option<&'static str> {
        let is_valid = match *self {
            Self::None | Self::Bilinear | Self::Spline => true,
            Self::Pcf { taps } => (2..=Self::MAX_PCF).contains(&taps),
            Self::Vogel { taps, radius } => {
                (1..=Self::MAX_VOGEL).contains(&taps) && (0.0..=Self::MAX_RADIUS).contains(&radius)
            }
        };
        (!is_valid).then_some("the taps or the radius of its filter are out of range")
    }
}

/// Shadow look-up of one light, where it differs from [`ShadowSettings`](super::ShadowSettings).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LookUp {
    /// Replaces [`super::ShadowSettings::filter`].
    pub filter: Option<ShadowFilter>,
    /// Replaces [`super::ShadowSettings::bias`] \[m\].
    pub bias: Option<f32>,
    /// Replaces [`super::ShadowSettings::slope_bias`] \[texels\].
    pub slope_bias: Option<f32>,
    /// Replaces [`super::ShadowSettings::normal_bias`] \[texels\].
    pub normal_bias: Option<f32>,
}

impl LookUp {
    pub(super) fn problem(&self) -> Option<&'static str> {
        let biases = [self.bias, self.slope_bias, self.normal_bias];
        let is_valid = |bias: &f32| bias.is_finite() && *bias >= 0.0;
        if !biases.iter().flatten().all(is_valid) {
            return Some("its biases must be finite and not negative");
        }
        self.filter.as_ref().and_then(ShadowFilter::problem)
    }
}
