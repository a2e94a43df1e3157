//! Rust and WGSL agree on every shared struct and binding.
use crate::common::parse;
use gobo::{
    gpu::{Access, Binding, BindingKind, GpuLayout, KernelDesc, Tier},
    records::{GpuMaterial, GpuView},
    reference::curve::tile::SLAB_PAIRS,
    stage::{
        KERNELS,
        air::AirParams,
        bin::{BatchCounters, BinParams, SEGMENT_LENGTH, Segment},
        cluster::{ClusterCounters, ClusterParams},
        curve::CURVE_SEGMENT,
        filter::FilterParams,
        project::{Chunk, ProjectParams},
        shade::{GpuLight, PictureParams},
        sort::{SERIAL_SCATTER, SortPass},
    },
    wgpu::{TextureSampleType, TextureViewDimension},
};
use naga::{AddressSpace, ImageClass, ImageDimension, Module, StorageAccess, TypeInner};

/// `Ok(false)`: the module does not declare the struct.
type Check = fn(&Module) -> Result<bool, String>;

/// Every struct that both sides declare.
const STRUCTS: &[Check] = &[
    struct_agrees::<GpuView>,
    struct_agrees::<GpuMaterial>,
    struct_agrees::<Chunk>,
    struct_agrees::<ProjectParams>,
    struct_agrees::<SortPass>,
    struct_agrees::<BinParams>,
    struct_agrees::<BatchCounters>,
    struct_agrees::<Segment>,
    struct_agrees::<AirParams>,
    struct_agrees::<FilterParams>,
    struct_agrees::<ClusterParams>,
    struct_agrees::<ClusterCounters>,
    struct_agrees::<GpuLight>,
    struct_agrees::<PictureParams>,
];

/// Every one is in the list: the sources are searched for `gpu_layout!`.
#[test]
fn every_shared_struct_is_checked() {
    let mut pending = vec![std::path::PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/src"))];
    let mut count = 0;
    while let Some(path) = pending.pop() {
        if path.is_dir() {
            pending.extend(path.read_dir().unwrap().map(|entry| entry.unwrap().path()));
        } else {
            count +=
                std::fs::read_to_string(path).unwrap().matches("\ncrate::gpu_layout!(").count();
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
        BindingKind::Uniform { size } => format!("uniform of {size} bytes"),
        BindingKind::Storage { access, size } => format!("{access:?} storage of {size} bytes"),
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
    format!("{}: {kind}", binding.name)
}

fn wgsl_binding(module: &Module, global: &naga::GlobalVariable) -> String {
    let ty = &module.types[global.ty].inner;
    let element_size = match *ty {
        TypeInner::Array { stride, .. } => stride,
        _ => layouter(module)[global.ty].size,
    };
    let kind = match (global.space, ty) {
        (AddressSpace::Uniform, _) => {
            format!("uniform of {} bytes", layouter(module)[global.ty].size)
        }
        (AddressSpace::Storage { access: allowed }, _) => {
            format!("{:?} storage of {element_size} bytes", access(allowed))
        }
        (AddressSpace::Handle, &TypeInner::Image { dim: ImageDimension::D2, arrayed, class }) => {
            let dimension =
                if arrayed { TextureViewDimension::D2Array } else { TextureViewDimension::D2 };
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
    format!("{}: {kind}", global.name.as_deref().unwrap_or_default())
}

fn bindings_agree(desc: &KernelDesc, module: &Module) -> Result<(), String> {
    let mut wgsl: Vec<_> = module
        .global_variables
        .iter()
        .filter_map(|(_, global)| {
            let at = global.binding?;
            Some((at.group, at.binding, wgsl_binding(module, global)))
        })
        .collect();
    wgsl.sort();
    let rust: Vec<_> =
        (0..).zip(desc.bindings).map(|(i, binding)| (0, i, rust_binding(binding))).collect();
    if wgsl == rust {
        Ok(())
    } else {
        Err(format!("{}\n wgsl {wgsl:#?}\n rust {rust:#?}", desc.name))
    }
}

#[test]
fn structs_and_bindings_agree() {
    let mut declared = vec![false; STRUCTS.len()];
    for desc in KERNELS {
        let module = parse(desc);
        bindings_agree(desc, &module).unwrap_or_else(|error| panic!("{error}"));
        for (seen, check) in declared.iter_mut().zip(STRUCTS) {
            *seen |= check(&module).unwrap_or_else(|error| panic!("{}: {error}", desc.name));
        }
    }
    assert!(declared.iter().all(|&seen| seen), "a shared struct is in no kernel: {declared:?}");
}

/// WebGPU's limits per shader stage, which the core tier is held to.
#[test]
fn bindings_are_few_enough() {
    for desc in KERNELS.iter().filter(|desc| desc.tier == Tier::Core) {
        let count = |of: fn(BindingKind) -> bool| {
            desc.bindings.iter().filter(|binding| of(binding.kind)).count()
        };
        let name = desc.name;
        assert!(count(|kind| matches!(kind, BindingKind::Uniform { .. })) <= 12, "{name}");
        assert!(count(|kind| matches!(kind, BindingKind::Storage { .. })) <= 8, "{name}");
        assert!(count(|kind| matches!(kind, BindingKind::StorageTexture { .. })) <= 4, "{name}");
        assert!(count(|kind| matches!(kind, BindingKind::Texture { .. })) <= 16, "{name}");
    }
}

/// The checks can fail: each edit is one they must notice.
#[test]
fn disagreements_are_noticed() {
    let edited = |edits: &[(&str, &str)]| {
        let wgsl = edits.iter().fold(SERIAL_SCATTER.wgsl(), |wgsl, (from, to)| {
            assert!(wgsl.contains(from), "{from}");
            wgsl.replace(from, to)
        });
        naga::front::wgsl::parse_str(&wgsl)
            .unwrap_or_else(|e| panic!("{}", e.emit_to_string(&wgsl)))
    };
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
        &[("counts: array<u32>", "counts: array<vec2<u32>>"), ("count_index]", "count_index].x")],
        &[("histograms: texture_storage_2d<r32uint", "histograms: texture_storage_2d<rg32uint")],
        &[
            ("histograms: texture_storage_2d<r32uint, read>", "histograms: texture_2d<u32>"),
            ("digit)).x", "digit), 0).x"),
            ("ROW)).x", "ROW), 0).x"),
        ],
        &[("rg32uint, write>", "rg32uint, read_write>")],
        &[("@binding(3)", "@binding(5)")],
    ];
    for edits in binding_edits {
        assert!(bindings_agree(&SERIAL_SCATTER, &edited(edits)).is_err(), "{edits:?}");
    }
}

/// Lengths that kernels and hosts cut pairs by.
#[test]
fn segments_are_as_long_in_the_kernels() {
    let sources = [
        (include_str!("../../wgsl/common/tile.wgsl"), "SEGMENT_LENGTH", SEGMENT_LENGTH),
        (include_str!("../../wgsl/common/curve.wgsl"), "CURVE_SEGMENT", CURVE_SEGMENT),
        (include_str!("../../wgsl/common/gather_curve.wgsl"), "SLAB_PAIRS", SLAB_PAIRS as u32),
    ];
    for (source, name, value) in sources {
        assert!(
            source.contains(&format!("const {name}: u32 = {value}u;")),
            "{name} is not {value}"
        );
    }
}
