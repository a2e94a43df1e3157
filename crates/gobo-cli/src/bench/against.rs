//! `gobo bench --against`: the results beside those of an earlier `--json`, case by case.
use super::report::Report;
use crate::{failure::Failure, files};
use serde::Serialize;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Keys that identify a case; a row may lack some.
const CASE: [&str; 8] =
    ["shape", "casters", "footprint", "opacity", "layout", "lights", "size", "scene"];
/// Keys of a file whose values must agree.
const COMMON: [&str; 2] = ["casters", "nodes"];
/// Keys of a file with a warning if they differ: times of two machines cannot be compared.
const MACHINE: [&str; 3] = ["adapter", "driver", "clock"];
const HELP: &str = "name a file that gobo bench --json has written";

/// Results of an earlier version.
pub(super) struct Earlier {
    path: PathBuf,
    file: Value,
}

impl Earlier {
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let bytes = std::fs::read(path).map_err(|error| Failure::file(path, error))?;
        let refused = |message: String| Failure::refused(path, message, HELP);
        let file: Value = serde_json::from_slice(&bytes)
            .map_err(|error| refused(format!("is no JSON: {error}")))?;
        let is_timed = |row: &Value| time(row).is_some();
        if !rows(&file).iter().any(is_timed) {
            return Err(refused("holds no results of gobo bench".to_owned()));
        }
        Ok(Self { path: path.to_owned(), file })
    }

    /// Prints the ratio of times for each case, and for its kernels or else stages if both have them. Fails
    /// if no case is in both, or one takes more than `limit` times as long as before.
    pub(super) fn compare<R: Serialize>(
        &self,
        report: &Report<R>,
        limit: f64,
    ) -> Result<(), Failure> {
        // Through text, like the file: a 32-bit .02 is another number in 64 bits.
        let now: Value = serde_json::from_str(&report.json()).expect("it is JSON");
        for key in COMMON {
            if now[key] != self.file[key] {
                let message = format!("has {key} {}, these are {}", self.file[key], now[key]);
                return Err(Failure::refused(&self.path, message, "compare the same kind of maps"));
            }
        }
        for key in MACHINE {
            if now[key] != self.file[key] {
                tracing::warn!("the {key} was {}, it is {}", self.file[key], now[key]);
            }
        }
        let (mut slower, mut found) = (Vec::new(), 0);
        for row in rows(&now) {
            let before = rows(&self.file).iter().find(|before| same_case(row, before));
            let Some((before, ms_before)) = before.and_then(|row| Some((row, time(row)?))) else {
                files::print(&format!("{}: not in {}", name(row), self.path.display()))?;
                continue;
            };
            found += 1;
            let ms = time(row).expect("it was measured");
            let ratio = ms / ms_before;
            let mut line = format!("{}: {ratio:.3} of {ms_before:.3} ms", name(row));
            let parts = parts(row, before);
            if !parts.is_empty() {
                line += &format!("\n{:>9}{}", "", parts.join(", "));
            }
            files::print(&line)?;
            if ratio > limit {
                slower.push(format!("{} ({ratio:.3})", name(row)));
            }
        }
        if found == 0 {
            let help = "measure cases that it holds";
            return Err(Failure::refused(&self.path, "holds none of the measured cases", help));
        }
        if slower.is_empty() {
            return Ok(());
        }
        Err(Failure::Wrong(format!(
            "slower than {limit} times {}: {}",
            self.path.display(),
            slower.join(", ")
        )))
    }
}

fn rows(file: &Value) -> &[Value] {
    file["rows"].as_array().map_or(&[], Vec::as_slice)
}

/// Median time of the maps \[ms\].
fn time(row: &Value) -> Option<f64> {
    row["compute_ms"].as_f64().filter(|&ms| ms > 0.0)
}

fn same_case(row: &Value, before: &Value) -> bool {
    CASE.iter().all(|&key| row[key] == before[key])
}

fn name(row: &Value) -> String {
    let known = CASE.iter().filter(|&&key| !row[key].is_null());
    known.map(|&key| format!("{key} {}", row[key])).collect::<Vec<_>>().join(", ")
}

/// Ratios of kernels that both rows have, or else of stages.
fn parts(row: &Value, before: &Value) -> Vec<String> {
    let ratio = |name: String, ms: &Value, ms_before: &Value| {
        let (ms, ms_before) = (ms.as_f64()?, ms_before.as_f64().filter(|&ms| ms > 0.0)?);
        Some(format!("{name} {:.3} of {ms_before:.3}", ms / ms_before))
    };
    if let (Some(kernels), Some(earlier)) =
        (row["kernels"].as_array(), before["kernels"].as_array())
    {
        let is_same = |a: &Value, b: &Value| a["stage"] == b["stage"] && a["kernel"] == b["kernel"];
        let of_kernel = |kernel: &Value| {
            let known = earlier.iter().find(|known| is_same(kernel, known))?;
            let name = format!("{}/{}", kernel["stage"].as_str()?, kernel["kernel"].as_str()?);
            ratio(name, &kernel["ms"], &known["ms"])
        };
        return kernels.iter().filter_map(of_kernel).collect();
    }
    let stages = row["stages"].as_object().into_iter().flatten();
    stages.filter_map(|(name, ms)| ratio(name.clone(), ms, &before["stages"][name])).collect()
}
