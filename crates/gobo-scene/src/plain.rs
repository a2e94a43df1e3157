//! Errors of the TOML reader, rephrased for authors of scenes.
use super::error::quoted;

/// The problem and the remedy.
pub(super) fn explained(message: &str) -> (String, String) {
    let message = message.trim_end();
    let names: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let name = names.first().copied().unwrap_or_default();
    let others = names.iter().skip(1).copied();
    if message.starts_with("unknown field") {
        let help = nearest(name, others).unwrap_or_else(|| "remove it".to_owned());
        return (format!("there is no key {} here", quoted(name)), help);
    }
    if message.starts_with("unknown variant") {
        let help = nearest(name, others).unwrap_or_else(|| "remove it".to_owned());
        return (format!("{} is no word that is known here", quoted(name)), help);
    }
    if message.starts_with("missing field") {
        return (format!("the key `{name}` is missing"), format!("add `{name} = ...`"));
    }
    let mismatch = message
        .strip_prefix("invalid type: ")
        .or_else(|| message.strip_prefix("invalid value: "))
        .and_then(|rest| rest.rsplit_once(", expected "));
    if let Some((found, wanted)) = mismatch {
        let (wanted, help) = kind_wanted(wanted);
        return (format!("{} stands here, not {wanted}", kind_found(found)), help.to_owned());
    }
    if message.starts_with("wanted string or table") {
        let (wanted, help) = kind_wanted("a string");
        return (format!("this is not {wanted}"), help.to_owned());
    }
    if message.starts_with("expected an array of") {
        return (message.to_owned(), "count the numbers between [ and ]".to_owned());
    }
    let help = "check the line: a text needs its quotes, a list its ], a table its }, and a key is \
                there once";
    (message.to_owned(), help.to_owned())
}

/// The expected kind of value, and how to write it.
fn kind_wanted(wanted: &str) -> (&str, &'static str) {
    match wanted {
        "f32" | "f64" => ("a number", "write a number such as 0.5"),
        "u8" | "u16" | "u32" | "u64" | "usize" | "i32" | "i64" => {
            ("a whole number from 0 up", "write a whole number such as 4")
        }
        "a boolean" => ("true or false", "write true or false"),
        "a string" | "path string" | "string or map" => {
            ("a text in quotes", "write a text in quotes, such as \"smoke\"")
        }
        "a sequence" => ("a list", "write a list such as [1, 2, 3]"),
        "a map" => ("a table", "write a table such as { kind = \"smoke\", count = 100 }"),
        _ if wanted.starts_with("the path") => (wanted, "write a path in quotes, or such a table"),
        _ => ("a table", "write a table such as { kind = \"smoke\", count = 100 }"),
    }
}

fn kind_found(found: &str) -> String {
    let inner = |quote: char| {
        let start = found.find(quote)? + 1;
        let end = found.rfind(quote).filter(|&end| end >= start)?;
        Some(quoted(&found[start..end]))
    };
    let value = match found.split_whitespace().next().unwrap_or_default() {
        "string" => inner('"').map(|text| format!("the text {text}")),
        "integer" | "floating" => inner('`').map(|number| format!("the number {number}")),
        "boolean" => inner('`'),
        "sequence" => Some("a list".to_owned()),
        _ => None,
    };
    value.unwrap_or_else(|| "something else".to_owned())
}

/// The known name closest to `name`, or else the known names.
pub(super) fn nearest<'n>(name: &str, known: impl IntoIterator<Item = &'n str>) -> Option<String> {
    /// Most names in a remedy.
    const NAMED: usize = 24;
    /// Longest name that is compared: the time is the product of two lengths \[bytes\].
    const LONGEST: usize = 100;
    let known: Vec<&str> = known.into_iter().collect();
    let close = |other: &str| {
        let lengths = name.len().max(other.len());
        if lengths > LONGEST { 0.0 } else { strsim::jaro_winkler(name, other) }
    };
    let best = known.iter().max_by(|a, b| close(a).total_cmp(&close(b)))?;
    if close(best) > 0.7 {
        return Some(format!("did you mean {}?", quoted(best)));
    }
    let names: Vec<String> = known.iter().take(NAMED).map(|name| quoted(name)).collect();
    let more = known.len().saturating_sub(NAMED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    Some(format!("known here: {}{more}", names.join(", ").replace('`', "")))
}

/// Name of a TOML value's kind.
pub(super) fn kind_of(value: &toml::de::DeValue<'_>) -> &'static str {
    use toml::de::DeValue::{Array, Boolean, Datetime, Float, Integer, String, Table};
    match value {
        String(_) => "a text",
        Integer(_) | Float(_) => "a number",
        Boolean(_) => "true or false",
        Datetime(_) => "a date",
        Array(_) => "a list",
        Table(_) => "a table",
    }
}
