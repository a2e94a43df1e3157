//! `--json` states the phases of the wall clock, compared with a clock outside of the process.
use super::commands::Folder;
use serde_json::Value;
use std::time::Instant;

/// Share that the lines may lack.
const TOLERANCE: f64 = 0.05;
/// Time until the process runs its first line, and from the last frame's line to its end, with other tests on
/// the same cores [ms].
const START_AND_EXIT: f64 = 500.0;

/// Sum of the numbers of an object [ms].
fn sum(value: &Value) -> f64 {
    let all = value.as_object().unwrap_or_else(|| panic!("{value} is no object"));
    all.values().map(|ms| ms.as_f64().unwrap()).sum()
}

/// Asserts that the lines of a scene of `data/` add up to the elapsed time. Returns them.
fn assert_adds_up(name: &str, scene: &str, more: &[&str]) -> Vec<Value> {
    let folder = Folder::new(name);
    let scene = format!("{}/data/{scene}", crate::common::ROOT);
    let tiny = ["--set", "camera.size=[64,36]", "--set", "shadow.size=128", "--json"];
    let started = Instant::now();
    let stdout = folder.run(&[&["render", &scene], &tiny[..], more].concat());
    let wall = started.elapsed().as_secs_f64() * 1e3;
    let lines: Vec<Value> = stdout.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let left_out = wall - lines.iter().map(|line| sum(&line["milliseconds"])).sum::<f64>();
    let most = wall * TOLERANCE + START_AND_EXIT;
    assert!((0.0..most).contains(&left_out), "{left_out} of {wall} ms are in no line: {stdout}");
    for line in &lines {
        let phases = &line["milliseconds"];
        let (all, kernels) = (sum(phases), phases["kernels"].as_f64().unwrap());
        let other = phases["other"].as_f64().unwrap();
        assert!(other < all * TOLERANCE + START_AND_EXIT, "{line}");
        // Stages are submitted one by one, and waited for.
        let (stages, of_picture) = (sum(&line["stages"]), line["stages"]["picture"].as_f64());
        let between = kernels - stages;
        assert!((0.0..kernels * TOLERANCE + START_AND_EXIT).contains(&between), "{line}");
        let apart = (sum(&line["picture_stages"]) - of_picture.unwrap()).abs();
        assert!(apart < 1e-6 * kernels, "{line}");
    }
    lines
}

fn assert_spent(line: &Value, phases: &[&str]) {
    for phase in phases {
        assert!(line["milliseconds"][phase].as_f64() > Some(0.0), "{phase} in {line}");
    }
}

#[test]
fn all_samples_of_a_picture_add_up_to_the_wall_clock() {
    // Enough samples that other tests' use of the cores does not hide their time.
    let lines = assert_adds_up("clock-still", "panes.toml", &["--set", "camera.samples=32"]);
    let phases = ["device", "read", "prepare", "compile", "kernels", "read_back", "write"];
    assert_spent(&lines[0], &phases);
    // Each sample shades the whole picture.
    let one = assert_adds_up("clock-one", "panes.toml", &["--set", "camera.samples=1"]);
    let shading = |lines: &[Value]| lines[0]["picture_stages"]["shade"].as_f64().unwrap();
    assert!(shading(&lines) > 1.5 * shading(&one), "{lines:?} beside {one:?}");
}

#[test]
fn frames_of_a_sequence_add_up_to_the_wall_clock() {
    let more = ["--frames=0..3", "--set", "camera.samples=2", "--set", "camera.shutter=0.5"];
    let lines = assert_adds_up("clock-moving", "moving.toml", &more);
    assert_eq!(lines.len(), 3);
    assert_spent(&lines[0], &["device", "read", "compile"]);
    for line in &lines {
        assert_spent(line, &["generate", "prepare", "kernels", "read_back", "write"]);
        assert!(line["stages"]["bin"].as_f64() > Some(0.0), "{line}");
    }
    assert!(lines[2]["milliseconds"]["device"].is_null(), "{}", lines[2]);
}
