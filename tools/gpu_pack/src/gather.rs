//! Results of all parts: one JSON file, one page.
use crate::Failure;
use serde_json::{Map, Value, json};
use std::{fmt::Write as _, fs, path::Path};

/// A line of `parts.txt`: a part of `run.sh`, its exit status, seconds, and seconds that it may take.
struct Part {
    name: String,
    status: i32,
    seconds: u64,
    limit: u64,
}

impl Part {
    fn parse(line: &str) -> Option<Self> {
        let mut words = line.split_whitespace();
        let mut next = || words.next();
        Some(Self {
            name: next()?.to_owned(),
            status: next()?.parse().ok()?,
            seconds: next()?.parse().ok()?,
            limit: next()?.parse().ok()?,
        })
    }

    /// Of `timeout`, and of what it had to kill.
    fn is_cut(&self) -> bool {
        matches!(self.status, 124 | 137)
    }

    fn outcome(&self) -> String {
        match self.status {
            0 => "done".to_owned(),
            _ if self.is_cut() => format!("cut after {} s", self.limit),
            status => format!("failed ({status})"),
        }
    }
}

/// Writes the files; false where a part failed. One that was cut is named.
pub fn run(results: &Path) -> Result<bool, Failure> {
    let text = |name: &str| fs::read_to_string(results.join(name)).unwrap_or_default();
    let parts: Vec<Part> = text("parts.txt").lines().filter_map(Part::parse).collect();
    if parts.is_empty() {
        return Err(format!("{}/parts.txt: no parts", results.display()).into());
    }
    let mut files = Map::new();
    for part in &parts {
        let json = serde_json::from_str::<Value>(&text(&format!("{}.json", part.name))).ok();
        let beside = json!({
            "status": part.status,
            "seconds": part.seconds,
            "limit": part.limit,
            "results": json,
            "log": text(&format!("{}.log", part.name)),
        });
        files.insert(part.name.clone(), beside);
    }
    let device = device(&files).unwrap_or_else(|| "unknown".to_owned());
    let all = json!({ "device": device, "parts": files });
    let safe = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    let name: String = device.chars().map(safe).collect();
    let path = results.join(format!("{name}.json"));
    fs::write(&path, serde_json::to_string_pretty(&all)? + "\n")?;
    fs::write(results.join("page.html"), page(&device, &parts, &files))?;
    for part in &parts {
        println!("{:>9} {:>4} s  {}", part.name, part.seconds, part.outcome());
    }
    println!("{}\n{}", path.display(), results.join("page.html").display());
    Ok(parts.iter().all(|part| part.status == 0 || part.is_cut()))
}

/// The adapter of the first results that name one.
fn device(parts: &Map<String, Value>) -> Option<String> {
    parts.values().find_map(|part| part["results"]["adapter"].as_str()).map(str::to_owned)
}

fn page(device: &str, parts: &[Part], files: &Map<String, Value>) -> String {
    let device = escaped(device);
    let mut page = format!(
        "<!doctype html><meta charset=utf-8><title>gobo on {device}</title>\
         <style>body{{font:14px sans-serif;margin:2em}}td,th{{padding:2px 8px;text-align:right}}\
         td:first-child{{text-align:left}}pre{{background:#eee;padding:8px;overflow:auto}}</style>\
         <h1>{device}</h1><table><tr><th>part<th>s<th>\n"
    );
    for part in parts {
        let _ = writeln!(page, "<tr><td>{}<td>{}<td>{}", part.name, part.seconds, part.outcome());
    }
    page += "</table>\n";
    for part in parts {
        let of_part = &files[&part.name];
        let _ = writeln!(page, "<h2>{}</h2>", part.name);
        if let Some(rows) = of_part["results"]["rows"].as_array() {
            page += "<table><tr><th>case<th>ms<th>least<th>most\n";
            for row in rows {
                let name = row["scene"].as_str().map_or_else(
                    || format!("{} x {} @ {}", row["casters"], row["footprint"], row["opacity"]),
                    escaped,
                );
                let [ms, least, most] = ["compute_ms", "compute_min", "compute_max"]
                    .map(|key| row[key].as_f64().unwrap_or(f64::NAN));
                let _ = writeln!(page, "<tr><td>{name}<td>{ms:.3}<td>{least:.3}<td>{most:.3}");
            }
            page += "</table>\n";
        }
        let log = escaped(of_part["log"].as_str().unwrap_or_default());
        let _ = writeln!(page, "<details><summary>log</summary><pre>{log}</pre></details>");
    }
    page
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_cut_is_named() {
        let part = |line| Part::parse(line).unwrap();
        assert_eq!(part("suite 124 90 90").outcome(), "cut after 90 s");
        assert_eq!(part("suite 137 92 90").outcome(), "cut after 90 s");
        assert_eq!(part("maps 1 3 30").outcome(), "failed (1)");
        assert_eq!(part("maps 0 3 30").outcome(), "done");
        assert!(Part::parse("maps x 3 30").is_none());
    }
}
