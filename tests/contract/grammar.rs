//! Naga accepts WGSL that is invalid: the language requires parentheses between operators of some kinds
//! (<https://www.w3.org/TR/WGSL/#operator-precedence-associativity>), naga does not.
use crate::common::wgsl_files;

/// Names that a template list follows.
fn is_template(word: &str) -> bool {
    ["vec2", "vec3", "vec4", "array", "bitcast", "ptr", "atomic", "var"].contains(&word)
        || word.starts_with("texture_")
        || word.starts_with("mat") && word.contains('x')
}

/// A token and its line. Template lists and comments are left out.
fn tokens(text: &str) -> Vec<(String, usize)> {
    let mut found = Vec::<(String, usize)>::new();
    for (line, code) in (1..).zip(text.lines()) {
        let code = code.split("//").next().unwrap_or_default();
        let mut rest = code.trim_start();
        while let Some(first) = rest.chars().next() {
            let is_word = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
            let after = found.last().map(|(token, _)| token.as_str());
            let length = if first == '<' && after.is_some_and(is_template) {
                let mut depth = 0;
                let ends = |(_, c): &(usize, char)| {
                    depth += i32::from(*c == '<') - i32::from(*c == '>');
                    depth == 0
                };
                let end = rest.char_indices().find(ends).map_or(rest.len(), |(i, _)| i + 1);
                rest = rest[end..].trim_start();
                continue;
            } else if is_word(first) {
                rest.find(|c| !is_word(c)).unwrap_or(rest.len())
            } else {
                let pairs = ["&&", "||", "<<", ">>", "<=", ">=", "==", "!=", "->"];
                if pairs.iter().any(|pair| rest.starts_with(pair)) { 2 } else { 1 }
            };
            found.push((rest[..length].to_owned(), line));
            rest = rest[length..].trim_start();
        }
    }
    found
}

/// Precedence class of a binary operator; `None` for other tokens.
fn kind(token: &str) -> Option<&'static str> {
    Some(match token {
        "&" | "|" | "^" => "bits",
        "<<" | ">>" => "shift",
        "<" | ">" | "<=" | ">=" | "==" | "!=" => "relation",
        "&&" | "||" => "logic",
        "+" | "-" | "*" | "/" | "%" => "arithmetic",
        _ => return None,
    })
}

/// Whether operators may be mixed without parentheses.
fn may_meet(operators: &[&str]) -> bool {
    let of = |wanted: &str| operators.iter().filter(|o| kind(o) == Some(wanted)).count();
    let is_one = |among: &[&str]| among.windows(2).all(|pair| pair[0] == pair[1]);
    if of("bits") > 0 {
        return is_one(operators);
    }
    let logic: Vec<_> = operators.iter().copied().filter(|o| kind(o) == Some("logic")).collect();
    is_one(&logic)
        && operators.split(|o| kind(o) == Some("logic")).all(|part| {
            let relations = part.iter().filter(|o| kind(o) == Some("relation")).count();
            relations <= 1
                && part
                    .split(|o| kind(o) == Some("relation"))
                    .all(|side| side.len() == 1 || side.iter().all(|o| kind(o) != Some("shift")))
        })
}

/// Lines that lack parentheses.
fn wanting(text: &str) -> Vec<usize> {
    // Per open bracket: the operators since the last separator.
    let mut open = vec![Vec::<String>::new()];
    let mut before = String::from(";");
    let mut lines = Vec::new();
    for (token, line) in tokens(text) {
        let follows_value = before.ends_with(|c: char| c.is_alphanumeric() || "_.)]".contains(c))
            && !["return", "if", "while", "case"].contains(&before.as_str());
        let mut ends = |operators: &mut Vec<String>| {
            if !may_meet(&operators.iter().map(String::as_str).collect::<Vec<_>>()) {
                lines.push(line);
            }
            operators.clear();
        };
        let innermost = open.last_mut().expect("text that naga parses has no bracket too many");
        match token.as_str() {
            "(" | "[" => open.push(Vec::new()),
            ")" | "]" => {
                ends(innermost);
                open.pop();
            }
            "," | ";" | "{" | "}" | ":" => ends(innermost),
            // `=`, or the end of `+=`.
            "=" => innermost.clear(),
            operator if kind(operator).is_some() && follows_value => {
                innermost.push(operator.to_owned());
            }
            _ => {}
        }
        before = token;
    }
    lines
}

#[test]
fn operators_have_their_parentheses() {
    let mut bad = Vec::new();
    for (path, text) in wgsl_files() {
        bad.extend(wanting(&text).into_iter().map(|line| format!("wgsl/{path}:{line}")));
    }
    assert_eq!(bad, [""; 0], "put parentheses around one of the operators");
}

/// Pairs of lines: one that naga parses although it is invalid WGSL, and the valid one.
#[test]
fn missing_parentheses_are_noticed() {
    for line in [
        "let x = a > b | c;",
        "let x = a & b < c;",
        "let x = f(1u, a & b == c);",
        "let x = a & b | c;",
        "let x = a && b || c;",
        "let x = a << b + c;",
        "let x = (a * 3u >> 4u) & 7u;",
        "x[a < b & c] = 1u;",
        "if a | b > c {",
    ] {
        assert_eq!(wanting(line), [1], "{line}");
    }
    for line in [
        "let x = (a > b) | c;",
        "let x = a & (b < c);",
        "let x = vec4<u32>(a) & vec2<bool>(b) & c;",
        "let x = a << 4u < b >> 2u && c || d;".split(" ||").next().unwrap_or_default(),
        "let x = f(a & b, c | d) + -e * !f;",
        "x += a & b; x = &y; return -a * b;",
        "for (var i = 0u; i < 4u && b; i += 1u) {",
        "let x: vec4<bool> = a | array<vec4<f32>, 2>(b)[1];",
        "@group(0) @binding(1) var<storage, read> x: array<u32>; // a > b | c",
    ] {
        assert_eq!(wanting(line), [0; 0], "{line}");
    }
}
