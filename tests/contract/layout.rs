//! Rust and WGSL agree on every shared struct and binding.
use crate::common::parse;
use gobo::{
    gpu::{Access, Binding, BindingKind, Choice, KernelDesc, Linked, Tier},
    records::{
        BounceParams, CasterRecord, ConvertParams, CullParams, EmissionParams, EmitterParams,
        GaussianAxes, GaussianLook, GpuArea, GpuEmitted, GpuLayout, GpuLight, GpuMaterial, GpuView,
        HostGridParams, HostGroup, HostView, ImportParams, LoadCounters, LoadParams, MaskParams,
    },
    stage::{
        bin::{BatchCounters, BinParams, PartParams, Segment},
        blur::BlurParams,
        caustics::CausticParams,
        levels::LevelParams,
        light_points::{PictureParams, PointBatch},
        load,
        project::{Chunk, ProjectParams},
        soften::SoftenParams,
        sort::{SERIAL_SCATTER, SortPass},
        tuning,
    },
    wgpu::{Limits, TextureFormat, TextureSampleType, TextureViewDimension},
};
use gobo_picture::stage::{shade::Band, variants};
use gobo_reference::records::{AirParams, ClusterCounters, ClusterParams};
use naga::{AddressSpace, ImageClass, ImageDimension, Module, StorageAccess, TypeInner};
use std::collections::BTreeSet;

/// `Ok(false)`: the module does not declare the struct.
type Check = fn(&Module) -> Result<bool, String>;

/// Every struct that both sides declare.
const STRUCTS: &[Check] = &[
    struct_agrees::<GpuView>,
    struct_agrees::<GpuMaterial>,
    struct_agrees::<CasterRecord>,
    struct_agrees::<GaussianAxes>,
    struct_agrees::<Chunk>,
    struct_agrees::<ProjectParams>,
    struct_agrees::<SortPass>,
    struct_agrees::<BinParams>,
    struct_agrees::<PartParams>,
    struct_agrees::<BatchCounters>,
    struct_agrees::<Segment>,
    struct_agrees::<AirParams>,
    struct_agrees::<BlurParams>,
    struct_agrees::<SoftenParams>,
    struct_agrees::<ClusterParams>,
    struct_agrees::<ClusterCounters>,
    struct_agrees::<GpuArea>,
    struct_agrees::<GpuLight>,
    struct_agrees::<CausticParams>,
    struct_agrees::<BounceParams>,
    struct_agrees::<LevelParams>,
    struct_agrees::<MaskParams>,
    struct_agrees::<HostView>,
    struct_agrees::<PictureParams>,
    struct_agrees::<Band>,
    struct_agrees::<PointBatch>,
    struct_agrees::<LoadParams>,
    struct_agrees::<GaussianLook>,
    struct_agrees::<HostGridParams>,
    struct_agrees::<HostGroup>,
    struct_agrees::<LoadCounters>,
    struct_agrees::<CullParams>,
    struct_agrees::<ImportParams>,
    struct_agrees::<ConvertParams>,
    struct_agrees::<EmissionParams>,
    struct_agrees::<EmitterParams>,
    struct_agrees::<GpuEmitted>,
];

/// The list is complete: the sources are searched for `gpu_struct!`.
#[test]
fn every_shared_struct_is_checked() {
    let folders = ["src", "crates/gobo-picture/src", "crates/gobo-reference/src"];
    let mut pending =
        folders.map(|folder| std::path::Path::new(crate::common::ROOT).join(folder)).to_vec();
    let mut count = 0;
    while let Some(path) = pending.pop() {
        if path.is_dir() {
            pending.extend(path.read_dir().unwrap().map(|entry| entry.unwrap().path()));
        } else {
            let text = std::fs::read_to_string(path).unwrap();
            let starts = ["\ncrate::records::gpu_struct! {", "\ngobo::gpu_struct! {"];
            count += starts.map(|start| text.matches(start).count()).iter().sum::<usize>();
        }
    }
    assert_eq!(count, STRUCTS.len());
}

fn layouter(module: &Module) -> naga::proc::Layouter {
    let mut layouter = naga::proc::Layouter::default();
    layouter.update(module.to_ctx()).expect("every type has a layout");
    layouter
}

