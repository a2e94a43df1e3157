//! The README's figures equal those of benches/results/llvmpipe.json, which `make results` writes.
use serde_json::Value;

fn figure(ms: f64) -> String {
    if ms < 100.0 { format!("{ms:.1}") } else { format!("{ms:.0}") }
}

fn thousands(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A row of the README's table; its last column is a GPU's.
fn line(row: &Value) -> String {
    let number = |name: &str| row[name].as_f64().unwrap_or_else(|| panic!("{name} in {row}"));
    // A number that was f32 has more digits as f64.
    let short = |name: &str| format!("{}", number(name) as f32);
    format!(
        "| {} | {} | {} | {} | {} | {:.1} | |",
        thousands(number("casters") as u64),
        short("footprint"),
        short("opacity"),
        figure(number("compute_ms")),
        figure(number("raster_ms")),
        number("ratio"),
    )
}

#[test]
fn the_readme_shows_what_was_measured() {
    let read = |path: &str| {
        let path = format!("{}/{path}", env!("CARGO_MANIFEST_DIR"));
        std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
    };
    let results: Value = serde_json::from_str(&read("benches/results/llvmpipe.json")).unwrap();
    assert!(results["adapter"].as_str().unwrap().contains("llvmpipe"));
    let rows = results["rows"].as_array().unwrap();
    let case = |row: &Value| {
        ["casters", "footprint", "opacity"].map(|name| row[name].as_f64().unwrap() as f32)
    };
    let wanted = [
        [10_000.0, 6.0, 0.02],
        [100_000.0, 16.0, 0.02],
        [1e6, 16.0, 0.02],
        [1e6, 6.0, 0.02],
        [1e6, 0.5, 0.02],
        [1e6, 16.0, 1.0],
    ];
    assert_eq!(rows.iter().map(case).collect::<Vec<_>>(), wanted);
    let readme = read("README.md");
    for row in rows {
        let line = line(row);
        assert!(readme.contains(&format!("\n{line}\n")), "not in README.md: {line}");
    }
}
