//! Kernels without what the values of their overrides leave unreached.
use super::{
    Linked, code,
    value::{Known, Value},
    words,
};
use crate::gpu::Constant;
use std::collections::{BTreeSet, HashMap};

impl Linked {
    /// What the entry point reaches with these values of the overrides: no branch whose condition is false,
    /// and no declaration that only such branches use. Compilers inline all of it before they see that
    /// nothing asks for it, which takes lavapipe half of the time for its own passes.
    pub(in crate::gpu) fn pruned(self, entry: &str, values: &[Constant]) -> Self {
        let known = Known::new(&self.items, values);
        let texts: Vec<_> = self.texts().map(|text| without_dead(text, &known)).collect();
        let places: HashMap<_, _> = self.items.iter().map(|item| item.name).zip(0..).collect();
        let mut reached: BTreeSet<usize> = places.get(entry).copied().into_iter().collect();
        let mut pending: Vec<_> = reached.iter().copied().collect();
        while let Some(at) = pending.pop() {
            let named = words(&texts[at]).filter_map(|(_, word)| places.get(word).copied());
            pending.extend(named.filter(|&place| reached.insert(place)));
        }
        Self::of(reached.into_iter().map(|at| (self.items[at].clone(), texts[at].as_str())))
    }

    /// The parts of the source that belong to the items.
    fn texts(&self) -> impl Iterator<Item = &str> {
        let counts = self.lines.windows(2).map(|lines| lines[1] - lines[0]).chain([usize::MAX]);
        let mut lines = self.wgsl.split_inclusive('\n');
        let mut rest = self.wgsl.as_str();
        counts.map(move |count| {
            let end = lines.by_ref().take(count).map(str::len).sum();
            let (text, after) = rest.split_at(end);
            rest = after;
            text.trim_end()
        })
    }
}

/// A declaration without the branches that are never taken. Lines stay where they are.
fn without_dead(text: &str, known: &Known<'_>) -> String {
    let mut kept = String::with_capacity(text.len());
    let mut start = 0;
    while let Some(Branch { at, is_loop, condition, block }) = Branch::next(text, start) {
        let end = block_end(text, block);
        let other = after_else(text, end);
        kept += &text[start..at];
        match known.value(condition) {
            Value::Bool(true) if !is_loop => {
                start = other.map_or(end, |other| branches_end(text, other));
                kept += &blank(&text[at..block]);
                kept += &without_dead(&text[block..end], known);
                kept += &blank(&text[end..start]);
            }
            Value::Bool(false) => {
                start = other.unwrap_or(end);
                // A block stands behind the `else` before, if there is one.
                kept += if other.is_some() { "" } else { "{}" };
                kept += &blank(&text[at..start]);
            }
            _ => {
                start = block + 1;
                kept += &text[at..start];
            }
        }
    }
    kept + &text[start..]
}

/// An `if`, or a `for` whose body may be left out.
struct Branch<'a> {
    /// Start of the keyword.
    at: usize,
    is_loop: bool,
    condition: &'a str,
    /// Start of the block behind it.
    block: usize,
}

impl<'a> Branch<'a> {
    /// The next one from `start` on.
    fn next(text: &'a str, start: usize) -> Option<Self> {
        let (at, keyword) = words(&text[start..]).find(|(_, word)| ["if", "for"].contains(word))?;
        let at = start + at;
        let mut depth = 0_i32;
        let (block, _) = code(text, at).find(|&(_, c)| {
            depth += i32::from(c == '(') - i32::from(c == ')');
            depth == 0 && c == '{'
        })?;
        let head = &text[at + keyword.len()..block];
        let is_loop = keyword == "for";
        let condition = if is_loop { head.split(';').nth(1).unwrap_or_default() } else { head };
        Some(Self { at, is_loop, condition, block })
    }
}

