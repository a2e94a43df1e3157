//! Values of expressions, as far as the overrides of a kernel tell them.
use super::{Item, words};
use crate::gpu::Constant;
use std::collections::HashMap;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value {
    Bool(bool),
    Number(f64),
    /// Known at run time only, or by rules that this file does not have.
    Unknown,
}

/// Overrides and constants of a kernel, and its functions without parameters that only return an expression.
pub(super) struct Known<'a> {
    expressions: HashMap<&'a str, &'a str>,
    values: HashMap<&'a str, f64>,
}

impl<'a> Known<'a> {
    pub(super) fn new(items: &'a [Item], values: &'a [Constant]) -> Self {
        let named = |item: &'a Item| Some((item.name, expression(item)?));
        Self {
            expressions: items.iter().filter_map(named).collect(),
            values: values.iter().copied().collect(),
        }
    }

    pub(super) fn value(&self, expression: &str) -> Value {
        let mut reader = Reader { known: self, rest: expression };
        let value = reader.either();
        if reader.next().is_empty() { value } else { Value::Unknown }
    }

    fn named(&self, name: &str) -> Value {
        let own = self.expressions.get(name).map(|expression| self.value(expression));
        match (own, self.values.get(name)) {
            (Some(Value::Bool(_)), Some(&given)) => Value::Bool(given != 0.0),
            (_, Some(&given)) => Value::Number(given),
            (own, None) => own.unwrap_or(Value::Unknown),
        }
    }
}

/// What a constant or an override is set to, or a function returns.
fn expression(item: &Item) -> Option<&'static str> {
    let (start, _) = words(item.text).find(|(_, word)| *word == item.keyword)?;
    let code = &item.text[start..];
    if item.keyword != "fn" {
        let is_set = matches!(item.keyword, "const" | "override");
        return is_set.then(|| code.split_once(';')?.0.split_once('=').map(|(_, set)| set))?;
    }
    let (head, body) = code.split_once('{')?;
    let (returned, rest) = body.trim_start().strip_prefix("return ")?.split_once(';')?;
    (head.contains("()") && rest.trim_start().starts_with('}')).then_some(returned)
}

/// Reader of an expression. Every operator but `&&` and `||` is read from the left, as the value is unknown
/// where more than one comparison stands between them.
struct Reader<'a> {
    known: &'a Known<'a>,
    rest: &'a str,
}

/// Longer ones first.
const OPERATORS: [&str; 16] =
    ["==", "!=", "<=", ">=", "<<", ">>", "<", ">", "+", "-", "*", "/", "%", "&", "|", "^"];

impl<'a> Reader<'a> {
    /// The rest, without spaces before it.
    fn next(&mut self) -> &'a str {
        self.rest = self.rest.trim_start();
        self.rest
    }

    fn takes(&mut self, mark: &str) -> bool {
        let rest = self.next().strip_prefix(mark);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn either(&mut self) -> Value {
        let mut value = self.both();
        while self.takes("||") {
            value = joined(value, self.both(), true);
        }
        value
    }

    fn both(&mut self) -> Value {
        let mut value = self.compared();
        while self.takes("&&") {
            value = joined(value, self.compared(), false);
        }
        value
    }

    fn compared(&mut self) -> Value {
        let mut value = self.one();
        loop {
            let rest = self.next();
            let operator = OPERATORS.into_iter().find(|operator| rest.starts_with(operator));
            let ends = rest.starts_with("&&") || rest.starts_with("||");
            let Some(operator) = operator.filter(|_| !ends) else { return value };
            self.takes(operator);
            value = compare(value, operator, self.one());
        }
    }

    fn one(&mut self) -> Value {
        if self.takes("!") {
            return match self.one() {
                Value::Bool(value) => Value::Bool(!value),
                _ => Value::Unknown,
            };
        }
        if ["-", "~", "&", "*"].into_iter().any(|sign| self.takes(sign)) {
            self.one();
            return Value::Unknown;
        }
        let value = if self.next().starts_with('(') {
            let inner = self.enclosed();
            self.known.value(inner)
        } else {
            self.word()
        };
        if self.takes_members() { Value::Unknown } else { value }
    }

    /// A name, a number or a call.
    fn word(&mut self) -> Value {
        let rest = self.next();
        let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == '.'));
        let (word, rest) = rest.split_at(end.unwrap_or(rest.len()));
        self.rest = rest;
        if self.next().starts_with('(') && !self.enclosed().trim().is_empty() {
            return Value::Unknown;
        }
        match word {
            "true" => Value::Bool(true),
            "false" => Value::Bool(false),
            _ if word.starts_with(|c: char| c.is_ascii_digit()) => {
                let number = word.trim_end_matches(['u', 'i', 'f']).parse();
                number.map_or(Value::Unknown, Value::Number)
            }
            _ => self.known.named(word),
        }
    }

    /// What stands in the parentheses or brackets that come next, which it skips.
    fn enclosed(&mut self) -> &'a str {
        let text = self.rest;
        let mut depth = 0_i32;
        let end = text.find(|c| {
            depth += i32::from("([".contains(c)) - i32::from(")]".contains(c));
            depth == 0
        });
        let (inner, rest) = text.split_at(end.unwrap_or_default());
        self.rest = rest.get(1..).unwrap_or_default();
        inner.get(1..).unwrap_or_default()
    }

    /// Skips accesses to members and elements.
    fn takes_members(&mut self) -> bool {
        let mut is_any = false;
        while self.next().starts_with(['.', '[', '(']) {
            if self.takes(".") {
                self.rest = self.rest.trim_start_matches(|c: char| c.is_alphanumeric() || c == '_');
            } else {
                self.enclosed();
            }
            is_any = true;
        }
        is_any
    }
}

