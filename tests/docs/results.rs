//! The README's figures equal those of benches/results: llvmpipe.json and llvmpipe-core.json, which `make
//! results` writes, and h100.json; and the tables that `make quality` writes meet the demands on curves.
use crate::kernels::{Discs, Row};
use gobo::gpu::Tier;
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

/// A row of the README's table; its last columns are a GPU's, the one before them CPU times of core beside
/// native.
fn line(row: &Value, on_core: &Value, on_gpu: &Value) -> String {
    let of =
        |row: &Value, name: &str| row[name].as_f64().unwrap_or_else(|| panic!("{name} in {row}"));
    let number = |name: &str| of(row, name);
    // A number that was f32 has more digits as f64.
    let short = |name: &str| format!("{}", number(name) as f32);
    format!(
        "| {} | {} | {} | {} | {} | {:.1} | {:.1} | {:.2} | {:.2} |",
        thousands(number("casters") as u64),
        short("footprint"),
        short("opacity"),
        figure(number("compute_ms")),
        figure(number("raster_ms")),
        number("ratio"),
        of(on_core, "core_cpu_s") / of(on_core, "native_cpu_s"),
        of(on_gpu, "compute_ms"),
        of(on_gpu, "cuda_ms"),
    )
}

#[test]
fn the_readme_shows_what_was_measured() {
    let read = |path: &str| {
        let path = format!("{}/{path}", crate::common::ROOT);
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
    let gpu: Value = serde_json::from_str(&read("benches/results/h100.json")).unwrap();
    let of_gpu = gpu["rows"].as_array().unwrap();
    assert_eq!(of_gpu.iter().map(case).collect::<Vec<_>>(), wanted);
    let core: Value = serde_json::from_str(&read("benches/results/llvmpipe-core.json")).unwrap();
    let of_core = core["rows"].as_array().unwrap();
    assert_eq!(of_core.iter().map(case).collect::<Vec<_>>(), wanted);
    let readme = read("README.md");
    for ((row, on_core), on_gpu) in rows.iter().zip(of_core).zip(of_gpu) {
        let line = line(row, on_core, on_gpu);
        assert!(readme.contains(&format!("\n{line}\n")), "not in README.md: {line}");
    }
}

/// Cells of a row of a table; the table is between the page's markers.
fn row(page: &str, table: &str, method: &str) -> Vec<String> {
    let path = format!("{}/docs/{page}.md", crate::common::ROOT);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let (open, close) = (format!("<!-- table {table} -->"), format!("<!-- end {table} -->"));
    let rows = text.split_once(&open).and_then(|(_, rest)| rest.split_once(&close));
    let (rows, _) = rows.unwrap_or_else(|| panic!("{path}: no table {table}"));
    let row = rows.lines().find(|line| line.starts_with(&format!("| {method} |")));
    let row = row.unwrap_or_else(|| panic!("{path}: {table} has no {method}"));
    row.split('|').map(|column| column.trim().to_owned()).collect()
}

/// Mean errors of curves of 8 nodes are below a limit, and at most half of those of the best technique of
/// each kind that takes as many bytes or more.
#[test]
fn tables_hold_what_is_asked_of_curves() {
    for (page, table, rival, most) in [
        ("grids", "generated", "AVSM, 8 points", 0.004),
        ("grids", "smoke", "AVSM, 8 points", 0.004),
        ("strands", "fur", "deep opacity map, 8 layers", 0.013),
    ] {
        let [ours, theirs] = ["gobo, K = 8", rival].map(|method| row(page, table, method));
        let number = |row: &[String], i: usize| row[i].parse::<f64>().unwrap();
        // Theirs have one channel.
        assert!(number(&ours, 2) <= 3.0 * number(&theirs, 2) || table == "fur", "{table}: bytes");
        for mean in (3..ours.len() - 1).step_by(2) {
            let (ours, theirs) = (number(&ours, mean), number(&theirs, mean));
            assert!(ours <= most && ours <= 0.5 * theirs, "{page}: {table}: {ours} and {theirs}");
        }
    }
}

/// Mean errors of the kernels' own maps are those of the page, which are below what 8 nodes may have.
#[test]
fn the_page_has_the_errors_of_kernels() {
    let path = format!("{}/docs/curves.md", crate::common::ROOT);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let gpu = crate::common::gpu(Tier::Native);
    for (casters, most) in [(100_000, 0.0012), (1_000_000, 0.005)] {
        let start = Row::start(casters, 8);
        let line = text.lines().find(|line| line.starts_with(&start));
        let line = line.unwrap_or_else(|| panic!("no line {start}: run make quality"));
        let stated: f64 = line.split('|').nth(4).and_then(|it| it.trim().parse().ok()).unwrap();
        assert!(stated <= most, "{line}: at most {most}");
        let found = Row::of(&Discs::new(casters).errors(&gpu, 8).unwrap());
        assert!((found.mean - stated).abs() <= 0.05 * stated, "{line}: {found:?}");
        assert!(found.high < 20.0 * found.mean, "{found:?}");
    }
}
