//! Features and limits that a device must be opened with, and those that it lacks: none can be added later.
use super::{Tier, adapter::FETCH_FEATURES, tier::MAX_LANES};
use crate::{
    error::Error,
    model::{ShadowSettings, TILE_SIZE, tiles_of},
};
use glam::UVec2;
use std::fmt;
use wgpu::{AdapterInfo, Device, DeviceType, Features, Limits};

/// Features and limits of a device, compared with what shadows need.
///
/// ```ignore
/// let support = Support::of(&device, &adapter_info, &settings);
/// support.check(Tier::Core)?;
/// support.missing.iter().for_each(|missing| println!("{missing}"));
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Support {
    /// The best tier that the device can run; `None` if it can run none.
    pub tier: Option<Tier>,
    /// All that it lacks, most important first. If [`Self::tier`] is `Native`, only optional ones.
    pub missing: Vec<Missing>,
}

/// A feature or limit that a device was opened without.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Missing {
    /// The feature, or the limit.
    pub requirement: Requirement,
    /// Purpose of the requirement.
    pub needed_for: Need,
}

/// A feature or limit of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Requirement {
    /// One feature.
    Feature(Features),
    /// A limit, by the name of its field in [`wgpu::Limits`] or [`wgpu::AdapterInfo`].
    Limit {
        /// The field's name.
        name: &'static str,
        /// Value that the device was opened with.
        have: u64,
        /// Least value needed; for an alignment and the lanes of a subgroup, the greatest.
        need: u64,
    },
}

/// Purpose of a feature or limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Need {
    /// Every kernel.
    Core,
    /// Maps of the size in the settings.
    Maps,
    /// Tiers with subgroups, which are faster.
    Subgroups,
    /// The native tier, which is faster still.
    Native,
    /// The faster walk of soft discs on software adapters.
    SoftDiscs,
    /// Timings of stages ([`Prepared::record_timed`](crate::Prepared::record_timed)).
    Times,
}

impl Support {
    /// Reads the device's features and limits. `adapter`: the device's.
    pub fn of(device: &Device, adapter: &AdapterInfo, settings: &ShadowSettings) -> Self {
        let mut all = missing(device, Tier::Native);
        let tier = Tier::best(|tier| !all.iter().any(|it| it.hinders(tier)));
        let mut ask = |limit_of: Limits, needed_for| {
            limit_of.check_limits_with_fail_fn(&device.limits(), false, |name, need, have| {
                let requirement = Requirement::Limit { name, have, need };
                if all.iter().all(|known| !known.is_of(name)) {
                    all.push(Missing { requirement, needed_for });
                }
            });
        };
        ask(settings.limits(Tier::Core, settings.size), Need::Maps);
        let mut wish = |features: Features, needed_for| {
            let lacking = features - device.features();
            all.extend(
                lacking
                    .iter()
                    .map(|one| Missing { requirement: Requirement::Feature(one), needed_for }),
            );
        };
        if adapter.device_type == DeviceType::Cpu {
            wish(FETCH_FEATURES, Need::SoftDiscs);
        }
        wish(Features::TIMESTAMP_QUERY, Need::Times);
        all.sort_by_key(|missing| missing.needed_for);
        Self { tier, missing: all }
    }

    /// Whether the device can run `tier`.
    ///
    /// # Errors
    /// If it cannot, with all that it lacks for it.
    pub fn check(&self, tier: Tier) -> Result<(), Error> {
        let missing: Vec<_> = self.missing.iter().filter(|it| it.hinders(tier)).copied().collect();
        if missing.is_empty() { Ok(()) } else { Err(Error::Unsupported { tier, missing }) }
    }
}

impl ShadowSettings {
    /// Features to open a device with for `tier`. [`Support::of`] names the optional ones, for speed or for
    /// timings.
    pub fn features(&self, tier: Tier) -> Features {
        tier.features()
    }

