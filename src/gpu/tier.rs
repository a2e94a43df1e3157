//! Tiers of kernels.
use wgpu::{Features, Limits};

/// Most lanes of a subgroup: kernels read as many of a ballot.
pub(crate) const MAX_LANES: u32 = 64;

/// Set of device features that kernels use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Tier {
    /// WebGPU's own limits and features.
    #[default]
    Core,
    /// WebGPU's own limits, and `SUBGROUP`.
    Subgroups,
    /// `SUBGROUP` and `TEXTURE_ATOMIC`; kernels for software adapters also
    /// [`FETCH_FEATURES`](super::FETCH_FEATURES).
    Native,
}

/// Where kernels read and write records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordForm {
    /// In buffers.
    Buffers,
    /// In textures. Casters that kernels write are copied there.
    Textures,
}

impl Tier {
    /// Every tier, core first.
    pub const ALL: &'static [Self] = &[Self::Core, Self::Subgroups, Self::Native];

    /// Tiers of kernels that differ only in their walks.
    pub const BY_SUBGROUPS: &'static [Self] = &[Self::Core, Self::Subgroups];
    /// Tiers of kernels that differ only in their sums.
    pub(crate) const BY_ATOMICS: &'static [Self] = &[Self::Core, Self::Native];

    /// The best tier that a device of `adapter` can be opened for.
    pub fn of(adapter: &wgpu::Adapter) -> Self {
        let lanes = adapter.get_info().subgroup_max_size;
        Self::with(adapter.features(), &adapter.limits(), lanes)
    }

    /// The best tier for these features and limits, and subgroups of so many lanes at most.
    fn with(features: Features, limits: &Limits, lanes: u32) -> Self {
        let can = |tier: Self| {
            features.contains(tier.features())
                && (!tier.has_subgroups() || lanes <= MAX_LANES)
                && tier.storage_textures() <= limits.max_storage_textures_per_shader_stage
        };
        Self::best(can).unwrap_or_default()
    }

    /// The best tier that a device `can` run.
    pub(crate) fn best(can: impl Fn(Self) -> bool) -> Option<Self> {
        Self::ALL.iter().rev().copied().find(|&tier| can(tier))
    }

    /// `core`, `subgroups` or `native`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Core => "core",
            Self::Subgroups => "subgroups",
            Self::Native => "native",
        }
    }

    /// Features that kernels use, all of which a device must have.
    pub const fn features(self) -> Features {
        match self {
            Self::Core => Features::empty(),
            Self::Subgroups => Features::SUBGROUP,
            Self::Native => Features::SUBGROUP.union(Features::TEXTURE_ATOMIC),
        }
    }

    /// Whether kernels use subgroups.
    pub const fn has_subgroups(self) -> bool {
        self.features().contains(Features::SUBGROUP)
    }

    /// Whether kernels use atomics on textures.
    pub const fn has_texture_atomics(self) -> bool {
        self.features().contains(Features::TEXTURE_ATOMIC)
    }

    /// Most storage textures that a kernel binds.
    pub const fn storage_textures(self) -> u32 {
        match self {
            // WebGPU guarantees these.
            Self::Core | Self::Subgroups => 4,
            Self::Native => 9,
        }
    }
}

impl std::fmt::Display for Tier {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn features_and_limits_choose_the_tier() {
        let [few, many] = [8, 9].map(|max_storage_textures_per_shader_stage| Limits {
            max_storage_textures_per_shader_stage,
            ..Limits::default()
        });
        for (features, limits, lanes, tier) in [
            (Features::empty(), &many, 32, Tier::Core),
            (Features::TEXTURE_ATOMIC, &many, 32, Tier::Core),
            (Features::SUBGROUP, &many, 4, Tier::Subgroups),
            (Features::SUBGROUP, &many, 128, Tier::Core),
            (Tier::Native.features(), &few, 32, Tier::Subgroups),
            (Tier::Native.features(), &many, 64, Tier::Native),
            (Tier::Native.features(), &many, 128, Tier::Core),
        ] {
            assert_eq!(Tier::with(features, limits, lanes), tier, "{features:?}, {lanes} lanes");
        }
    }
}
