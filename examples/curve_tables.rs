//! Writes the tables of `docs/curves.md`: `make quality`.
#[path = "measure/curves.rs"]
mod curves;
#[path = "measure/rivals.rs"]
mod rivals;

use curves::{Method, Rays, Sample};
use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
    time::Instant,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let usual = || Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/curves.md");
    let path = std::env::args_os().nth(1).map_or_else(usual, PathBuf::from);
    let page = replaced(&std::fs::read_to_string(&path)?, "quality", &quality()?)?;
    std::fs::write(&path, page)?;
    println!("{}", path.display());
    Ok(())
}

/// Replaces the table between its markers.
fn replaced(page: &str, name: &str, table: &str) -> Result<String, String> {
    let (open, close) = (format!("<!-- table {name} -->\n"), format!("<!-- end {name} -->"));
    let missing = |marker: &str| format!("the page has no line {}", marker.trim_end());
    let start = page.find(&open).ok_or_else(|| missing(&open))? + open.len();
    let end = page.find(&close).ok_or_else(|| missing(&close))?;
    Ok(format!("{}{table}{}", &page[..start], &page[end..]))
}

/// Runs per figure; the fastest counts.
const RUNS: u32 = 10;

fn quality() -> Result<String, std::fmt::Error> {
    let mut table = "| method | bytes | smoke, mean | max | ns | panes, mean | max | ns \
                     | puffs, mean | max | ns |\n|---|---|---|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    let samples = Rays::ALL.map(Sample::new);
    for method in Method::ALL {
        write!(table, "| {} | {} |", method.name(), method.bytes())?;
        for sample in &samples {
            let error = sample.error(method);
            let run = || {
                let clock = Instant::now();
                sample.build(method);
                clock.elapsed().as_secs_f64() * 1e9 / sample.hit_count() as f64
            };
            let ns = (0..RUNS).map(|_| run()).fold(f64::INFINITY, f64::min);
            write!(table, " {:.5} | {:.2} | {ns:.0} |", error.mean, error.max)?;
        }
        table.push('\n');
    }
    Ok(table)
}
