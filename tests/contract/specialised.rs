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
fn with_values(module: &Module, entry: &str, values: &[Constant]) -> Module {
    let info = Validator::new(ValidationFlags::all(), Capabilities::all())
        .subgroup_stages(ShaderStages::COMPUTE)
        .subgroup_operations(SubgroupOperationSet::all())
        .validate(module)
        .unwrap_or_else(|e| panic!("{entry} with {values:?}: {:?}", e.into_inner()));
    let known =
        |name: &str| module.overrides.iter().any(|(_, it)| it.name.as_deref() == Some(name));
    let values = values.iter().filter(|(name, _)| known(name));
    let values = values.map(|&(name, value)| (name.to_owned(), value)).collect();
    let entry = Some((ShaderStage::Compute, entry));
    let resolved = process_overrides(module, &info, entry, &values);
    resolved.unwrap_or_else(|error| panic!("{entry:?} with {values:?}: {error}")).0.into_owned()
}

fn resolved(wgsl: &str, desc: &KernelDesc, values: &[Constant]) -> Module {
    let module = naga::front::wgsl::parse_str(wgsl);
    let module = module.unwrap_or_else(|error| panic!("{}", error.emit_to_string(wgsl)));
    with_values(&module, desc.entry, values)
}

/// Whether branches are those of `&&` or `||`, which store its value in a nameless variable.
fn is_operand(accept: &Block, reject: &Block, function: &Function) -> bool {
    [accept, reject].into_iter().all(|block| match block.last() {
        Some(Statement::Store { pointer, .. }) => match function.expressions[*pointer] {
            Expression::LocalVariable(it) => function.local_variables[it].name.is_none(),
            _ => false,
        },
        _ => false,
    })
}

/// Whether a condition is a constant, or the value of one: `HAS_X` is the former, `!HAS_X` the latter.
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
            "override HAS_X: bool = true;\noverride MANY: u32 = 3u;\nvar<private> lit: u32;\n\
             fn is_lit() -> bool {{ return lit > 0u; }}\n\
             @compute @workgroup_size(1) fn main() {{ if {condition} {{ lit += 1u; }} }}"
        );
        let module = naga::front::wgsl::parse_str(&wgsl).unwrap();
        assert_eq!(branches(&with_values(&module, "main", &[])).len(), count, "{condition}");
    }
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
