//! Choice of the adapter and the tier.
use super::tier::{MAX_LANES, Tier};
use crate::error::Error;
use wgpu::{DeviceType, Features, Limits, TextureFormat, TextureUsages};

/// Graphics interface of the adapter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// The best adapter of any interface.
    #[default]
    Auto,
    /// Vulkan.
    Vulkan,
    /// Metal.
    Metal,
    /// Direct3D 12.
    Dx12,
    /// OpenGL and OpenGL ES.
    Gl,
    /// No adapter: the CPU reference.
    Cpu,
}

/// The wanted adapter, and the highest tier allowed.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Interface of the adapter.
    pub backend: Backend,
    /// Part of the adapter's name; case does not matter.
    pub adapter: Option<String>,
    /// Highest tier; otherwise the environment variable `GOBO_TIER` decides, otherwise the adapter's best.
    pub tier: Option<Tier>,
}

/// Features of the kernels for software adapters that prefetch: they read storage textures that they write.
pub const FETCH_FEATURES: Features = Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES;

/// Features for measurements only: timers, and the blending that the bench compares maps with.
const BENCH_FEATURES: Features = Features::TIMESTAMP_QUERY
    .union(Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)
    .union(Features::TIMESTAMP_QUERY_INSIDE_PASSES)
    .union(Features::FLOAT32_BLENDABLE);

/// A tier, the reason for it, and the features and limits to request for it.
#[derive(Clone, Debug)]
pub struct TierChoice {
    /// The highest tier of the adapter, or the requested one.
    pub tier: Tier,
    /// `native: TEXTURE_ATOMIC, SUBGROUP` or `subgroups: the adapter lacks ...`
    pub reason: String,
    /// Features to open the device with.
    pub features: Features,
    /// Limits to open the device with.
    pub limits: Limits,
}

impl TierChoice {
    /// The choice for an adapter.
    pub fn new(selection: &Selection, adapter: &wgpu::Adapter) -> Self {
        let (most, asked) = highest(selection);
        let tier = Tier::of(adapter).min(most);
        let available = adapter.features();
        let reason = if tier == Tier::Native {
            names(tier.features())
        } else if tier == most {
            asked.to_owned()
        } else {
            let lanes = adapter.get_info().subgroup_max_size;
            format!("the adapter lacks {}", lacking(available, &adapter.limits(), lanes))
        };
        let (features, limits) = match tier {
            Tier::Core => (Features::empty(), Limits::default()),
            Tier::Subgroups => (tier.features() | BENCH_FEATURES, raised(&adapter.limits())),
            Tier::Native => (
                tier.features() | BENCH_FEATURES | fetch_features(adapter),
                raised(&adapter.limits()),
            ),
        };
        Self { tier, reason: format!("{tier}: {reason}"), features: features & available, limits }
    }
}

/// The highest tier allowed, and the source of that limit.
fn highest(selection: &Selection) -> (Tier, &'static str) {
    if let Some(tier) = selection.tier {
        return (tier, "as asked for");
    }
    let Ok(name) = std::env::var("GOBO_TIER") else { return (Tier::Native, "") };
    let known = Tier::ALL.iter().find(|tier| tier.name() == name);
    #[cfg(feature = "device")]
    if known.is_none() {
        let names: Vec<_> = Tier::ALL.iter().map(|tier| tier.name()).collect();
        tracing::warn!("GOBO_TIER is `{name}`, no tier: it may be one of {}", names.join(", "));
    }
    (known.copied().unwrap_or(Tier::Native), "GOBO_TIER asks for it")
}

/// Features and limits that an adapter lacks for the best tier.
fn lacking(features: Features, limits: &Limits, lanes: u32) -> String {
    let need = Tier::Native.storage_textures();
    let has_few = limits.max_storage_textures_per_shader_stage < need;
    let lacking = [
        (!Tier::Native.features().difference(features).is_empty())
            .then(|| names(Tier::Native.features() - features)),
        has_few.then(|| format!("{need} storage textures a stage")),
        (lanes > MAX_LANES)
            .then(|| format!("subgroups of at most {MAX_LANES} lanes: its have up to {lanes}")),
    ];
    lacking.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

fn fetch_features(adapter: &wgpu::Adapter) -> Features {
    let format = adapter.get_texture_format_features(TextureFormat::Rgba16Float);
    let reads = format.flags.contains(wgpu::TextureFormatFeatureFlags::STORAGE_READ_WRITE);
    match adapter.get_info().device_type {
        DeviceType::Cpu if reads => FETCH_FEATURES,
        _ => Features::empty(),
    }
}

fn names(features: Features) -> String {
    features.iter_names().map(|(name, _)| name).collect::<Vec<_>>().join(", ")
}

/// WebGPU's limits, with those on sizes and workgroups raised to the adapter's.
fn raised(adapter: &Limits) -> Limits {
    let mut limits = Limits::default();
    macro_rules! raise {
        ($($limit:ident),* $(,)?) => {
            $(limits.$limit = limits.$limit.max(adapter.$limit);)*
        };
    }
    raise!(
        max_storage_buffer_binding_size,
        max_buffer_size,
        max_texture_dimension_2d,
        max_texture_array_layers,
        max_storage_buffers_per_shader_stage,
        max_storage_textures_per_shader_stage,
        max_sampled_textures_per_shader_stage,
        max_bindings_per_bind_group,
        max_compute_workgroup_storage_size,
        max_compute_invocations_per_workgroup,
        max_compute_workgroup_size_x,
        max_compute_workgroup_size_y,
        max_compute_workgroup_size_z,
        max_compute_workgroups_per_dimension,
    );
    limits
}

/// Formats of the storage textures that core kernels write: WebGPU guarantees them, GL does not.
pub const STORAGE_FORMATS: [TextureFormat; 7] = [
    TextureFormat::R32Float,
    TextureFormat::R32Uint,
    TextureFormat::Rg32Uint,
    TextureFormat::Rgba16Float,
    TextureFormat::Rgba8Unorm,
    TextureFormat::Rgba32Float,
    TextureFormat::Rgba32Uint,
];

/// Reason why an adapter cannot run even the core tier: no compute shaders, a missing storage format or the
/// first of WebGPU's limits that it does not meet.
pub fn shortcoming(adapter: &wgpu::Adapter) -> Option<Error> {
    let flags = adapter.get_downlevel_capabilities().flags;
    if !flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
        return Some(Error::Lacks("compute shaders".to_owned()));
    }
    let is_written = |format: &TextureFormat| {
        let usages = adapter.get_texture_format_features(*format).allowed_usages;
        usages.contains(TextureUsages::STORAGE_BINDING)
    };
    if let Some(format) = STORAGE_FORMATS.iter().find(|format| !is_written(format)) {
        return Some(Error::Lacks(format!("storage textures of {format:?}")));
    }
    missed_limit(&adapter.limits())
}

/// The first of WebGPU's limits that `limits` do not meet.
fn missed_limit(limits: &Limits) -> Option<Error> {
    let mut missed = None;
    Limits::default().check_limits_with_fail_fn(limits, true, |limit, need, have| {
        missed = Some(Error::Limit { limit, have, need, remedy: "choose another adapter" });
    });
    missed
}
