//! docs/export.md names every key of a recording.

/// Keys that the program writes but the document does not name.
fn missing<'a>(source: &'a str, document: &str) -> Vec<&'a str> {
    let pieces: Vec<_> = source.split('"').collect();
    let strings = pieces.windows(2).skip(1).step_by(2);
    strings
        .filter(|pair| pair[1].starts_with(": ") || pair[1].starts_with("] ="))
        .map(|pair| pair[0])
        .filter(|key| !document.contains(&format!("`{key}`")))
        .collect()
}

#[test]
fn keys_of_recordings_are_named() {
    let (source, document) =
        (include_str!("../../crates/gobo-cli/src/frame.rs"), include_str!("../../docs/export.md"));
    assert_eq!(missing(source, document), [""; 0]);
    // The check finds one.
    let without = document.replace("`from_offset`", "");
    assert_eq!(missing(source, &without), ["from_offset"; 2]);
    assert_eq!(missing(source, &document.replace("`initial`", "")), ["initial"]);
}
