//! Unrolled loops: `for (var i = 0u; i < unrolled(N); i += 1u) { .. }` becomes N blocks, each with its
//! `const i`. Drivers of software adapters keep arrays in registers only where indices are literals.
//! Compilers of GPUs keep a loop of one turn if it contains others, with all values that it leaves unchanged
//! in registers.
//!
//! This is done in the text, where a block is copied as it is. In a module, expressions are evaluated once,
//! so that a copy would need a copy of every kind of expression, with its operands.
use super::{Constant, Linked, parse::code};
use std::fmt::Write as _;

const MARK: &str = "< unrolled(";

/// A loop in a text.
struct Loop<'a> {
    start: usize,
    end: usize,
    counter: &'a str,
    first: u32,
    turns: &'a str,
    body: &'a str,
}

impl Linked {
    /// `wgsl`, which is this source with these values, with its marked loops of at most `max_turns` turns
    /// unrolled. Lines keep their positions.
    pub fn unrolled(&self, mut wgsl: String, constants: &[Constant], max_turns: u32) -> String {
        let mut read = 0;
        // The first loop contains others.
        while let Some(Loop { start, end, counter, first, turns, body }) = marked_loop(&wgsl, read)
        {
            let known = self.value(turns, constants);
            let Some(turns) = known.filter(|turns| turns.saturating_sub(first) <= max_turns) else {
                read = end - body.len() - 1;
                continue;
            };
            let flat: String =
                code(body, 0).map(|(_, c)| if c == '\n' { ' ' } else { c }).collect();
            let mut blocks = format!("{{ const {counter} = {first}u; {body} }}");
            for turn in first + 1..turns {
                let _ = write!(blocks, " {{ const {counter} = {turn}u; {flat} }}");
            }
            wgsl.replace_range(start..end, if first < turns { &blocks } else { "" });
        }
        wgsl
    }

    /// Value of an expression of names, numbers and operators.
    fn value(&self, expression: &str, constants: &[Constant]) -> Option<u32> {
        let mut words = expression.split_whitespace();
        let mut value = self.number(words.next()?, constants)?;
        while let Some(operator) = words.next() {
            let other = self.number(words.next()?, constants)?;
            value = match operator {
                "+" => value.checked_add(other)?,
                "-" => value.checked_sub(other)?,
                "/" => value.checked_div(other)?,
                _ => return None,
            };
        }
        Some(value)
    }

    fn number(&self, word: &str, constants: &[Constant]) -> Option<u32> {
        if let Ok(number) = word.trim_end_matches('u').parse() {
            return Some(number);
        }
        let item = self.items.iter().find(|item| item.name == word)?;
        let given = item.constant(constants).map(|(_, declaration)| declaration);
        let declaration = given.unwrap_or_else(|| code(item.text, 0).map(|(_, c)| c).collect());
        self.value(declaration.split_once('=')?.1.split(';').next()?, constants)
    }
}

/// The first marked loop at or behind byte `from`.
fn marked_loop(wgsl: &str, from: usize) -> Option<Loop<'_>> {
    let mark = from + wgsl[from..].find(MARK)?;
    let start = wgsl[..mark].rfind("for (var ")?;
    let (counter, rest) = wgsl[start..mark].strip_prefix("for (var ")?.split_once(" = ")?;
    let first = rest.split_once("u;")?.0.parse().ok()?;
    let (turns, rest) = wgsl[mark + MARK.len()..].split_once(')')?;
    let open = wgsl.len() - rest.len() + rest.find('{')?;
    let mut depth = 0_i32;
    let (close, _) = code(wgsl, open).find(|&(_, c)| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        depth == 0
    })?;
    Some(Loop { start, end: close + 1, counter, first, turns, body: &wgsl[open + 1..close] })
}

#[cfg(test)]
mod tests {
    use super::super::Library;
    use naga::front::wgsl::parse_str;

    const KERNEL: &str = "const ROWS: u32 = MOST / 2u; // four
        override MOST: u32 = 8u;
        var<private> held: array<u32, 8>;
        fn unrolled(turns: u32) -> u32 { return turns; }
        @compute @workgroup_size(1) fn k() {
            for (var i = 1u; i < unrolled(ROWS - 1u); i += 1u) {
                // Each } of them.
                for (var n = 0u; n < unrolled(2u); n += 1u) { held[i] += n; }
            }
            for (var i = 0u; i < unrolled(ROWS - 4u); i += 1u) { held[i] = 0u; }
            for (var i = 0u; i < ROWS; i += 1u) { held[i] = 0u; }
        }";

    #[test]
    fn marked_loops_are_written_out() {
        let library = Library::new(&[("k.wgsl", KERNEL)]).unwrap();
        let linked = library.link("k.wgsl", "k", &[]).unwrap();
        let constants = [("MOST", 8.0)];
        let text = linked.with_values(&constants);
        let unrolled = linked.unrolled(text.clone(), &constants, u32::MAX);
        assert_eq!(unrolled.matches('\n').count(), text.matches('\n').count());
        assert_eq!(unrolled.matches("held[i] += n").count(), 4, "{unrolled}");
        assert_eq!(unrolled.matches("const i = 2u;").count(), 1, "{unrolled}");
        assert_eq!(unrolled.matches("const n = 1u;").count(), 2, "{unrolled}");
        assert_eq!(unrolled.matches("held[i] = 0u").count(), 1, "{unrolled}");
        parse_str(&unrolled).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&unrolled)));
        let fewer = linked.unrolled(text.clone(), &[("MOST", 4.0)], u32::MAX);
        assert_eq!(fewer.matches("held[i] += n").count(), 0, "{fewer}");
        let short = linked.unrolled(text, &[("MOST", 6.0)], 1);
        assert_eq!(short.matches("const i = 1u;").count(), 1, "{short}");
        assert_eq!(short.matches("n < unrolled(2u)").count(), 1, "{short}");
    }
}
