//! Fuzzer: changes files at random and reads them, `make fuzz`.
//!
//! `cargo run --release --example fuzz [READER]...` with `FUZZ_SECONDS` for each reader (30) and
//! `FUZZ_SEED` (0). A reader fails if it panics or takes longer than `SLOW`. The failing input is written
//! to out/fuzz, and so is the input that was read last (`current.*`), for a run that was killed.
mod mutate;
mod seeds;
#[path = "../../tests/common/vdb.rs"]
#[allow(dead_code, reason = "tests write more kinds of files")]
mod vdb;

use gobo::scene::{self, generate::Chance};
use std::{
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    process::ExitCode,
    time::{Duration, Instant},
};

/// Time in which the largest scene within the limits is made.
const SLOW: Duration = Duration::from_secs(20);

/// Files of one kind.
struct Reader {
    name: &'static str,
    extension: &'static str,
    seeds: Vec<Vec<u8>>,
    /// A scene file that reads `current.EXTENSION`, if that is no scene file itself.
    scene: Option<String>,
}

fn main() -> std::io::Result<ExitCode> {
    let number = |name: &str, usual: u64| {
        std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
    };
    let (seconds, seed) = (number("FUZZ_SECONDS", 30), number("FUZZ_SEED", 0));
    let only: Vec<String> = std::env::args().skip(1).collect();
    let out = PathBuf::from("out/fuzz");
    fs::create_dir_all(&out)?;
    // A finding is one line, not a backtrace.
    std::panic::set_hook(Box::new(|_| ()));
    let mut findings = 0;
    for reader in seeds::readers()? {
        if only.is_empty() || only.iter().any(|name| name == reader.name) {
            findings += run(&reader, Duration::from_secs(seconds), seed, &out)?;
        }
    }
    Ok(if findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Number of inputs that failed.
fn run(reader: &Reader, time: Duration, seed: u64, out: &Path) -> std::io::Result<usize> {
    let mut chance = Chance::new(seed);
    let input = out.join(format!("current.{}", reader.extension));
    let scene = out.join("current.toml");
    if let Some(text) = &reader.scene {
        fs::write(&scene, text)?;
    }
    let path = if reader.scene.is_some() { &scene } else { &input };
    let (clock, mut count, mut read, mut findings) = (Instant::now(), 0_u64, 0_u64, 0);
    while clock.elapsed() < time {
        let bytes = mutate::mutated(&reader.seeds, &mut chance);
        fs::write(&input, &bytes)?;
        let (mut result, mut took) = load(path);
        if took > SLOW {
            // Other processes may have taken the cores.
            (result, took) = load(path);
        }
        let fault = match result {
            Err(_) => Some("panics"),
            Ok(_) if took > SLOW => Some("is slow"),
            Ok(is_scene) => {
                read += u64::from(is_scene);
                None
            }
        };
        if let Some(fault) = fault {
            let kept = out.join(format!("{}-{count}.{}", reader.name, reader.extension));
            fs::write(&kept, &bytes)?;
            println!("{}: {fault}: {}", reader.name, kept.display());
            findings += 1;
        }
        count += 1;
    }
    println!("{}: {count} inputs, {read} of them scenes, {findings} findings", reader.name);
    Ok(findings)
}

/// Whether a file is a scene, and how long that took.
fn load(path: &Path) -> (std::thread::Result<bool>, Duration) {
    let start = Instant::now();
    let result = catch_unwind(AssertUnwindSafe(|| {
        // Moving parts are set to another time.
        scene::load(path).map(|mut scene| scene.set_time(1.25)).is_ok()
    }));
    (result, start.elapsed())
}