fn struct_agrees<T: GpuLayout>(module: &Module) -> Result<bool, String> {
    let named = |(_, ty): &(_, &naga::Type)| ty.name.as_deref() == Some(T::NAME);
    let Some((_, ty)) = module.types.iter().find(named) else { return Ok(false) };
    let TypeInner::Struct { members, span } = &ty.inner else {
        return Err(format!("{} is not a struct", T::NAME));
    };
    let layouter = layouter(module);
    let wgsl: Vec<_> = members
        .iter()
        .map(|m| (m.name.clone().unwrap(), m.offset as usize, layouter[m.ty].size as usize))
        .collect();
    let rust: Vec<_> = T::fields().iter().map(|f| (f.name.to_owned(), f.offset, f.size)).collect();
    if wgsl != rust || *span as usize != T::SIZE {
        return Err(format!("{}\n wgsl {span} {wgsl:?}\n rust {} {rust:?}", T::NAME, T::SIZE));
    }
    Ok(true)
}

fn access(access: StorageAccess) -> Access {
    if access.contains(StorageAccess::ATOMIC) {
        return Access::Atomic;
    }
    match (access.contains(StorageAccess::LOAD), access.contains(StorageAccess::STORE)) {
        (_, false) => Access::Read,
        (false, true) => Access::Write,
        (true, true) => Access::ReadWrite,
    }
}

/// A binding in words, from either side, so that formats compare by name.
fn rust_binding(binding: &Binding) -> String {
    let kind = match binding.kind {
        BindingKind::Uniform => "uniform".to_owned(),
        BindingKind::Storage { access } => format!("{access:?} storage"),
        BindingKind::StorageTexture { access, format, dimension } => {
            format!("{access:?} texture {dimension:?} of {format:?}")
        }
        BindingKind::Texture { sample, dimension } => {
            let sample = match sample {
                TextureSampleType::Float { .. } => "Float",
                TextureSampleType::Uint => "Uint",
                TextureSampleType::Sint => "Sint",
                TextureSampleType::Depth => "Depth",
            };
            format!("texture {dimension:?} of {sample}")
        }
    };
    format!("{} {}: {kind}", binding.number, binding.name)
}

fn wgsl_binding(module: &Module, global: &naga::GlobalVariable) -> Option<String> {
    let binding = global.binding?;
    let kind = match (global.space, &module.types[global.ty].inner) {
        (AddressSpace::Uniform, _) => "uniform".to_owned(),
        (AddressSpace::Storage { access: allowed }, _) => {
            format!("{:?} storage", access(allowed))
        }
        (AddressSpace::Handle, &TypeInner::Image { dim, arrayed, class }) => {
            let dimension = match (dim, arrayed) {
                (ImageDimension::D2, false) => TextureViewDimension::D2,
                (ImageDimension::D2, true) => TextureViewDimension::D2Array,
                (ImageDimension::D3, _) => TextureViewDimension::D3,
                _ => panic!("{dim:?}"),
            };
            match class {
                ImageClass::Storage { format, access: allowed } => {
                    format!("{:?} texture {dimension:?} of {format:?}", access(allowed))
                }
                ImageClass::Sampled { kind, multi: false } => {
                    format!("texture {dimension:?} of {kind:?}")
                }
                other => format!("{other:?}"),
            }
        }
        other => format!("{other:?}"),
    };
    let name = global.name.as_deref().unwrap_or_default();
    Some(format!("{} {name}: {kind} of group {}", binding.binding, binding.group))
}

/// The host's bindings are exactly those that the entry point uses.
fn bindings_agree(linked: &Linked, module: &Module) -> Result<(), String> {
    let info = naga::valid::Validator::new(Default::default(), naga::valid::Capabilities::all())
        .subgroup_stages(naga::valid::ShaderStages::COMPUTE)
        .subgroup_operations(naga::valid::SubgroupOperationSet::all())
        .validate(module)
        .map_err(|error| format!("{:?}", error.into_inner()))?;
    let used = info.get_entry_point(0);
    let globals = module.global_variables.iter().filter(|&(global, _)| !used[global].is_empty());
    let mut wgsl: Vec<_> = globals.filter_map(|(_, global)| wgsl_binding(module, global)).collect();
    wgsl.sort();
    let bindings = linked.bindings().map_err(|error| error.to_string())?;
    let mut rust: Vec<_> =
        bindings.iter().map(|binding| rust_binding(binding) + " of group 0").collect();
    rust.sort();
    if wgsl == rust { Ok(()) } else { Err(format!("\n wgsl {wgsl:#?}\n rust {rust:#?}")) }
}

