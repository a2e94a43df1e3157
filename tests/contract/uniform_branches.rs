//! No branch or loop of a kernel depends on uniform buffers and constants alone: lavapipe recompiles such
//! kernels for every uniform buffer that is bound, and keeps all versions.
use gobo::stage::llvmpipe::{COLUMNS, RUNS};
use gobo_picture::stage::variants;
use naga::{
    AddressSpace, Block, Expression, Function, Handle, Module, Span, Statement, front::wgsl,
};
use std::collections::HashMap;

/// Inputs that a value depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Origin {
    Constant,
    /// Depends only on constants and on fixed offsets in uniform buffers.
    Uniform,
    Varying,
}
use Origin::{Constant, Uniform, Varying};

/// A function and the origins of its arguments.
type Call = (Handle<Function>, Vec<Origin>);

/// Walks a kernel like the driver does, with all calls inlined.
struct Walk<'a> {
    module: &'a Module,
    /// Origins of `var<private>` variables.
    globals: HashMap<Handle<naga::GlobalVariable>, Origin>,
    /// Origins of the return values of calls, and their branches.
    calls: HashMap<Call, (Origin, Vec<Span>)>,
}

/// State of a function during the walk.
struct Frame<'a> {
    function: &'a Function,
    arguments: Vec<Origin>,
    locals: HashMap<Handle<naga::LocalVariable>, Origin>,
    results: HashMap<Handle<Expression>, Origin>,
    returned: Origin,
    branches: Vec<Span>,
}

/// Passes over a function: a loop may assign at its end a variable that is read at its beginning.
const PASSES: usize = 3;

fn branches(module: &Module) -> Vec<Span> {
    let mut walk = Walk { module, globals: HashMap::new(), calls: HashMap::new() };
    let entry = &module.entry_points[0].function;
    let mut found = Vec::new();
    for _ in 0..PASSES {
        walk.calls.clear();
        found = walk.run(entry, vec![Varying; entry.arguments.len()]).1;
    }
    found.sort_by_key(|span| span.to_range().map(|range| range.start));
    found.dedup();
    found
}

impl<'a> Walk<'a> {
    fn call(&mut self, function: Handle<Function>, arguments: Vec<Origin>) -> (Origin, Vec<Span>) {
        let key = (function, arguments);
        if let Some(known) = self.calls.get(&key) {
            return known.clone();
        }
        let result = self.run(&self.module.functions[function], key.1.clone());
        self.calls.insert(key, result.clone());
        result
    }

    fn run(&mut self, function: &'a Function, arguments: Vec<Origin>) -> (Origin, Vec<Span>) {
        let mut frame = Frame {
            function,
            arguments,
            locals: HashMap::new(),
            results: HashMap::new(),
            returned: Constant,
            branches: Vec::new(),
        };
        for (handle, variable) in function.local_variables.iter() {
            let init = variable.init.map_or(Constant, |init| self.origin(&frame, init));
            frame.locals.insert(handle, init);
        }
        for _ in 0..PASSES {
            frame.branches.clear();
            self.block(&mut frame, &function.body, Constant);
        }
        (frame.returned, frame.branches)
    }

    /// `under`: origin of the conditions under which the block runs.
    fn block(&mut self, frame: &mut Frame<'a>, block: &'a Block, under: Origin) {
        for (statement, &span) in block.span_iter() {
            match statement {
                Statement::Emit(range) => {
                    for expression in range.clone() {
                        let origin = self.evaluate(frame, expression);
                        frame.results.insert(expression, origin);
                    }
                }
                Statement::Block(inner) => self.block(frame, inner, under),
                Statement::If { condition, accept, reject } => {
                    let condition = self.branch(frame, *condition, span);
                    self.block(frame, accept, under.max(condition));
                    self.block(frame, reject, under.max(condition));
                }
                Statement::Switch { selector, cases } => {
                    let selector = self.branch(frame, *selector, span);
                    for case in cases {
                        self.block(frame, &case.body, under.max(selector));
                    }
                }
                Statement::Loop { body, continuing, break_if } => {
                    self.block(frame, body, under);
                    self.block(frame, continuing, under);
                    if let Some(condition) = break_if {
                        self.branch(frame, *condition, span);
                    }
                }
                Statement::Return { value: Some(value) } => {
                    let value = self.origin(frame, *value);
                    frame.returned = frame.returned.max(value).max(under);
                }
                Statement::Store { pointer, value } => {
                    let value = self.origin(frame, *value).max(under);
                    self.store(frame, *pointer, value);
                }
                Statement::Call { function, arguments, result } => {
                    let origins =
                        arguments.iter().map(|&argument| self.origin(frame, argument)).collect();
                    // Writes through pointers are not tracked.
                    arguments.iter().for_each(|&argument| self.store(frame, argument, Varying));
                    let (returned, branches) = self.call(*function, origins);
                    frame.branches.extend(branches);
                    if let Some(result) = result {
                        frame.results.insert(*result, returned);
                    }
                }
                _ => {}
            }
        }
    }