/// End of the block that starts at `block`.
fn block_end(text: &str, block: usize) -> usize {
    let mut depth = 0_i32;
    let end = code(text, block).find(|&(_, c)| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        depth == 0
    });
    end.map_or(text.len(), |(at, _)| at + 1)
}

/// Start of the block or the `if` behind the `else` that follows a block's end.
fn after_else(text: &str, end: usize) -> Option<usize> {
    let (at, c) = code(text, end).find(|(_, c)| !c.is_whitespace())?;
    if c != 'e' || words(&text[at..]).next()?.1 != "else" {
        return None;
    }
    code(text, at + "else".len()).find(|(_, c)| !c.is_whitespace()).map(|(start, _)| start)
}

/// End of a block or an `if` that starts at `start`, with all of its branches.
fn branches_end(text: &str, start: usize) -> usize {
    let is_block = text[start..].starts_with('{');
    let next = if is_block { None } else { Branch::next(text, start) };
    let block = next.map_or(start, |branch| branch.block);
    let end = block_end(text, block);
    after_else(text, end).map_or(end, |other| branches_end(text, other))
}

/// The line ends of a text.
fn blank(text: &str) -> String {
    text.chars().filter(|c| *c == '\n').collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::link::Library;

    const SOURCE: &str = "override A: bool = false;\noverride B: bool = true;\nvar<private> held: u32;\n\
        // if A { in a comment }\nfn root() {\n    if A { // if B {\n        dead();\n    }\n    \
        if open() {\n        one();\n    } else if A {\n        dead();\n    }\n    \
        if B && open() { two(); } else { one(); }\n    \
        if B {\n        three();\n    } else if open() {\n        dead();\n    } else {\n        dead();\n    }\n    \
        if A { dead(); } else if open() { if A { dead(); } four(); } // held\n    \
        if (A || !B) { dead(); } else { five(); }\n    \
        for (var i = 0u; A && i < 2u; i += 1u) { dead(); }\n    for (; B;) { six(); }\n}\n\
        fn open() -> bool { return held > 0u; }\nfn dead() { deader(); }\nfn deader() { held = 1u; }\n\
        fn one() {}\nfn two() {}\nfn three() {}\nfn four() {}\nfn five() {}\nfn six() {}\n";

    fn pruned(values: &[Constant]) -> Linked {
        let library = Library::new(&[("k.wgsl", SOURCE)]).unwrap();
        library.link("k.wgsl", "root", &[]).unwrap().pruned("root", values)
    }

    #[test]
    fn what_is_never_reached_is_left_out() {
        let linked = pruned(&[]);
        let names: Vec<_> = linked.items.iter().map(|item| item.name).collect();
        assert_eq!(
            names,
            ["B", "held", "root", "open", "one", "two", "three", "four", "five", "six"]
        );
        assert!(linked.wgsl.contains("for (; B;) { six(); }"), "{}", linked.wgsl);
        assert!(!linked.wgsl.contains("dead();"), "{}", linked.wgsl);
        // The other way round all is reached but what stands behind `else`.
        let other = pruned(&[("A", 1.0), ("B", 0.0)]);
        for name in ["dead", "deader"] {
            assert!(other.items.iter().any(|item| item.name == name), "{name}: {}", other.wgsl);
        }
        for name in ["two", "three", "four", "five", "six"] {
            assert!(!other.wgsl.contains(name), "{name}: {}", other.wgsl);
        }
    }

    #[test]
    fn lines_of_what_is_kept_lead_back_to_their_files() {
        for values in [&[][..], &[("A", 1.0)], &[("B", 0.0)]] {
            let linked = pruned(values);
            for (line, text) in (1..).zip(linked.wgsl.lines()) {
                let Some(call) = text.split("();").next().filter(|_| text.contains("();")) else {
                    continue;
                };
                let call = call.rsplit(' ').next().unwrap();
                let (_, at) = linked.locate(line).unwrap();
                let source = SOURCE.lines().nth(at - 1).unwrap();
                assert!(source.contains(call), "{call}: {source}");
            }
        }
    }
}
