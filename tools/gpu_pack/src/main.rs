//! What `run.sh` of a pack needs beside a shell: compares folders of maps and pictures, and gathers the results of all
//! parts into one JSON file and one page.
//!
//! `gpu-pack compare EXPECTED FOUND OUT.json`: fails where more than a few values differ.
//! `gpu-pack gather RESULTS`: writes `RESULTS/<device>.json` and `RESULTS/page.html`.
mod compare;
mod gather;

use std::{path::Path, process::ExitCode};

pub type Failure = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match arguments[..] {
        ["compare", expected, found, out] => {
            compare::run(Path::new(expected), Path::new(found), Path::new(out))
        }
        ["gather", results] => gather::run(Path::new(results)),
        _ => Err("gpu-pack compare EXPECTED FOUND OUT.json | gpu-pack gather RESULTS".into()),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("gpu-pack: {error}");
            ExitCode::FAILURE
        }
    }
}
