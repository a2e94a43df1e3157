//! Kernels with values for their overrides are valid, and contain no code that these values make unreachable.
use crate::common::scenes::Chance;
use gobo::gpu::{Constant, ENABLED, KernelDesc, Tier, for_browsers};
use gobo_picture::stage::variants;
use naga::{
    Block, Expression, Function, Literal, Module, Statement,
    front::wgsl::parse_str,
    valid::{
        Capabilities, ModuleInfo, ShaderStages, SubgroupOperationSet, ValidationFlags, Validator,
    },
};
use std::collections::BTreeSet;

/// Values for the overrides: the description's, or random ones too.
fn values(desc: &KernelDesc, tier: Tier, chance: Option<&mut Chance>) -> Vec<Constant> {
    let linked = desc.link(tier).unwrap();
    let mut values = desc.constants.to_vec();
    let Some(chance) = chance else { return values };
    for item in linked.items.iter().filter(|item| item.keyword == "override") {
        let value = match item.name {
            "NODES" => [0.0, 4.0, 8.0, 16.0][chance.below(4)],
            "MASKS" => [1.0, 2.0, 4.0][chance.below(3)],
            _ if item.text.contains(": bool") => chance.below(2) as f64,
            _ => 64.0,
        };
        if !values.iter().any(|(name, _)| *name == item.name) {
            values.push((item.name, value));
        }
    }
    values
}

fn validate(module: &Module) -> Result<ModuleInfo, String> {
    Validator::new(ValidationFlags::all(), Capabilities::all())
        .subgroup_stages(ShaderStages::COMPUTE)
        .subgroup_operations(SubgroupOperationSet::all())
        .validate(module)
        .map_err(|error| format!("{:?}", error.into_inner()))
}

/// Number of expressions of all functions.
fn expressions(module: &Module) -> usize {
    let entries = module.entry_points.iter().map(|entry| &entry.function);
    let functions = module.functions.iter().map(|(_, function)| function);
    functions.chain(entries).map(|function| function.expressions.len()).sum()
}

/// Whether branches belong to `&&` or `||`, which store their value in a nameless variable.
fn is_operand(accept: &Block, reject: &Block, function: &Function) -> bool {
    [accept, reject].into_iter().all(|block| match block.last() {
        Some(Statement::Store { pointer, .. }) => match function.expressions[*pointer] {
            Expression::LocalVariable(it) => function.local_variables[it].name.is_none(),
            _ => false,
        },
        _ => false,
    })
}

/// Whether a condition is a constant (`HAS_X`), or the value of one (`!HAS_X`).
fn is_known(condition: &Expression) -> bool {
    matches!(condition, Expression::Constant(_) | Expression::Literal(Literal::Bool(_)))
}

/// Branches of a block whose conditions are known.
fn known_branches(block: &Block, function: &Function) -> usize {
    let inner = |block: &Block| known_branches(block, function);
    let of = |statement: &Statement| match statement {
        Statement::Block(block) => inner(block),
        Statement::If { condition, accept, reject } => {
            let is_known = is_known(&function.expressions[*condition]);
            let counts = is_known && !is_operand(accept, reject, function);
            usize::from(counts) + inner(accept) + inner(reject)
        }
        Statement::Loop { body, continuing, .. } => inner(body) + inner(continuing),
        Statement::Switch { cases, .. } => cases.iter().map(|case| inner(&case.body)).sum(),
        _ => 0,
    };
    block.iter().map(of).sum()
}

/// Functions with branches whose conditions are known.
fn branches(module: &Module) -> Vec<&str> {
    let functions = module.functions.iter().map(|(_, function)| function);
    let entries = module.entry_points.iter().map(|entry| &entry.function);
    let has_known = functions.chain(entries).filter(|it| known_branches(&it.body, it) > 0);
    has_known.map(|it| it.name.as_deref().unwrap_or("the entry point")).collect()
}