    fn branch(&self, frame: &mut Frame<'a>, condition: Handle<Expression>, span: Span) -> Origin {
        let origin = self.origin(frame, condition);
        if origin == Uniform {
            frame.branches.push(span);
        }
        origin
    }

    fn store(&mut self, frame: &mut Frame<'a>, pointer: Handle<Expression>, value: Origin) {
        match frame.function.expressions[pointer] {
            Expression::LocalVariable(variable) => {
                let known = frame.locals.entry(variable).or_insert(Constant);
                *known = value.max(*known);
            }
            Expression::GlobalVariable(variable) => {
                let known = self.globals.entry(variable).or_insert(Constant);
                *known = value.max(*known);
            }
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => {
                self.store(frame, base, value);
            }
            _ => {}
        }
    }

    fn origin(&self, frame: &Frame<'a>, expression: Handle<Expression>) -> Origin {
        let known = frame.results.get(&expression).copied();
        known.unwrap_or_else(|| self.evaluate(frame, expression))
    }

    fn evaluate(&self, frame: &Frame<'a>, expression: Handle<Expression>) -> Origin {
        use Expression as E;
        let of = |handle: Handle<Expression>| self.origin(frame, handle);
        match &frame.function.expressions[expression] {
            E::Literal(_)
            | E::Constant(_)
            | E::Override(_)
            | E::ZeroValue(_)
            | E::CallResult(_) => Constant,
            E::Compose { components, .. } => {
                components.iter().map(|&component| of(component)).max().unwrap_or(Constant)
            }
            // Only fixed offsets in a uniform buffer can be read ahead.
            E::Access { base, index } => match of(*index) {
                Constant => of(*base),
                _ => Varying,
            },
            E::AccessIndex { base, .. } => of(*base),
            E::Splat { value, .. } => of(*value),
            E::Swizzle { vector, .. } => of(*vector),
            E::FunctionArgument(index) => frame.arguments[*index as usize],
            E::GlobalVariable(variable) => match self.module.global_variables[*variable].space {
                AddressSpace::Uniform => Uniform,
                AddressSpace::Private => self.globals.get(variable).copied().unwrap_or(Constant),
                _ => Varying,
            },
            E::LocalVariable(variable) => frame.locals.get(variable).copied().unwrap_or(Constant),
            E::Load { pointer } => of(*pointer),
            E::Unary { expr, .. } | E::As { expr, .. } => of(*expr),
            E::Binary { left, right, .. } => of(*left).max(of(*right)),
            E::Select { condition, accept, reject } => {
                of(*condition).max(of(*accept)).max(of(*reject))
            }
            E::Math { arg, arg1, arg2, arg3, .. } => [Some(*arg), *arg1, *arg2, *arg3]
                .into_iter()
                .flatten()
                .map(of)
                .max()
                .unwrap_or(Constant),
            E::Relational { argument, .. } => of(*argument),
            // A call that is not reached yet.
            _ => Varying,
        }
    }
}

#[test]
fn no_branch_is_uniform() {
    let mut found = Vec::new();
    for (desc, tier) in variants() {
        let source = desc.specialised(tier, &[&COLUMNS[..], &[RUNS]].concat(), &[]).unwrap();
        for span in branches(&wgsl::parse_str(&source.wgsl).unwrap()) {
            let line = source.wgsl[span.to_range().unwrap()].lines().next().unwrap_or_default();
            found.push(format!("{} ({tier:?}): {line}", desc.name));
        }
    }
    assert!(found.is_empty(), "{} branches:\n{}", found.len(), found.join("\n"));
}

#[test]
fn a_uniform_branch_is_noticed() {
    let count = |body: &str| {
        let wgsl = format!(
            "@group(0) @binding(0) var<uniform> bounds: array<vec4<u32>, 4>;\n\
             @group(0) @binding(1) var<storage, read_write> words: array<u32>;\n\
             fn beyond(i: u32, end: u32) -> bool {{ return i >= end; }}\n\
             @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3<u32>) \
             {{ {body} }}"
        );
        branches(&wgsl::parse_str(&wgsl).unwrap()).len()
    };
    let cases = [
        ("if bounds[0].x > 3u { words[0] = 1u; }", 1),
        ("for (var i = 0u; i < bounds[1].y; i += 1u) { words[i] = 1u; }", 1),
        ("let end = bounds[2]; if beyond(5u, end.z) { words[0] = 1u; }", 1),
        ("var end = 7u; end = min(end, bounds[0].x); if end > 2u { words[0] = 1u; }", 1),
        ("if id.x < bounds[0].x { words[0] = 1u; }", 0),
        ("if bounds[id.x].x > 3u { words[0] = 1u; }", 0),
        ("for (var i = 0u; i < words[0]; i += 1u) { words[i] = 1u; }", 0),
        ("for (var i = id.x; i < bounds[1].y; i += 1u) { words[i] = 1u; }", 0),
        ("if select(words[0], 1u, bounds[0].x > 3u) == 1u { words[0] = 1u; }", 0),
    ];
    for (body, expected) in cases {
        assert_eq!(count(body), expected, "{body}");
    }
}
