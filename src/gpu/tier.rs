//! Tiers of kernels.

/// Set of device features that kernels use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Tier {
    /// WebGPU's own limits and features.
    #[default]
    Core,
    /// `SUBGROUP` and `TEXTURE_ATOMIC`; kernels for software adapters also
    /// [`FETCH_FEATURES`](super::FETCH_FEATURES).
    Native,
}

impl Tier {
    /// Every tier, core first.
    pub const ALL: &'static [Self] = &[Self::Core, Self::Native];

    /// `core` or `native`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Core => "core",
            Self::Native => "native",
        }
    }
}

impl std::fmt::Display for Tier {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
