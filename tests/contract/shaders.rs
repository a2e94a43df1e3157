//! Every kernel is valid on its tier and uses only known overrides; every declaration is used by some kernel,
//! and every file imports its foreign names.
use crate::common::{ROOT, gpu, own_gpu, parse, wgsl_files};
use gobo::{
    gpu::{
        Binding, BindingKind, Choice, Kernel, KernelDesc, KernelError, Library, Resources, Tier,
        words,
    },
    stage::{
        bin, curve,
        levels::{OF_AREA, OF_POINT},
        llvmpipe::{COLUMNS, LOADED, RUNS},
        sort::SERIAL_SCATTER,
        tuning::IN_TEXTURES,
    },
    wgpu::{self, BufferUsages},
};
use gobo_picture::stage::{kernels, variants};
use naga::valid::{Capabilities, ShaderStages, SubgroupOperationSet, ValidationFlags, Validator};
use std::{collections::HashSet, path::Path, sync::LazyLock};

/// `pack2x16float` and its kind are core WebGPU; naga counts them as a capability.
const CORE: Capabilities = Capabilities::SHADER_FLOAT16_IN_FLOAT32;

fn capabilities(tier: Tier) -> Capabilities {
    let of = |has, capability| if has { capability } else { Capabilities::empty() };
    CORE | of(tier.has_subgroups(), Capabilities::SUBGROUP)
        | of(tier.has_texture_atomics(), Capabilities::TEXTURE_ATOMIC)
}

fn is_valid(module: &naga::Module, capabilities: Capabilities) -> Result<(), String> {
    Validator::new(ValidationFlags::all(), capabilities)
        .subgroup_stages(ShaderStages::COMPUTE)
        .subgroup_operations(SubgroupOperationSet::all())
        .validate(module)
        .map(|_| ())
        .map_err(|error| format!("{:?}", error.into_inner()))
}

#[test]
fn kernels_are_valid_on_their_tier() {
    for (desc, tier) in variants() {
        let module = parse(desc, tier);
        is_valid(&module, capabilities(tier))
            .unwrap_or_else(|error| panic!("{}: {error}", desc.name));
        let entry_points: Vec<_> = module.entry_points.iter().map(|e| e.name.as_str()).collect();
        assert_eq!(entry_points, [desc.entry]);
        // Lengths of arrays have no name.
        let overrides: Vec<_> =
            module.overrides.iter().filter_map(|(_, open)| open.name.as_deref()).collect();
        for (name, _) in desc.constants {
            assert!(overrides.contains(name), "{} has no {name}", desc.name);
        }
        for (_, open) in module.overrides.iter().filter(|(_, open)| open.init.is_none()) {
            let name = open.name.as_deref().unwrap();
            let is_given = desc.constants.iter().any(|(given, _)| *given == name);
            assert!(is_given, "{}: {name} has no usual value", desc.name);
        }
    }
}

/// Software adapters read sampled textures as storage textures, as far as the tier has them.
#[test]
fn kernels_of_software_adapters_are_valid() {
    let stored = |bindings: &[Binding]| {
        let is_stored = |it: &&Binding| matches!(it.kind, BindingKind::StorageTexture { .. });
        bindings.iter().filter(is_stored).count()
    };
    let mut more = HashSet::new();
    let all = kernels().iter().flat_map(|desc| Tier::ALL.iter().map(move |tier| (desc, *tier)));
    for (desc, tier) in all.filter(|(desc, tier)| *tier >= desc.tiers[0]) {
        let of_software = [&COLUMNS[..], &[LOADED, RUNS], &IN_TEXTURES].concat();
        let [own, loaded] = [&IN_TEXTURES[..], &of_software]
            .map(|choices| desc.specialised(tier, choices, &[]).unwrap());
        assert!(!loaded.wgsl.contains("< unrolled("), "{}: a loop is not written out", desc.name);
        let module = loaded.module.as_ref().unwrap();
        is_valid(module, capabilities(tier))
            .unwrap_or_else(|error| panic!("{}: {error}", desc.name));
        // A run of tiles is one tile where the list goes through parts.
        let asks_for_parts = usize::from(desc.entry == "walk_tile");
        assert_eq!(own.bindings.len() + asks_for_parts, loaded.bindings.len(), "{}", desc.name);
        if stored(&loaded.bindings) > stored(&own.bindings) {
            let most = tier.storage_textures() as usize;
            assert!(stored(&loaded.bindings) <= most, "{} {tier:?}", desc.name);
            more.insert(desc.name);
        }
    }
    assert!(more.contains("shade_seen") && more.contains("light_points"), "{more:?}");
}

