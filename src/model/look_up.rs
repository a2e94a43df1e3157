//! How receivers read the maps of a light.

/// The texels around a receiver that are asked, each for itself, and how much each counts: what is opaque
/// and what tints alike.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ShadowFilter {
    /// The texel that the receiver is in.
    None,
    /// 2 x 2, as hardware blends them.
    Bilinear,
    /// 3 x 3, by a quadratic B-spline: it has no stairs.
    #[default]
    Spline,
    /// A box of `taps` x `taps` bilinear taps, which are `taps + 1` texels a side.
    Pcf {
        /// 2..=[`ShadowFilter::MAX_PCF`].
        taps: u32,
    },
    /// Texels evenly over a disc (Vogel 1979), turned for each pixel of a picture.
    Vogel {
        /// 1..=[`ShadowFilter::MAX_VOGEL`].
        taps: u32,
        /// Radius of the disc [texels], kept in 1/256: 0..=[`ShadowFilter::MAX_RADIUS`].
        radius: f32,
    },
}

impl ShadowFilter {
    /// Most bilinear taps a side.
    pub const MAX_PCF: u32 = 11;
    /// Most texels of a disc.
    pub const MAX_VOGEL: u32 = 64;
    /// Largest radius of a disc [texels].
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

/// How receivers read a light's maps, where that is not as [`ShadowSettings`](super::ShadowSettings) say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LookUp {
    /// As [`super::ShadowSettings::filter`].
    pub filter: Option<ShadowFilter>,
    /// As [`super::ShadowSettings::bias`] [m].
    pub bias: Option<f32>,
    /// As [`super::ShadowSettings::slope_bias`] [texels].
    pub slope_bias: Option<f32>,
    /// As [`super::ShadowSettings::normal_bias`] [texels].
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