/// The check can fail: conditions of every form are counted, and operands of `&&` are not.
#[test]
fn known_conditions_are_noticed() {
    for (condition, count) in
        [("HAS_X", 1), ("!HAS_X", 1), ("MANY > 2u", 1), ("lit > 0u", 0), ("HAS_X && is_lit()", 0)]
    {
        let wgsl = format!(
            "const HAS_X: bool = true;\nconst MANY: u32 = 3u;\nvar<private> lit: u32;\n\
             fn is_lit() -> bool {{ return lit > 0u; }}\n\
             @compute @workgroup_size(1) fn main() {{ if {condition} {{ lit += 1u; }} }}"
        );
        assert_eq!(branches(&parse_str(&wgsl).unwrap()).len(), count, "{condition}");
    }
}

/// Names of a module's bindings.
fn bound(module: &Module) -> BTreeSet<&str> {
    let variables = module.global_variables.iter().filter(|(_, it)| it.binding.is_some());
    variables.map(|(_, it)| it.name.as_deref().unwrap()).collect()
}

#[test]
fn no_branch_is_left_that_is_never_taken() {
    let mut chance = Chance::new(77);
    let (mut dropped, mut shorter) = (0, 0);
    for (desc, tier) in variants() {
        for round in 0..3 {
            let values = values(desc, tier, (round > 0).then_some(&mut chance));
            let kernel = desc.specialised(tier, &[], &values).unwrap();
            let fails = || format!("{} with {values:?}:\n{}", desc.name, kernel.wgsl);
            let pruned = kernel.module.as_ref().unwrap_or_else(|| panic!("{}", fails()));
            assert_eq!(branches(pruned), [""; 0], "{}", fails());
            assert!(pruned.overrides.is_empty(), "{}", fails());
            validate(pruned).unwrap_or_else(|error| panic!("{error}\n{}", fails()));
            // All requested resources can be bound.
            let names: BTreeSet<_> = kernel.bindings.iter().map(|it| it.name).collect();
            assert_eq!(bound(pruned), names, "{}", desc.name);
            let whole = parse_str(&kernel.wgsl).unwrap();
            shorter += usize::from(expressions(pruned) < expressions(&whole) * 3 / 4);
            dropped += branches(&whole).len();
        }
    }
    // The check can fail: many functions have such branches before specialisation.
    assert!(dropped > 500 && shorter > 50, "{dropped} functions, {shorter} kernels");
}

/// Numbers of a module's bindings.
fn numbers(module: &Module) -> BTreeSet<u32> {
    module.global_variables.iter().filter_map(|(_, it)| Some(it.binding?.binding)).collect()
}

/// Browsers accept the pruned module as WGSL: with the same bindings and entry point, and `enable subgroups`
/// where it needs them.
#[test]
fn what_browsers_compile_is_the_pruned_module() {
    let mut with_subgroups = 0;
    for (desc, tier) in variants().filter(|(_, tier)| *tier != Tier::Native) {
        let kernel = desc.specialised(tier, &[], &values(desc, tier, None)).unwrap();
        let pruned = kernel.module.as_ref().unwrap();
        let text = for_browsers(pruned).unwrap_or_else(|error| panic!("{}: {error}", desc.name));
        let bare = text.strip_prefix(ENABLED);
        assert!(
            kernel.wgsl.contains("subgroup") || bare.is_none(),
            "{} has no subgroups",
            desc.name
        );
        with_subgroups += usize::from(bare.is_some());
        let read = parse_str(bare.unwrap_or(&text)).unwrap();
        // Names of variables may differ.
        assert_eq!(numbers(&read), numbers(pruned), "{}", desc.name);
        assert!(read.entry_points.iter().any(|entry| entry.name == desc.entry), "{}", desc.name);
        validate(&read).unwrap_or_else(|error| panic!("{error}\n{text}"));
    }
    assert!(with_subgroups > 5, "{with_subgroups} kernels with subgroups");
}