#[test]
fn structs_and_bindings_agree() {
    let mut declared = vec![false; STRUCTS.len()];
    for (desc, tier) in variants() {
        let (module, linked) = (parse(desc, tier), desc.link(tier).unwrap());
        bindings_agree(&linked, &module)
            .unwrap_or_else(|error| panic!("{} {tier:?}: {error}", desc.name));
        for (seen, check) in declared.iter_mut().zip(STRUCTS) {
            *seen |= check(&module).unwrap_or_else(|error| panic!("{}: {error}", desc.name));
        }
    }
    assert!(declared.iter().all(|&seen| seen), "a shared struct is in no kernel: {declared:?}");
}

/// Binding numbers by name, over every file of `wgsl/bind/`.
#[test]
fn a_resource_has_one_number_and_one_place() {
    let mut numbers = std::collections::BTreeMap::new();
    for item in gobo_picture::stage::library().unwrap().items() {
        let Some((_, number)) = item.text.split_once("@binding(") else { continue };
        assert!(item.file.starts_with("bind/"), "{} is bound in {}", item.name, item.file);
        let number: u32 = number.split(')').next().unwrap().parse().unwrap();
        let known = *numbers.entry(item.name).or_insert(number);
        assert_eq!(known, number, "{} in {}", item.name, item.file);
    }
    let mut taken: Vec<_> = numbers.values().collect();
    taken.sort();
    taken.dedup();
    assert_eq!(taken.len(), numbers.len(), "two resources have one number: {numbers:?}");
}

