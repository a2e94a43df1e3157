//! `gobo info`: adapters, limits, tiers and their reasons.
use super::{arguments::InfoArguments, contents, failure::Failure, files, trial};
use gobo::{
    Error,
    gpu::{Backend, Selection, TierChoice, adapters, all_adapters, shortcoming, unusable_adapter},
    wgpu,
};
use serde::Serialize;
use std::{collections::BTreeMap, fmt::Write as _};

/// The figures are in benches/NOTES.md.
const ADVICE: &str = "a software adapter compiles each scene's kernels for seconds, once: \
     --backend cpu is quicker for one picture of thousands of casters and a few lights";

#[derive(Serialize)]
struct InfoReport {
    version: &'static str,
    /// Adapters, the default of `gobo render` first.
    adapters: Vec<AdapterEntry>,
}

#[derive(Serialize)]
struct AdapterEntry {
    name: String,
    backend: String,
    device_type: String,
    driver: String,
    chosen: bool,
    tier: &'static str,
    reason: String,
    /// Reason why the adapter cannot be used at all.
    #[serde(skip_serializing_if = "Option::is_none")]
    unusable: Option<String>,
    /// Faster alternative to this adapter, and its conditions.
    #[serde(skip_serializing_if = "Option::is_none")]
    advice: Option<&'static str>,
    subgroup_size: [u32; 2],
    limits: BTreeMap<&'static str, u64>,
    /// Features that are requested when the device is opened.
    features: Vec<&'static str>,
}

pub(crate) fn run(arguments: &InfoArguments) -> Result<(), Failure> {
    let (device, json) = (&arguments.device, arguments.json);
    if arguments.formats {
        return contents::formats(json);
    }
    if let Some(file) = &arguments.file {
        return contents::file(file, json);
    }
    if device.backend() == Backend::Cpu {
        let message =
            "gobo info is about adapters, and the CPU reference has none: leave --backend cpu out";
        return Err(Failure::Usage(message.to_owned()));
    }
    if arguments.tries {
        return trial::run(device, json);
    }
    let found = match (device.backend(), &device.adapter) {
        (Backend::Auto, None) => all_adapters(),
        (backend, adapter) => {
            adapters(&Selection { backend, adapter: adapter.clone(), tier: None })
        }
    };
    let lacking: Vec<_> = found
        .iter()
        .filter_map(|adapter| Some(unusable_adapter(&adapter.get_info(), &shortcoming(adapter)?)))
        .collect();
    let mut adapters: Vec<_> = found.iter().map(describe).collect();
    if let Some(first) = adapters.first_mut().filter(|first| first.unusable.is_none()) {
        first.chosen = true;
    }
    let report = InfoReport { version: env!("CARGO_PKG_VERSION"), adapters };
    if json {
        files::print(&serde_json::to_string_pretty(&report).expect("plain data is JSON"))?;
    } else {
        files::print(text(&report).trim_end())?;
    }
    if report.adapters.iter().any(|adapter| adapter.chosen) {
        return Ok(());
    }
    if lacking.is_empty() {
        let wanted = device.adapter.clone();
        let others = wanted.iter().flat_map(|_| all_adapters());
        let found = others.map(|adapter| adapter.get_info().name).collect();
        return Err(Error::Adapter { wanted, found }.into());
    }
    Err(Error::Unusable(lacking).into())
}

fn describe(adapter: &wgpu::Adapter) -> AdapterEntry {
    let info = adapter.get_info();
    let choice = TierChoice::new(&Selection::default(), adapter);
    let limits = &choice.limits;
    AdapterEntry {
        name: info.name,
        backend: info.backend.to_string(),
        device_type: format!("{:?}", info.device_type),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        chosen: false,
        tier: choice.tier.name(),
        reason: choice.reason,
        unusable: shortcoming(adapter).map(|error| error.to_string()),
        advice: (info.device_type == wgpu::DeviceType::Cpu).then_some(ADVICE),
        subgroup_size: [info.subgroup_min_size, info.subgroup_max_size],
        limits: [
            ("max_storage_buffer_binding_size", limits.max_storage_buffer_binding_size),
            ("max_buffer_size", limits.max_buffer_size),
            ("max_texture_dimension_2d", limits.max_texture_dimension_2d.into()),
            ("max_texture_array_layers", limits.max_texture_array_layers.into()),
            (
                "max_storage_buffers_per_shader_stage",
                limits.max_storage_buffers_per_shader_stage.into(),
            ),
            (
                "max_storage_textures_per_shader_stage",
                limits.max_storage_textures_per_shader_stage.into(),
            ),
            (
                "max_compute_workgroup_storage_size",
                limits.max_compute_workgroup_storage_size.into(),
            ),
            (
                "max_compute_invocations_per_workgroup",
                limits.max_compute_invocations_per_workgroup.into(),
            ),
            (
                "max_compute_workgroups_per_dimension",
                limits.max_compute_workgroups_per_dimension.into(),
            ),
        ]
        .into(),
        features: choice.features.iter_names().map(|(name, _)| name).collect(),
    }
}

fn text(report: &InfoReport) -> String {
    let mut text = format!("gobo {}\n", report.version);
    for adapter in &report.adapters {
        let mark = if adapter.chosen { "* " } else { "  " };
        let [min, max] = adapter.subgroup_size;
        let features = if adapter.features.is_empty() {
            "none".to_owned()
        } else {
            adapter.features.join(", ")
        };
        // Writing to a string does not fail.
        let _ =
            writeln!(text, "{mark}{} ({}, {})", adapter.name, adapter.backend, adapter.device_type);
        let _ = writeln!(text, "    driver    {}", adapter.driver);
        let _ = writeln!(text, "    tier      {}", adapter.reason);
        let _ = writeln!(text, "    features  {features}");
        if let Some(advice) = adapter.advice.filter(|_| adapter.chosen) {
            let _ = writeln!(text, "    advice    {advice}");
        }
        let _ = writeln!(text, "    subgroups of {min} to {max}");
        for (name, value) in &adapter.limits {
            let _ = writeln!(text, "    {name:<38} {value}");
        }
        if let Some(reason) = &adapter.unusable {
            let _ = writeln!(text, "    unusable: {reason}");
        }
    }
    if report.adapters.is_empty() {
        text.push_str("no adapters\n");
    } else {
        text.push_str("* is what `gobo render` uses; limits and features are those it asks for\n");
    }
    text
}
