//! Removal of unreachable code from modules. Compilers inline all of it before they see that nothing uses it,
//! which takes lavapipe half the time of its own passes.
use naga::{
    Arena, Block, Expression, Function, Handle, Literal, LocalVariable, Module, Statement,
    UnaryOperator,
    compact::{KeepUnused, compact},
};
use std::{collections::HashMap, mem};

/// Functions without arguments that always return the same value.
type Answers = HashMap<Handle<Function>, bool>;

/// Removes branches whose conditions are known to be false, and all declarations that only these use.
pub(in crate::gpu) fn prune(module: &mut Module) {
    let mut answers = Answers::new();
    let mut functions = module.functions.take();
    // A function stands behind those that it calls.
    for (handle, function) in functions.iter_mut() {
        if let Some(answer) = prune_function(function, module, &answers) {
            answers.insert(handle, answer);
        }
    }
    module.functions = functions;
    let mut entry_points = mem::take(&mut module.entry_points);
    for entry_point in &mut entry_points {
        prune_function(&mut entry_point.function, module, &answers);
    }
    module.entry_points = entry_points;
    // `compact` keeps everything with a name.
    module.constants.iter_mut().for_each(|(_, constant)| constant.name = None);
    compact(module, KeepUnused::No);
}

/// Prunes a function, and returns its constant answer if it has one.
fn prune_function(function: &mut Function, module: &Module, answers: &Answers) -> Option<bool> {
    function.named_expressions.clear();
    let mut walk = Traversal {
        module,
        answers,
        expressions: &mut function.expressions,
        variables: &function.local_variables,
        stored: HashMap::new(),
    };
    function.body = walk.block(mem::take(&mut function.body));
    let (last, before) = function.body.split_last()?;
    let is_constant = function.arguments.is_empty() && before.iter().all(|it| walk.is_silent(it));
    match last {
        Statement::Return { value: Some(value) } if is_constant => walk.known(*value),
        _ => None,
    }
}

struct Traversal<'a> {
    module: &'a Module,
    answers: &'a Answers,
    expressions: &'a mut Arena<Expression>,
    variables: &'a Arena<LocalVariable>,
    /// Values of `&&` and `||`, which naga stores in nameless variables, each in the branches of one `if`.
    /// `None`: only known at run time.
    stored: HashMap<Handle<LocalVariable>, Option<bool>>,
}

