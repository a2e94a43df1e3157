//! `gobo bench` on a tiny case.
use super::commands::Folder;
use serde_json::Value;
use std::{
    path::PathBuf,
    process::{Command, Output},
};

fn bench(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gobo")).arg("bench").args(arguments).output().unwrap()
}

fn temporary(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("gobo-bench-{}-{name}", std::process::id()))
}

#[test]
fn both_paths_are_measured_and_agree() {
    let (json, html) = (temporary("results.json"), temporary("results.html"));
    let output = bench(&[
        "--casters",
        "2k",
        "--footprint",
        "0.5,16",
        "--layout",
        "spread,tile",
        "--lights",
        "2",
        "--size",
        "128",
        "--runs",
        "2",
        "--vs",
        "raster",
        "--json",
        json.to_str().unwrap(),
        "--html",
        html.to_str().unwrap(),
    ]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let value: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    let page = std::fs::read_to_string(&html).unwrap();
    for path in [json, html] {
        std::fs::remove_file(path).unwrap();
    }
    for name in ["adapter", "driver", "tier"] {
        assert!(!value[name].as_str().unwrap().is_empty(), "{name}");
    }
    let rows = value["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    for row in rows {
        let number = |name: &str| row[name].as_f64().unwrap_or_else(|| panic!("{name} in {row}"));
        assert_eq!((number("casters"), number("lights"), number("size")), (2000.0, 2.0, 128.0));
        assert!(number("compute_min") > 0.0);
        assert!(number("compute_min") <= number("compute_ms"));
        assert!(number("compute_ms") <= number("compute_max"));
        let ratio = number("raster_ms") / number("compute_ms");
        assert!((number("ratio") / ratio - 1.0).abs() < 1e-9);
        for stage in ["project", "sort", "bin", "accumulate", "resolve"] {
            assert!(row["stages"][stage].as_f64().unwrap() >= 0.0, "{stage}");
        }
        let stages = row["stages"].as_object().unwrap().values();
        assert!(stages.map(|ms| ms.as_f64().unwrap()).sum::<f64>() > 0.0);
        assert!(row["bytes"]["filters"].as_u64().unwrap() >= 2 * 128 * 128 * 8);
        let scattered = number("scattered");
        assert!(scattered == 0.0 || number("footprint") < 1.0, "{scattered} scattered");
    }
    assert_eq!(page.matches("<svg").count(), 3);
    assert!(!page.contains("http") && !page.contains("<script"));
    let table = String::from_utf8(output.stdout).unwrap();
    assert_eq!(table.matches("spread").count(), 2, "{table}");
}

#[test]
fn opaque_triangles_agree_with_a_depth_pass() {
    let json = temporary("occlude.json");
    let size = ["--casters", "2k", "--size", "128", "--runs", "2"];
    let output = bench(&[&["--occlude", "--json", json.to_str().unwrap()][..], &size].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let value: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    std::fs::remove_file(json).unwrap();
    let rows = value["rows"].as_array().unwrap();
    let footprints: Vec<_> = rows.iter().map(|row| row["footprint"].as_f64().unwrap()).collect();
    assert_eq!(footprints, [1.5, 4.0, 12.0]);
    assert!(rows.iter().all(|row| row["ratio"].as_f64().unwrap() > 0.0));
}

#[test]
fn single_cases_are_not_combined() {
    let json = temporary("cases.json");
    let size = ["--size", "64", "--runs", "1", "--json", json.to_str().unwrap()];
    let output = bench(&[&["--case", "1kx6,2kx3@0.5"][..], &size].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let value: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    std::fs::remove_file(json).unwrap();
    let number = |row: &Value, name: &str| row[name].as_f64().unwrap() as f32;
    let of = |row| ["casters", "footprint", "opacity"].map(|name| number(row, name));
    let rows: Vec<_> = value["rows"].as_array().unwrap().iter().map(of).collect();
    assert_eq!(rows, [[1000.0, 6.0, 0.02], [2000.0, 3.0, 0.5]]);
}

/// The scene's own maps are measured, with replaced values.
#[test]
fn a_scene_is_measured() {
    let folder = Folder::new("bench-scene");
    std::fs::write(
        folder.0.join("own.toml"),
        "[shadow]\nreceiver = 'curve'\n[[light]]\nname = 'sun'\nkind = 'directional'\n\
         direction = [0, -1, 0]\n\
         [[light]]\nname = 'lamp'\nkind = 'point'\nposition = [0, 1, 0]\nsize = 16\n\
         [[volume]]\ngenerate = { kind = 'plume', voxels = 16 }\n",
    )
    .unwrap();
    let path = folder.0.join("own.toml");
    let (path, json) = (path.to_str().unwrap(), folder.0.join("results.json"));
    let to = ["--json", json.to_str().unwrap(), "--runs", "2"];
    let output = bench(&[&["--scene", path, "--set", "light.sun.size=32"][..], &to].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let value: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    let row = &value["rows"][0];
    let number = |name: &str| row[name].as_u64().unwrap_or_else(|| panic!("{name} in {row}"));
    assert_eq!((number("views"), number("texels")), (7, 32 * 32 + 6 * 16 * 16));
    assert!(number("visible") > 8 && number("runs") == 2);
    assert!(row["compute_ms"].as_f64().unwrap() > 0.0);
    assert!(row["stages"]["accumulate"].as_f64().unwrap() > 0.0);
    assert!(row["bytes"]["curves"].as_u64().is_some() && row["bytes"]["voxels"].as_u64().is_some());
    assert!(String::from_utf8(output.stdout).unwrap().contains("7 views"));
    for bad in [
        &["--scene", path, "--casters", "2k"][..],
        &["--scene", path, "--receiver", "nearest"],
        &["--set", "light.sun.size=32"],
        &["--scene", path, "--set", "light.sun.size=0"],
        &["--scene", path, "--set", "light.sun.casts=false", "--set", "light.lamp.casts=false"],
        &["--scene", "missing.toml"],
    ] {
        let output = bench(bad);
        assert_eq!(output.status.code(), Some(2), "{bad:?}");
        assert!(!output.stderr.is_empty(), "{bad:?}");
    }
}

#[test]
fn bad_usage_is_refused() {
    for bad in [
        &["--case", "1k"][..],
        &["--case", "1kx6", "--casters", "2k"],
        &["--case", "1kx6", "--occlude"],
        &["--casters", "0"],
        &["--casters", "many"],
        &["--footprint", "nan"],
        &["--opacity", "2"],
        &["--size", "8"],
        &["--vs", "magic"],
        &["--backend", "cpu"],
        &["--runs", "0"],
        &["--occlude", "--lights", "2"],
        &["--case", "1kx6@0.001", "--vs", "raster"],
        &["--casters", "17m", "--vs", "raster"],
        &["--casters", "17m", "--receiver", "curve"],
    ] {
        assert_eq!(bench(bad).status.code(), Some(2), "{bad:?}");
    }
}

#[test]
fn a_closed_folder_keeps_its_exit_status() {
    let json = temporary("missing").join("results.json");
    let output = bench(&["--casters", "10", "--size", "16", "--json", json.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("results.json"));
}

#[test]
fn kernels_have_times_and_results_are_compared() {
    let (json, changed) = (temporary("kernels.json"), temporary("changed.json"));
    let case = ["--case", "2kx6,500x6", "--size", "128", "--runs", "2"];
    let output = bench(&[&case[..], &["--kernels", "--json", json.to_str().unwrap()]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut value: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    for row in value["rows"].as_array().unwrap() {
        let kernels = row["kernels"].as_array().unwrap();
        for stage in ["project", "sort", "bin", "accumulate"] {
            let of_stage = |kernel: &&Value| kernel["stage"] == stage;
            let first = kernels.iter().find(of_stage).unwrap_or_else(|| panic!("{stage}: {row}"));
            assert!(first["ms"].as_f64().unwrap() > 0.0, "{first}");
            assert!(first["dispatches"].as_u64().unwrap() > 0, "{first}");
        }
        let project = kernels.iter().find(|kernel| kernel["stage"] == "project").unwrap();
        assert_eq!(project["kernel"], "project_particles");
    }
    let against = |file: &PathBuf, limit: &str| {
        let arguments = ["--kernels", "--limit", limit, "--against", file.to_str().unwrap()];
        bench(&[&case[..], &arguments].concat())
    };
    let same = against(&json, "100");
    let text = String::from_utf8(same.stdout).unwrap();
    assert!(same.status.success(), "{text}");
    assert_eq!(text.matches("project/project_particles").count(), 4, "{text}");

    // One case that took a thousandth of the time, and one that was not measured.
    let rows = value["rows"].as_array_mut().unwrap();
    let ms = rows[0]["compute_ms"].as_f64().unwrap();
    rows[0]["compute_ms"] = Value::from(ms * 1e-3);
    rows[1]["casters"] = Value::from(501);
    std::fs::write(&changed, value.to_string()).unwrap();
    let slower = against(&changed, "1.05");
    let errors = String::from_utf8(slower.stderr).unwrap();
    assert_eq!(slower.status.code(), Some(1), "{errors}");
    assert!(
        errors.contains("slower than 1.05 times") && errors.contains("casters 2000"),
        "{errors}"
    );
    assert!(!errors.contains("casters 500"), "{errors}");
    let text = String::from_utf8(slower.stdout).unwrap();
    assert!(text.contains("casters 500") && text.contains("not in"), "{text}");

    // A file without results, and results of other maps.
    std::fs::write(&changed, "{\"rows\": []}").unwrap();
    let empty = against(&changed, "2");
    assert!(!empty.status.success());
    let errors = String::from_utf8(empty.stderr).unwrap();
    assert!(errors.contains("changed.json") && errors.contains("no results"), "{errors}");
    let curves =
        bench(&[&case[..], &["--receiver", "curve", "--against", json.to_str().unwrap()]].concat());
    assert!(!curves.status.success());
    let errors = String::from_utf8(curves.stderr).unwrap();
    assert!(errors.contains("nodes"), "{errors}");
    [json, changed].iter().for_each(|path| std::fs::remove_file(path).unwrap());
}

/// Each choice that a profile leaves open is measured beside the adapter's own.
#[test]
fn choices_of_the_tuning_are_measured() {
    let json = temporary("tune.json");
    let output = bench(&[
        "--tune",
        "--case",
        "300x4",
        "--size",
        "32",
        "--runs",
        "1",
        "--json",
        json.to_str().unwrap(),
    ]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let value: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    std::fs::remove_file(json).unwrap();
    let rows = value["rows"].as_array().unwrap();
    for field in ["disc_segment", "partition", "bucket_pairs", "scatter_tiny", "columns"] {
        assert!(rows.iter().any(|row| row["field"] == field), "{field}");
    }
    for row in rows {
        let number = |name: &str| row[name].as_f64().unwrap_or_else(|| panic!("{name} in {row}"));
        assert!((number("compute_ms") / number("own_ms") / number("ratio") - 1.0).abs() < 1e-9);
    }
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(table.lines().last().unwrap().starts_with("Tuning: "), "{table}");
    assert_eq!(table.lines().count(), rows.len() + 2, "{table}");
}