    /// Limits to open a device with for `tier`, if no map's edge exceeds `largest_map` \[texels\]. A device
    /// with higher limits allows larger capacities for casters and pairs.
    pub fn limits(&self, tier: Tier, largest_map: u32) -> Limits {
        let mut limits = Limits::default();
        let edge = tiles_of(UVec2::splat(largest_map)).max_element().saturating_mul(TILE_SIZE);
        limits.max_texture_dimension_2d = limits.max_texture_dimension_2d.max(edge);
        // A map has all layers of its curve in one array.
        let layers = self.curve_nodes() / 2;
        limits.max_texture_array_layers = limits.max_texture_array_layers.max(layers);
        limits.max_storage_textures_per_shader_stage = tier.storage_textures();
        limits
    }
}

/// Whether the device is still usable: buffers made on a lost device cannot be written.
pub(crate) fn check_alive(device: &Device) -> Result<(), Error> {
    let probe = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("probe"),
        size: wgpu::COPY_BUFFER_ALIGNMENT,
        // A buffer of this usage is mapped without another buffer beside it.
        usage: wgpu::BufferUsages::MAP_WRITE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: true,
    });
    let mapped = probe.get_mapped_range_mut(..).map(|_| ());
    mapped.map_err(|error| Error::Lost(error.to_string()))
}

/// Features of a device; wgpu 30 does not see the subgroups of a browser's device.
fn features(device: &Device) -> Features {
    #[cfg(all(target_arch = "wasm32", feature = "webgpu"))]
    if device.as_webgpu().is_some_and(|device| device.features().has("subgroups")) {
        return device.features() | Features::SUBGROUP;
    }
    device.features()
}

/// Features and limits that the device lacks for a tier, whatever the settings are.
pub(crate) fn missing(device: &Device, tier: Tier) -> Vec<Missing> {
    let mut all = Vec::new();
    let limits = device.limits();
    Limits::default().check_limits_with_fail_fn(&limits, false, |name, need, have| {
        let requirement = Requirement::Limit { name, have, need };
        all.push(Missing { requirement, needed_for: Need::Core });
    });
    let lanes = device.adapter_info().subgroup_max_size;
    if tier.has_subgroups() && lanes > MAX_LANES {
        let (have, need) = (lanes.into(), MAX_LANES.into());
        let requirement = Requirement::Limit { name: "subgroup_max_size", have, need };
        all.push(Missing { requirement, needed_for: Need::Subgroups });
    }
    for feature in (tier.features() - features(device)).iter() {
        let requirement = Requirement::Feature(feature);
        let is_subgroups = Tier::Subgroups.features().contains(feature);
        let needed_for = if is_subgroups { Need::Subgroups } else { Need::Native };
        all.push(Missing { requirement, needed_for });
    }
    let (have, need) = (limits.max_storage_textures_per_shader_stage, tier.storage_textures());
    if tier == Tier::Native && have < need {
        let name = "max_storage_textures_per_shader_stage";
        let requirement = Requirement::Limit { name, have: have.into(), need: need.into() };
        all.push(Missing { requirement, needed_for: Need::Native });
    }
    all
}

impl Missing {
    /// Whether a device cannot run `tier` without it.
    fn hinders(&self, tier: Tier) -> bool {
        match self.needed_for {
            Need::Core | Need::Maps => true,
            Need::Subgroups => tier.has_subgroups(),
            Need::Native => tier == Tier::Native,
            Need::SoftDiscs | Need::Times => false,
        }
    }

    fn is_of(&self, limit: &str) -> bool {
        matches!(self.requirement, Requirement::Limit { name, .. } if name == limit)
    }
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.requirement {
            Requirement::Feature(feature) => {
                let names = feature.iter_names().map(|(name, _)| name);
                write!(f, "the feature {}", names.collect::<Vec<_>>().join(", "))?;
            }
            Requirement::Limit { name, have, need } => {
                write!(f, "the limit {name}, which is {have} and must be {need},")?;
            }
        }
        write!(f, " for {}", self.needed_for)
    }
}

impl fmt::Display for Need {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Core => "every kernel",
            Self::Maps => "maps of this size",
            Self::Subgroups => "tiers with subgroups",
            Self::Native => "the native tier",
            Self::SoftDiscs => "a faster walk of soft discs on software adapters",
            Self::Times => "times of stages",
        })
    }
}
