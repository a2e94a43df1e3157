//! Walks use only constants as indices of private and function variables and of vectors: on an H100, one
//! dynamic index in the store at the end of a walk nearly doubled the walk's time, and neither registers nor
//! stack show it.
use gobo::gpu::FEW_TURNS;
use gobo_picture::stage::variants;
use naga::{
    AddressSpace, Expression, Function, Module, TypeInner,
    front::wgsl::parse_str,
    valid::{
        Capabilities, FunctionInfo, ShaderStages, SubgroupOperationSet, ValidationFlags, Validator,
    },
};
use std::collections::BTreeSet;

/// Buffer of hits that wait for late ones: it would take 96 registers.
const ALLOWED: [&str; 1] = ["ring"];

/// Variable at the root of a pointer, or "a value".
fn root(module: &Module, function: &Function, base: naga::Handle<Expression>) -> String {
    match function.expressions[base] {
        Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => {
            root(module, function, base)
        }
        Expression::GlobalVariable(it) => module.global_variables[it].name.clone().unwrap(),
        Expression::LocalVariable(it) => {
            function.local_variables[it].name.clone().unwrap_or_default()
        }
        _ => "a value".to_owned(),
    }
}

/// Variables of a function that are indexed dynamically.
fn of_function(module: &Module, function: &Function, info: &FunctionInfo) -> Vec<String> {
    let is_own = |space| matches!(space, AddressSpace::Private | AddressSpace::Function);
    let accesses = function.expressions.iter().filter_map(|(_, expression)| match *expression {
        Expression::Access { base, .. } => Some(base),
        _ => None,
    });
    let indexed = accesses.filter(|&base| match *info[base].ty.inner_with(&module.types) {
        TypeInner::Pointer { space, .. } | TypeInner::ValuePointer { space, .. } => is_own(space),
        _ => true,
    });
    indexed.map(|base| root(module, function, base)).collect()
}

/// Variables and functions of a kernel where it indexes dynamically.
fn indexed(wgsl: &str) -> BTreeSet<String> {
    let module = parse_str(wgsl).unwrap_or_else(|error| panic!("{}", error.emit_to_string(wgsl)));
    let info = Validator::new(ValidationFlags::all(), Capabilities::all())
        .subgroup_stages(ShaderStages::COMPUTE)
        .subgroup_operations(SubgroupOperationSet::all())
        .validate(&module)
        .unwrap();
    let functions = module.functions.iter().map(|(at, it)| (it, &info[at]));
    let entry = (&module.entry_points[0].function, info.get_entry_point(0));
    let all = functions.chain([entry]).flat_map(|(it, info)| {
        let name = it.name.as_deref().unwrap_or("the entry point");
        of_function(&module, it, info).into_iter().map(move |variable| (variable, name))
    });
    all.filter(|(variable, _)| !ALLOWED.contains(&variable.as_str()))
        .map(|(variable, name)| format!("{variable} in {name}"))
        .collect()
}

#[test]
fn walks_index_by_constants() {
    let mut walks = 0;
    for (desc, tier) in variants() {
        let is_walk = ["accumulate", "occlude"].iter().any(|stage| desc.name.starts_with(stage));
        // Kernels for llvmpipe alone have their loops unrolled, however long.
        if !is_walk || desc.name.contains("queue") {
            continue;
        }
        for nodes in [0.0, 4.0, 16.0] {
            let constants = [&[("NODES", nodes)], desc.constants].concat();
            let linked = desc.link(tier).unwrap();
            let wgsl = linked.unrolled(linked.wgsl.clone(), &constants, FEW_TURNS);
            assert_eq!(indexed(&wgsl), BTreeSet::new(), "{} on {tier}", desc.name);
            walks += 1;
        }
    }
    assert!(walks > 100, "{walks}");
}

/// The check can fail.
#[test]
fn dynamic_indices_are_noticed() {
    let of = |body: &str| {
        let wgsl = format!(
            "var<private> held: array<f32, 4>;
            var<workgroup> shared_by_all: array<f32, 4>;
            @compute @workgroup_size(4) fn k(@builtin(local_invocation_index) lane: u32) {{
                var own = vec4(1.0);
                let value = vec2(1.0);
                {body}
            }}"
        );
        indexed(&wgsl).into_iter().collect::<Vec<_>>().join(", ")
    };
    assert_eq!(of("held[3] = own[2] + shared_by_all[lane]; const I = 1u; held[I] = value[I];"), "");
    assert_eq!(of("held[lane] = 1.0;"), "held in k");
    assert_eq!(of("for (var i = 0u; i < 4u; i += 1u) { own[i] = 1.0; }"), "own in k");
    assert_eq!(of("held[0] = value[lane];"), "a value in k");
}