/// `a || b` where `settles` is true, `a && b` where it is false.
fn joined(a: Value, b: Value, settles: bool) -> Value {
    match (a, b) {
        (Value::Bool(known), other) | (other, Value::Bool(known)) => {
            if known == settles {
                Value::Bool(known)
            } else {
                other
            }
        }
        _ => Value::Unknown,
    }
}

fn compare(a: Value, operator: &str, b: Value) -> Value {
    let (Value::Number(a), Value::Number(b)) = (a, b) else { return Value::Unknown };
    Value::Bool(match operator {
        "==" => a == b,
        "!=" => a != b,
        "<" => a < b,
        "<=" => a <= b,
        ">" => a > b,
        ">=" => a >= b,
        _ => return Value::Unknown,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::link::Library;

    #[test]
    fn values_are_known_as_far_as_overrides_tell() {
        const SOURCE: &str = "// A = B, C() { return true; }\noverride A: bool = false; // = true;\n\
            override COUNT: u32 = 4u;\noverride SIZE: u32;\nconst LEAST = 2u;\n\
            fn is_many() -> bool { return COUNT > LEAST; } // more\n\
            fn is_lit(a: bool) -> bool { return a; }\nfn two() -> bool { let a = 1; return true; }\n\
            fn root() { A; COUNT; SIZE; is_many(); is_lit(A); two(); }\n";
        let library = Library::new(&[("k.wgsl", SOURCE)]).unwrap();
        let items = library.link("k.wgsl", "root", &[]).unwrap().items;
        let given = [("A", 1.0), ("SIZE", 64.0)];
        let known = Known::new(&items, &given);
        let (yes, no, open) = (Value::Bool(true), Value::Bool(false), Value::Unknown);
        for (expression, value) in [
            ("A", yes),
            ("!A", no),
            ("B", open),
            ("B && !A", no),
            ("!A && B", no),
            ("A && B", open),
            ("B || A", yes),
            ("!(A || B)", no),
            ("!B || !A", open),
            ("B || C && !A", open),
            ("A || C && B", yes),
            ("COUNT > 4u", no),
            ("COUNT >= 4u && SIZE == 64u", yes),
            ("COUNT < 0x10u", open),
            ("is_many()", yes),
            ("two()", open),
            ("is_lit(!A)", open),
            ("!is_many() || place.x < 2u", open),
            ("is_many() && (place[A].x) < 2u", open),
            ("!is_many() && (place(A, B).x) < 2u", no),
            ("COUNT + 1u > 2u", open),
            ("COUNT - 4u == 0u || A", yes),
            ("A.x", open),
            ("(A).x", open),
            ("A = B", open),
            ("-COUNT < 1u", open),
            ("(SIZE & 1u) == 0u", open),
            ("select(A, B, true)", open),
            ("", open),
            ("(A", open),
        ] {
            assert_eq!(known.value(expression), value, "{expression}");
        }
    }
}