/// The check can fail: some kernel of each tier is refused on the tier below.
#[test]
fn kernels_of_a_tier_are_not_of_the_one_below() {
    for two in Tier::ALL.windows(2) {
        let of_tier = variants().filter(|(_, tier)| *tier == two[1]);
        let mut valid =
            of_tier.map(|(desc, tier)| is_valid(&parse(desc, tier), capabilities(two[0])));
        assert!(valid.any(|valid| valid.is_err()), "{}", two[1]);
    }
}

/// A kernel has a variant for each tier on which it differs from the tier below, and no other.
#[test]
fn variants_differ_from_those_below() {
    let wgsl = |desc: &KernelDesc, tier: Tier| desc.link(tier).unwrap().wgsl;
    let mut wrong = Vec::new();
    for desc in kernels() {
        let from = Tier::ALL.windows(2).filter(|two| two[1] > desc.tiers[0]);
        let differing =
            from.filter(|two| wgsl(desc, two[0]) != wgsl(desc, two[1])).map(|two| two[1]);
        let expected: Vec<_> = desc.tiers[..1].iter().copied().chain(differing).collect();
        if desc.tiers != expected {
            wrong.push(format!("{} differs on {expected:?}", desc.name));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Constants of an enum are listed together, whether or not a kernel uses each of them.
const ENUMS: &[&str] =
    &["AREA_", "EMITTER_", "FORMAT_", "LIGHT_", "PATTERN_", "PROFILE_", "RECEIVES_", "ROLE_"];

#[test]
fn every_declaration_is_some_kernels() {
    let mut linked: Vec<_> = variants().map(|(desc, tier)| desc.link(tier).unwrap()).collect();
    // Code that hosts link into shaders of their own.
    let library = gobo_picture::stage::library().unwrap();
    for source in [OF_POINT, OF_AREA] {
        let choices = [(source.name, source.files[0])];
        linked.push(library.link("shade/light_through.wgsl", "light_at", &choices).unwrap());
    }
    let columns = [&COLUMNS[..], &[RUNS]].concat();
    linked.extend(kernels().iter().map(|desc| desc.link_with(Tier::Native, &columns).unwrap()));
    let on_core = kernels().iter().filter(|desc| desc.tiers.contains(&Tier::Core));
    linked.extend(on_core.map(|desc| desc.link_with(Tier::Core, &IN_TEXTURES).unwrap()));
    let items = linked.iter().flat_map(|linked| &linked.items);
    let mut used: HashSet<_> = items.map(|item| (item.file, item.name)).collect();
    // Kernels of software adapters replace one by the other.
    let sampled =
        |(file, _): &(&str, _)| ["bind/sampled.wgsl", "bind/picture_in.wgsl"].contains(file);
    let names: Vec<_> = used.iter().copied().filter(sampled).collect();
    used.extend(names.into_iter().map(|(_, name)| (LOADED.files[0], name)));
    let items = gobo_picture::stage::library().unwrap().items();
    let orphans: Vec<_> = items
        .filter(|item| !used.contains(&(item.file, item.name)))
        .filter(|item| !ENUMS.iter().any(|prefix| item.name.starts_with(prefix)))
        .map(|item| format!("{}:{} {}", item.file, item.line, item.name))
        .collect();
    assert_eq!(orphans, [""; 0], "in no kernel");
}

#[test]
fn every_entry_point_is_a_kernel() {
    let items = gobo_picture::stage::library().unwrap().items();
    let entries: HashSet<_> = items
        .filter(|item| item.text.contains("@compute"))
        .map(|item| (item.file, item.name))
        .collect();
    let kernels: HashSet<_> = kernels().iter().map(|desc| (desc.root, desc.entry)).collect();
    assert_eq!(entries, kernels);
}

/// Names that a declaration gives to its own parts: locals, parameters and members.
fn own_names(item: &'static str) -> HashSet<&'static str> {
    let is_own = |(at, word): &(usize, &str)| {
        let (before, after) = (item[..*at].trim_end(), item[at + word.len()..].trim_start());
        let is_label = before.rsplit('\n').next().is_some_and(|line| line.contains("case "));
        before.ends_with("let") || before.ends_with("var") || after.starts_with(':') && !is_label
    };
    words(item).filter(is_own).map(|(_, word)| word).collect()
}

/// Problems of a file's imports.
fn unsound_imports(path: &str, library: &Library) -> Vec<String> {
    let everywhere: HashSet<_> = library.items().map(|item| item.name).collect();
    let own: Vec<_> = library.items().filter(|item| item.file == path).collect();
    let imported: HashSet<_> = library.imports(path).collect();
    let mut unused = imported.clone();
    let mut foreign = HashSet::new();
    for item in &own {
        let names = own_names(item.text);
        for (_, word) in words(item.text).filter(|(_, word)| everywhere.contains(word)) {
            unused.remove(word);
            let is_known = imported.contains(word) || names.contains(word);
            if !is_known && !own.iter().any(|own| own.name == word) {
                foreign.insert(word);
            }
        }
    }
    let unused = unused.into_iter().map(|name| format!("{path} imports {name} for nothing"));
    unused.chain(foreign.into_iter().map(|name| format!("{path} does not import {name}"))).collect()
}

#[test]
fn every_import_is_used_and_every_foreign_name_imported() {
    let library = gobo_picture::stage::library().unwrap();
    let paths: HashSet<_> = library.items().map(|item| item.file).collect();
    let bad: Vec<_> = paths.into_iter().flat_map(|path| unsound_imports(path, library)).collect();
    assert_eq!(bad, [""; 0]);
}

/// A guest has no other files.
#[test]
fn files_of_the_library_import_from_the_library() {
    let is_own = |path: &str| Path::new(ROOT).join("wgsl").join(path).exists();
    let own = wgsl_files().into_iter().filter(|(path, _)| is_own(path));
    let foreign: Vec<_> = own
        .flat_map(|(path, text)| {
            let modules = text.split("import package::").skip(1).map(|rest| {
                let module = rest.split(';').next().unwrap().rsplit_once("::").unwrap().0;
                module.replace("::", "/") + ".wgsl"
            });
            modules.map(|module| (path.clone(), module)).collect::<Vec<_>>()
        })
        .filter(|(_, module)| !is_own(module))
        .collect();
    assert_eq!(foreign, []);
}

#[test]
fn unsound_imports_are_noticed() {
    let b = ("b.wgsl", "struct Size { x: u32 }\nfn size() -> u32 { return 1u; }");
    let bad = |a| {
        let library = Library::new(&[("a.wgsl", a), b]).unwrap();
        unsound_imports("a.wgsl", &library)
    };
    assert_eq!(
        bad("import package::b::size;\nfn a() {}"),
        ["a.wgsl imports size for nothing".to_owned()]
    );
    assert_eq!(bad("fn a() { size(); }"), ["a.wgsl does not import size".to_owned()]);
    assert_eq!(bad("fn a(s: Size) {}"), ["a.wgsl does not import Size".to_owned()]);
    assert_eq!(bad("fn a(size: u32) -> u32 { return size; }"), [""; 0]);
    assert_eq!(bad("import package::b::{Size, size};\nfn a(s: Size) { size(); }"), [""; 0]);
}

#[test]
fn files_are_short() {
    for (path, text) in wgsl_files() {
        let lines = text.lines().count();
        assert!(lines <= 250, "wgsl/{path} has {lines} lines");
    }
}

/// If a loop's test comes first, llvmpipe executes its body once more than it has turns: a point under one
/// light would take twice as long.
#[test]
fn loops_of_look_ups_end_with_their_test() {
    let files = ["receive", "shadow", "point_light"].map(|name| format!("shade/{name}.wgsl"));
    let items = gobo_picture::stage::library().unwrap().items();
    let (mut loops, mut early) = (0, Vec::new());
    for item in items.filter(|item| files.iter().any(|file| file == item.file)) {
        loops += item.text.matches("loop {").count();
        if item.text.contains("for (") || item.text.contains("while ") {
            early.push((item.file, item.name));
        }
    }
    assert_eq!(early, []);
    assert!(loops >= 4, "{loops}");
}

/// Like [`loops_of_look_ups_end_with_their_test`]: a look-up of an area light would take a third longer.
/// Compilers unroll loops of few and constant turns.
#[test]
fn loops_of_area_look_ups_end_with_their_test() {
    let library = gobo_picture::stage::library().unwrap();
    let of = |source: Choice| {
        let choices = [(source.name, source.files[0])];
        library.link("shade/light_through.wgsl", "light_at", &choices).unwrap().items
    };
    let (mut files, mut loops, mut early) = (HashSet::new(), 0, Vec::new());
    // Parts shared with look-ups of points are as short as theirs.
    let shared: HashSet<_> = of(OF_POINT).iter().map(|item| (item.file, item.name)).collect();
    for item in of(OF_AREA) {
        if shared.contains(&(item.file, item.name)) {
            continue;
        }
        files.insert(item.file);
        loops += item.text.matches("loop {").count();
        let is_short =
            |head: &str| ["< 2u;", "< AROUND_COUNT;"].iter().any(|bound| head.contains(bound));
        let mut heads = item.text.split("for (").skip(1).map(|rest| rest.lines().next().unwrap());
        if heads.any(|head| !is_short(head)) || item.text.contains("while ") {
            early.push((item.file, item.name));
        }
    }
    assert_eq!(early, []);
    assert!(loops >= 10, "{loops} loops in {files:?}");
    for name in ["level_light", "nearest_lit", "source_area"] {
        assert!(files.contains(&*format!("shade/{name}.wgsl")), "{name} is not in {files:?}");
    }
}

/// SwiftShader, the driver of browsers without a GPU, follows a loop's paths to find its end, and each `&&`
/// and `||` may double them: area lights' kernels would compile for hours. Constants decide before that.
#[test]
fn conditions_of_look_ups_do_not_branch() {
    let library = gobo_picture::stage::library().unwrap();
    let linked = [OF_POINT, OF_AREA].map(|source| {
        let choices = [(source.name, source.files[0])];
        library.link("shade/light_through.wgsl", "light_at", &choices).unwrap().items
    });
    let roots = ["shade/point_light.wgsl", "shade/air_scatter.wgsl", "mask/mask_look_up.wgsl"];
    let own = library.items().filter(|item| roots.contains(&item.file)).cloned();
    let branching: HashSet<_> = linked
        .into_iter()
        .flatten()
        .chain(own)
        .flat_map(|item| item.text.lines().map(move |line| (item.file, line)))
        .map(|(file, line)| (file, line.split("//").next().unwrap()))
        .filter(|(_, code)| code.contains("&&") || code.contains("||"))
        .filter(|(_, code)| !code.contains("HAS_") && !code.contains("NODES > 0u"))
        .collect();
    assert_eq!(branching, HashSet::new());
}

#[test]
fn errors_name_their_file() {
    let linked = SERIAL_SCATTER.link(Tier::Core).unwrap();
    let wgsl = linked.wgsl.replace("offsets[digit];", "onsets[digit];");
    let error = naga::front::wgsl::parse_str(&wgsl).unwrap_err().emit_to_string(&wgsl);
    let (_, source) =
        wgsl_files().into_iter().find(|(path, _)| path == SERIAL_SCATTER.root).unwrap();
    let line = 1 + source.lines().position(|l| l.contains("offsets[digit];")).unwrap();
    let place = format!("wgsl/{}:{line}:", SERIAL_SCATTER.root);
    assert!(
        linked.located(&error, SERIAL_SCATTER.name).contains(&place),
        "{}",
        linked.located(&error, SERIAL_SCATTER.name)
    );
}

/// If a device refuses a kernel, the error names file and line.
#[test]
fn a_refused_kernel_names_file_and_line() {
    // It takes one argument here, but `walk_tile` passes two.
    const WRONG: &str = "fn tile_number(workgroup: vec3<u32>) -> u32 { return workgroup.x; }";
    static LIBRARY: LazyLock<Library> =
        LazyLock::new(|| Library::embedded().unwrap().with(&[("wrong.wgsl", WRONG)]).unwrap());
    const IN_WRONG_ORDER: &[Choice] = &[
        Choice::new("order", "wrong.wgsl"),
        Choice::new("output", "curve/ray_tile.wgsl"),
        Choice::new("plain", "hit/disc.wgsl"),
    ];
    let library = || Ok(&*LIBRARY);
    let desc = KernelDesc { with: IN_WRONG_ORDER, library, ..curve::DISC_TILES };
    let gpu = own_gpu(Tier::Core);
    let error = Kernel::new(&gpu.device, &desc, Tier::Core, &[], &[]).unwrap_err().to_string();
    let path = "entry/walk.wgsl";
    let (_, entries) = wgsl_files().into_iter().find(|file| file.0 == path).unwrap();
    let line = 1 + entries.lines().position(|line| line.contains("tile_number(w")).unwrap();
    assert!(error.contains(&format!("wgsl/{path}:{line}:")), "{error}");
    assert!(gpu.check().is_ok());
    let unchosen = KernelDesc { with: IN_WRONG_ORDER, shared: &[], ..curve::DISC_TILES };
    let error = Kernel::new(&gpu.device, &unchosen, Tier::Core, &[], &[]).unwrap_err();
    assert!(matches!(error, KernelError::Link(_)), "{error}");
    assert!(error.to_string().contains("does not choose `tiles`"), "{error}");
}

/// Resources are found by name: a missing or mistyped one is an error.
#[test]
fn wrong_resources_are_errors() {
    let gpu = gpu(Tier::Core);
    let kernel = Kernel::new(&gpu.device, &bin::SCAN, Tier::Core, &[], &[]).unwrap();
    let buffer = |usage| gpu.upload("buffer", &[0_u32; 16], usage);
    let (uniform, storage) = (buffer(BufferUsages::UNIFORM), buffer(BufferUsages::STORAGE));
    let texture = gpu.texture_array("texture", [1, 1, 1], wgpu::TextureFormat::R32Uint);
    let all = Resources::new()
        .with("bin_params", &uniform)
        .with("run_offsets", &storage)
        .with("counters", &storage)
        .with("not_asked_for", &texture);
    assert!(kernel.bind(&gpu.device, &all).is_ok());
    for wrong in [
        all.clone().with("run_offsets", &texture),
        all.clone().with("run_offsets", &uniform),
        all.clone().with("bin_params", &storage),
    ] {
        let error = kernel.bind(&gpu.device, &wrong).unwrap_err();
        assert!(matches!(error, KernelError::Mistyped { .. }), "{error}");
    }
    let few = Resources::new().with("bin_params", &uniform).with("run_offsets", &storage);
    match kernel.bind(&gpu.device, &few) {
        Err(KernelError::Missing { kernel: "bin_scan", resource: "counters" }) => {}
        other => panic!("{other:?}"),
    }
    assert!(gpu.check().is_ok());
}
