//! Choice of the adapter and the tier.
use super::tier::Tier;
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

/// Wanted adapter, and the highest tier allowed.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Interface of the adapter.
    pub backend: Backend,
    /// Part of the adapter's name; case does not matter.
    pub adapter: Option<String>,
    /// Forces the tier; otherwise the environment variable `GOBO_TIER`, otherwise the best.
    pub tier: Option<Tier>,
}

/// Features that kernels of [`Tier::Native`] use: an adapter must have all of them.
pub const NATIVE_FEATURES: Features = Features::SUBGROUP.union(Features::TEXTURE_ATOMIC);

/// Most storage textures that a kernel of [`Tier::Native`] binds: more than WebGPU guarantees.
pub const NATIVE_STORAGE_TEXTURES: u32 = 9;

/// Most storage textures that a kernel of a tier binds.
pub(super) const fn max_storage_textures(tier: Tier) -> u32 {
    match tier {
        // WebGPU guarantees these.
        Tier::Core => 4,
        Tier::Native => NATIVE_STORAGE_TEXTURES,
    }
}

/// Features of the kernels for software adapters that prefetch: they read storage textures that they write.
pub const FETCH_FEATURES: Features = Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES;

/// Features that only measure: timers, and blending that the bench compares maps with.
const BENCH_FEATURES: Features = Features::TIMESTAMP_QUERY
    .union(Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)
    .union(Features::TIMESTAMP_QUERY_INSIDE_PASSES)
    .union(Features::FLOAT32_BLENDABLE);

/// A tier, the reason for it, and the features and limits to request for it.
#[derive(Clone, Debug)]
pub struct TierChoice {
    pub tier: Tier,
    /// `native: SUBGROUP, TEXTURE_ATOMIC` or `core: the adapter lacks ...`
    pub reason: String,
    pub features: Features,
    pub limits: Limits,
}

impl TierChoice {
    pub fn new(selection: &Selection, adapter: &wgpu::Adapter) -> Self {
        let available = adapter.features();
        let core = |reason: String| Self {
            tier: Tier::Core,
            reason: format!("core: {reason}"),
            features: Features::empty(),
            limits: Limits::default(),
        };
        match (selection.tier, std::env::var("GOBO_TIER").as_deref()) {
            (Some(Tier::Core), _) => return core("as asked for".to_owned()),
            (None, Ok("core")) => return core("GOBO_TIER asks for it".to_owned()),
            _ => {}
        }
        let lacking = NATIVE_FEATURES - available;
        if !lacking.is_empty() {
            return core(format!("the adapter lacks {}", names(lacking)));
        }
        Self {
            tier: Tier::Native,
            reason: format!("native: {}", names(NATIVE_FEATURES)),
            features: available & (NATIVE_FEATURES | BENCH_FEATURES | fetch_features(adapter)),
            limits: raised(&adapter.limits()),
        }
    }
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

/// WebGPU's limits, with those that limit sizes or workgroups raised to the adapter's.
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
