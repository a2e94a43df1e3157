//! Kernels with values for their overrides are valid, and hold nothing that these values leave unreached.
use crate::common::scenes::Chance;
use gobo::{
    gpu::{Constant, KernelDesc, Tier},
    stage::variants,
};
use naga::{
    Block, Expression, Function, Literal, Module, ShaderStage, Statement,
    back::pipeline_constants::process_overrides,
    valid::{Capabilities, ShaderStages, SubgroupOperationSet, ValidationFlags, Validator},
};
use std::collections::HashSet;

/// Values for the overrides: the description's, or also random ones.
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

/// The module with `values` in place of its overrides.
fn resolved(wgsl: &str, desc: &KernelDesc, values: &[Constant]) -> Module {
    let fails = |error: String| -> ! { panic!("{} with {values:?}: {error}\n{wgsl}", desc.name) };
    let module =
        naga::front::wgsl::parse_str(wgsl).unwrap_or_else(|e| fails(e.emit_to_string(wgsl)));
    let info = Validator::new(ValidationFlags::all(), Capabilities::all())
        .subgroup_stages(ShaderStages::COMPUTE)
        .subgroup_operations(SubgroupOperationSet::all())
        .validate(&module)
        .unwrap_or_else(|e| fails(format!("{:?}", e.into_inner())));
    let known =
        |name: &str| module.overrides.iter().any(|(_, it)| it.name.as_deref() == Some(name));
    let values = values.iter().filter(|(name, _)| known(name));
    let values = values.map(|&(name, value)| (name.to_owned(), value)).collect();
    let entry = Some((ShaderStage::Compute, desc.entry));
    let resolved = process_overrides(&module, &info, entry, &values);
    resolved.unwrap_or_else(|e| fails(e.to_string())).0.into_owned()
}

/// Whether branches are those of `&&` or `||`, which store its value.
fn is_operand(accept: &Block, reject: &Block) -> bool {
    let stores = |block: &Block| {
        block.iter().all(|statement| match statement {
            Statement::If { accept, reject, .. } => is_operand(accept, reject),
            other => matches!(other, Statement::Emit(_) | Statement::Store { .. }),
        })
    };
    stores(accept) && stores(reject)
}

/// Branches of a block whose conditions are known.
fn known_branches(block: &Block, function: &Function) -> usize {
    let inner = |block: &Block| known_branches(block, function);
    let of = |statement: &Statement| match statement {
        Statement::Block(block) => inner(block),
        Statement::If { condition, accept, reject } => {
            let condition = &function.expressions[*condition];
            let is_known = matches!(condition, Expression::Literal(Literal::Bool(_)));
            let counts = is_known && !is_operand(accept, reject);
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

#[test]
fn no_branch_is_left_that_is_never_taken() {
    let mut chance = Chance::new(77);
    let (mut dropped, mut shorter) = (0, 0);
    for (desc, tier) in variants() {
        for round in 0..3 {
            let values = values(desc, tier, (round > 0).then_some(&mut chance));
            let linked = desc.link(tier).unwrap();
            let (pruned, left) = desc.specialised(tier, &[], &values).unwrap();
            let names: Vec<_> = pruned.overrides().collect();
            let module = resolved(&pruned.wgsl, desc, &left);
            assert_eq!(
                branches(&module),
                [""; 0],
                "{} with {values:?}:\n{}",
                desc.name,
                pruned.wgsl
            );
            // Whatever is asked for can be bound.
            let bound: HashSet<_> = pruned.bindings().unwrap().iter().map(|it| it.name).collect();
            for (_, asked) in module.global_variables.iter().filter(|(_, it)| it.binding.is_some())
            {
                let name = asked.name.as_deref().unwrap();
                assert!(bound.contains(name), "{}: {name}", desc.name);
            }
            assert!(left.iter().all(|(name, _)| names.contains(name)), "{}: {left:?}", desc.name);
            shorter += usize::from(pruned.wgsl.len() < linked.wgsl.len() * 3 / 4);
            dropped += branches(&resolved(&linked.wgsl, desc, &values)).len();
        }
    }
    // The check can fail: many functions have such branches before.
    assert!(dropped > 500 && shorter > 50, "{dropped} functions, {shorter} kernels");
}