impl Traversal<'_> {
    fn block(&mut self, block: Block) -> Block {
        let mut kept = Vec::with_capacity(block.len());
        for (statement, _) in block.span_into_iter() {
            self.statement(statement, &mut kept);
            let ends = |it: &Statement| {
                matches!(it, Statement::Break | Statement::Continue | Statement::Return { .. })
            };
            if kept.last().is_some_and(ends) {
                break;
            }
        }
        // Without positions, which differ where only values of constants do.
        Block::from_vec(kept)
    }

    fn statement(&mut self, statement: Statement, kept: &mut Vec<Statement>) {
        let is_idle = |block: &Block| block.iter().all(|it| matches!(it, Statement::Emit(_)));
        match statement {
            Statement::If { condition, accept, reject } => match self.known(condition) {
                Some(is_true) => self.splice(if is_true { accept } else { reject }, kept),
                None => {
                    let (accept, reject) = (self.block(accept), self.block(reject));
                    if !(is_idle(&accept) && is_idle(&reject)) {
                        kept.push(Statement::If { condition, accept, reject });
                    }
                }
            },
            Statement::Block(block) => self.splice(block, kept),
            Statement::Switch { selector, mut cases } => {
                for case in &mut cases {
                    case.body = self.block(mem::take(&mut case.body));
                }
                kept.push(Statement::Switch { selector, cases });
            }
            Statement::Loop { body, continuing, break_if } => {
                let (body, continuing) = (self.block(body), self.block(continuing));
                let first = body.iter().find(|it| !self.is_silent(it));
                if !matches!(first, Some(Statement::Break)) {
                    kept.push(Statement::Loop { body, continuing, break_if });
                }
            }
            Statement::Call { function, result: Some(result), .. }
                if self.answers.contains_key(&function) =>
            {
                self.expressions[result] =
                    Expression::Literal(Literal::Bool(self.answers[&function]));
            }
            Statement::Store { pointer, value } => {
                if let Some(variable) = self.operand(pointer) {
                    let value = self.known(value);
                    let stored = self.stored.entry(variable).or_insert(value);
                    *stored = stored.filter(|_| *stored == value);
                }
                kept.push(Statement::Store { pointer, value });
            }
            other => kept.push(other),
        }
    }

    fn splice(&mut self, block: Block, kept: &mut Vec<Statement>) {
        kept.extend(self.block(block).span_into_iter().map(|(statement, _)| statement));
    }

    /// Whether it only evaluates expressions.
    fn is_silent(&self, statement: &Statement) -> bool {
        match statement {
            Statement::Emit(_) => true,
            Statement::Store { pointer, .. } => self.operand(*pointer).is_some(),
            _ => false,
        }
    }

    /// The variable of an `&&` or `||`.
    fn operand(&self, pointer: Handle<Expression>) -> Option<Handle<LocalVariable>> {
        match self.expressions[pointer] {
            Expression::LocalVariable(variable) => {
                self.variables[variable].name.is_none().then_some(variable)
            }
            _ => None,
        }
    }

    fn known(&self, expression: Handle<Expression>) -> Option<bool> {
        match self.expressions[expression] {
            Expression::Literal(Literal::Bool(value)) => Some(value),
            Expression::Constant(constant) => {
                match self.module.global_expressions[self.module.constants[constant].init] {
                    Expression::Literal(Literal::Bool(value)) => Some(value),
                    _ => None,
                }
            }
            Expression::Unary { op: UnaryOperator::LogicalNot, expr } => {
                self.known(expr).map(|value| !value)
            }
            Expression::Load { pointer } => *self.stored.get(&self.operand(pointer)?)?,
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naga::{
        front::wgsl::parse_str,
        valid::{Capabilities, ValidationFlags, Validator},
    };

    const SOURCE: &str = "var<private> held: u32;
        fn act(i: u32) { held += i; }
        fn zero() { act(0u); } fn one() { act(1u); } fn two() { act(2u); } fn three() { act(3u); }
        fn four() { act(4u); } fn five() { act(5u); } fn six() { act(6u); } fn seven() { act(7u); }
        fn is_lit() -> bool { return held > 9u; }
        fn has_both() -> bool { return A && B; }
        @compute @workgroup_size(1) fn main() {
            if A { zero(); } else if is_lit() { one(); }
            if B && is_lit() { two(); }
            if is_lit() && B { three(); }
            if !(A || is_lit() || !B) { four(); }
            if has_both() { five(); }
            for (var i = 0u; A && i < 2u; i += 1u) { six(); }
            if A { return; }
            seven();
        }";

    fn pruned(a: bool, b: bool, unused: &str) -> Module {
        let constants = format!("const UNUSED: bool = {unused};\nconst A: bool = {a};\n");
        let wgsl = format!("{constants}const B: bool = {b};\n{SOURCE}");
        let mut module = parse_str(&wgsl).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&wgsl)));
        prune(&mut module);
        let validator = &mut Validator::new(ValidationFlags::all(), Capabilities::all());
        validator.validate(&module).unwrap_or_else(|error| panic!("{error:?}"));
        module
    }

    #[test]
    fn what_is_never_reached_is_left_out() {
        for (a, b, wanted) in [
            (true, true, &["zero", "two", "three", "five", "six"][..]),
            (true, false, &["zero", "six"]),
            (false, true, &["one", "two", "three", "four", "seven"]),
            (false, false, &["one", "seven"]),
        ] {
            let module = pruned(a, b, "true");
            let functions = module.functions.iter().filter_map(|(_, it)| it.name.as_deref());
            let helpers = ["act", "is_lit"];
            let left: Vec<_> = functions.filter(|name| !helpers.contains(name)).collect();
            assert_eq!(left, wanted, "{a} {b}");
        }
    }

    #[test]
    fn modules_of_the_same_code_are_the_same() {
        let text = |unused| format!("{:?}", pruned(true, false, unused));
        assert_eq!(text("true"), text("false"));
        assert_ne!(text("true"), format!("{:?}", pruned(false, true, "true")));
    }
}