/// Kernels on each of their tiers, with records in buffers and in textures.
fn in_both_forms() -> impl Iterator<Item = ((&'static KernelDesc, Tier), &'static [Choice])> {
    variants().flat_map(|variant| [(variant, &[][..]), (variant, &tuning::IN_TEXTURES)])
}

/// WebGPU's limits per shader stage, except for the native tier's storage textures.
#[test]
fn bindings_are_few_enough() {
    for ((desc, tier), form) in in_both_forms() {
        let textures = tier.storage_textures() as usize;
        let bindings = desc.link_with(tier, form).unwrap().bindings().unwrap();
        let count = |of: fn(BindingKind) -> bool| {
            bindings.iter().filter(|binding| of(binding.kind)).count()
        };
        let name = desc.name;
        assert!(count(|kind| matches!(kind, BindingKind::Uniform)) <= 12, "{name}");
        assert!(count(|kind| matches!(kind, BindingKind::Storage { .. })) <= 8, "{name}");
        assert!(
            count(|kind| matches!(kind, BindingKind::StorageTexture { .. })) <= textures,
            "{name}"
        );
        assert!(count(|kind| matches!(kind, BindingKind::Texture { .. })) <= 16, "{name}");
    }
}

/// Texels of maps and their sums, of pixels, of air and of voxels, and pages of tiles.
const TEXELS: &[&str] = &[
    "air",
    "ambients",
    "behinds",
    "bends",
    "bloom_to",
    "colored",
    "curve_pages",
    "curves",
    "filter_mip",
    "filters",
    "first_surfaces",
    "half_surfaces",
    "kept_sums",
    "mask_points",
    "mask_surfaces",
    "near_around",
    "near_rows",
    "nearests",
    "nearness",
    "new_masks",
    "occlusions",
    "opaques",
    "radiance",
    "rows",
    "seen_pixels",
    "soft_filters",
    "soft_nearests",
    "soft_opaques",
    "sources",
    "sum_blue",
    "sum_green",
    "sum_red",
    "voxels",
];

/// Records that are in textures on every device.
const IN_TEXTURES: &[&str] = &["clusters", "layers", "lit", "masks", "new_levels", "points"];

/// Records that are in textures where a device's `RecordForm` is `Textures`.
const IN_EITHER: &[&str] = &[
    "clipped_rects",
    "footprints",
    "histograms",
    "keys",
    "pairs",
    "rects",
    "setups",
    "sorted_pairs",
    "tiles",
];

fn is_written_texture(binding: &Binding) -> bool {
    match binding.kind {
        BindingKind::StorageTexture { access, .. } => access != Access::Read,
        _ => false,
    }
}

/// Buffers are written at more than twice the rate of storage textures.
#[test]
fn records_are_written_to_buffers() {
    let mut written = [BTreeSet::new(), BTreeSet::new()];
    for ((desc, tier), form) in in_both_forms() {
        let bindings = desc.link_with(tier, form).unwrap().bindings().unwrap();
        let names = bindings.into_iter().filter(is_written_texture).map(|it| it.name);
        written[usize::from(!form.is_empty())].extend(names);
    }
    let known: BTreeSet<_> = TEXELS.iter().chain(IN_TEXTURES).copied().collect();
    assert_eq!(written, [known.clone(), known.iter().chain(IN_EITHER).copied().collect()]);
    // The check can fail.
    let kind = BindingKind::StorageTexture {
        access: Access::Write,
        format: TextureFormat::Rgba32Uint,
        dimension: TextureViewDimension::D2,
    };
    let wrong = Binding { name: "casters", number: 33, kind };
    assert!(is_written_texture(&wrong) && !known.contains(wrong.name));
}

/// docs/embedding.md promises a host's text five of WebGPU's eight.
#[test]
fn loaders_leave_five_buffers_to_the_host() {
    let most = Limits::default().max_storage_buffers_per_shader_stage - 5;
    for desc in [&load::CASTERS, &load::GAUSSIANS, &load::VOXELS] {
        let bindings = desc.link(Tier::Core).unwrap().bindings().unwrap();
        let is_own = |it: &&Binding| {
            let of_plain = ["host_casters", "host_gaussians"].contains(&it.name);
            matches!(it.kind, BindingKind::Storage { .. }) && !of_plain
        };
        let own: Vec<_> = bindings.iter().filter(is_own).map(|it| it.name).collect();
        assert!(own.len() as u32 <= most && own.contains(&"host_groups"), "{} {own:?}", desc.name);
    }
}

/// The checks can fail: they must notice each of these edits.
#[test]
fn disagreements_are_noticed() {
    let linked = SERIAL_SCATTER.link_with(Tier::Core, &tuning::IN_TEXTURES).unwrap();
    let edited = |edits: &[(&str, &str)]| {
        let wgsl = edits.iter().fold(linked.wgsl.clone(), |wgsl, (from, to)| {
            assert!(wgsl.contains(from), "{from}");
            wgsl.replace(from, to)
        });
        naga::front::wgsl::parse_str(&wgsl)
            .unwrap_or_else(|e| panic!("{}", e.emit_to_string(&wgsl)))
    };
    assert!(bindings_agree(&linked, &edited(&[])).is_ok());
    for edit in [
        ("    capacity: u32,", "    capacity: u32, extra: u32,"),
        ("digit_count: u32,", "@align(16) digit_count: u32,"),
        ("    shift: u32,", "    moved: u32, shift: u32,"),
    ] {
        assert!(struct_agrees::<SortPass>(&edited(&[edit])).is_err(), "{edit:?}");
    }
    let binding_edits: &[&[(&str, &str)]] = &[
        &[("var<uniform> sort_pass", "var<storage, read> sort_pass")],
        &[("var<storage, read> counts", "var<storage, read_write> counts")],
        &[("histograms: texture_storage_2d<r32uint", "histograms: texture_storage_2d<rg32uint")],
        &[
            ("histograms: texture_storage_2d<r32uint, read>", "histograms: texture_2d<u32>"),
            ("textureLoad(histograms, at).x", "textureLoad(histograms, at, 0).x"),
        ],
        &[("rg32uint, write>", "rg32uint, read_write>")],
        // Bound, but not used.
        &[("min(counts[sort_pass.count_index], sort_pass.capacity)", "sort_pass.capacity")],
    ];
    for edits in binding_edits {
        assert!(bindings_agree(&linked, &edited(edits)).is_err(), "{edits:?}");
    }
}
