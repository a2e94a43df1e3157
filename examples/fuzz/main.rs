//! Fuzzer: changes files at random and reads them, `make fuzz`.
//!
//! `cargo run --release --example fuzz [READER]...` with `FUZZ_SECONDS` of CPU time for each reader (30) and
//! `FUZZ_SEED` (0). A reader fails if it panics, takes longer than `SLOW` or more memory than `LARGE`, or
//! disagrees with `scene::check`. Accepted scenes are rendered at a tiny size by the CPU reference, which
//! fails in the same ways. The failing input is written to out/fuzz, or to the folder that `FUZZ_OUT` names,
//! and so is the last input (`current.*`), for a run that was killed.
#[path = "../../tests/common/arrays.rs"]
#[allow(dead_code, reason = "tests write more kinds of files")]
mod arrays;
mod beside;
mod cost;
mod keys;
mod models;
mod mutate;
#[path = "../../tests/common/nano.rs"]
#[allow(dead_code, reason = "tests write more kinds of files")]
mod nano;
#[path = "../../tests/common/points.rs"]
#[allow(dead_code, reason = "tests write other kinds of files")]
mod points;
mod program;
mod seeds;
#[path = "../../tests/common/splats.rs"]
#[allow(dead_code, reason = "tests change parts of the files")]
mod splats;
#[path = "../../tests/common/vdb.rs"]
#[allow(dead_code, reason = "tests write more kinds of files")]
mod vdb;

use cost::{Clock, LARGE};
use gobo::glam::UVec2;
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene as scene;
use gobo_scene::{Scene, generate::Chance};
use program::Program;
use std::{
    fs, io,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    process::ExitCode,
    time::Duration,
};

/// Time to load the largest scene within the limits.
const SLOW: Duration = Duration::from_secs(20);

/// Files of one kind.
struct Reader {
    name: &'static str,
    extension: &'static str,
    seeds: Vec<Vec<u8>>,
    /// A scene file that reads `current.EXTENSION`, if that is no scene file itself.
    scene: Option<String>,
}

fn main() -> io::Result<ExitCode> {
    let number = |name: &str, usual: u64| {
        std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
    };
    let (seconds, seed) = (number("FUZZ_SECONDS", 30), number("FUZZ_SEED", 0));
    let only: Vec<String> = std::env::args().skip(1).collect();
    let out = std::env::var_os("FUZZ_OUT").map_or_else(|| "out/fuzz".into(), PathBuf::from);
    fs::create_dir_all(&out)?;
    // A finding is one line, not a backtrace.
    std::panic::set_hook(Box::new(|_| ()));
    let mut findings = 0;
    let time = Duration::from_secs(seconds);
    let is_asked = |name: &str| only.is_empty() || only.iter().any(|asked| asked == name);
    for reader in seeds::readers(&out)?.iter().filter(|reader| is_asked(reader.name)) {
        let input = out.join(format!("current.{}", reader.extension));
        let scene = out.join("current.toml");
        if let Some(text) = &reader.scene {
            fs::write(&scene, text)?;
        }
        let path = if reader.scene.is_some() { &scene } else { &input };
        let read = |bytes: &[u8]| {
            fs::write(&input, bytes)?;
            let (result, took) = load(path, &[]);
            // `relight` reads them beside the splats.
            let harmonics = catch_unwind(|| scene::load_harmonics(&input).is_ok());
            Ok((harmonics.map_or(Err("panics"), |_| result), took))
        };
        findings += run(reader.name, reader.extension, &reader.seeds, time, seed, &out, read)?;
    }
    if is_asked("keys") {
        findings += keys::run(&seeds::folders(), time, &out)?;
    }
    for (name, extension, of) in [
        ("sidecar", "json", Program::of_sidecars as fn(&Path) -> _),
        ("npy", "npy", Program::of_points),
        ("part", "gobo", Program::of_parts),
    ] {
        if is_asked(name) {
            let (program, seeds) = of(&out)?;
            let read = |bytes: &[u8]| program.read(bytes);
            findings += run(name, extension, &seeds, time, seed, &out, read)?;
        }
    }
    Ok(if findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Result of an input without a fault.
#[derive(Clone, Copy, PartialEq)]
enum End {
    Refused,
    Accepted,
    /// Accepted: rendered, if it is a scene, or answered.
    Used,
}

/// Result of an input, or its fault, and the elapsed time.
type Outcome = (Result<End, &'static str>, Duration);

/// Number of inputs that failed.
fn run(
    name: &str,
    extension: &str,
    seeds: &[Vec<u8>],
    time: Duration,
    seed: u64,
    out: &Path,
    read: impl Fn(&[u8]) -> io::Result<Outcome>,
) -> io::Result<usize> {
    let mut chance = Chance::new(seed);
    let (clock, mut count, mut findings) = (Clock::start(), 0_u64, 0);
    let (mut accepted, mut used, mut most) = (0_u64, 0_u64, 0);
    while clock.elapsed() < time {
        let mut bytes = mutate::mutated(seeds, &mut chance);
        if extension == "gobo" {
            mutate::seal(&mut bytes);
        }
        cost::forget_peak();
        let (result, took) = read(&bytes)?;
        let peak = cost::peak();
        most = most.max(peak);
        let fault = match result {
            Err(fault) => Some(fault),
            Ok(_) if took > SLOW => Some("is slow"),
            Ok(_) if peak > LARGE => Some("takes too much memory"),
            Ok(end) => {
                accepted += u64::from(!matches!(end, End::Refused));
                used += u64::from(matches!(end, End::Used));
                None
            }
        };
        if let Some(fault) = fault {
            let kept = out.join(format!("{name}-{count}.{extension}"));
            fs::write(&kept, &bytes)?;
            println!("{name}: {fault}: {}", kept.display());
            findings += 1;
        }
        count += 1;
    }
    let (seconds, mib) = (clock.elapsed().as_secs_f64(), most >> 20);
    println!(
        "{name}: {count} inputs, {accepted} accepted, {used} rendered, {findings} findings, \
         {seconds:.0} s, at most {mib} MiB"
    );
    Ok(findings)
}

/// Checks and reads a scene, and renders it if it is one.
fn load(path: &Path, set: &[(String, String)]) -> Outcome {
    let clock = Clock::start();
    let read =
        catch_unwind(|| (scene::check_with(path, set).is_ok(), scene::load_with(path, set).ok()));
    let took = clock.elapsed();
    let result = match read {
        Err(_) => Err("panics"),
        Ok((true, None)) => Err("is checked, but refused"),
        Ok((false, Some(_))) => Err("is refused by check alone"),
        Ok((false, None)) => Ok(End::Refused),
        Ok((true, Some(scene))) => rendered(scene),
    };
    (result, took)
}

/// Times of a scene, of which an animated one has two [s].
const TIMES: [f64; 2] = [0.0, 1.25];

/// Renders a scene at a tiny size on the CPU. Scenes of many casters would take most of the time.
fn rendered(mut scene: Scene) -> Result<End, &'static str> {
    const MOST_CASTERS: usize = 100_000;
    const MOST_LIGHTS: usize = 16;
    // The reference lights every voxel of a brick, whatever the picture's size.
    const MOST_BRICKS: usize = 256;
    let casters = scene.particles.len() + scene.triangles.len() + scene.gaussians.len();
    let bricks = scene.grids.iter().map(|grid| grid.bricks.len()).sum::<usize>();
    if casters > MOST_CASTERS || bricks > MOST_BRICKS || scene.lights.len() > MOST_LIGHTS {
        return Ok(End::Accepted);
    }
    scene.camera.size = UVec2::new(8, 4);
    scene.shadow.size = 16;
    // Samples, viewpoints and slices of air each walk all casters again: minutes of the reference.
    (scene.samples, scene.lens.radius, scene.shutter) = (1, 0.0, 0.0);
    scene.shadow.soft_detail = false;
    if let Some(air) = &mut scene.air {
        air.steps = air.steps.min(4);
    }
    for light in &mut scene.lights {
        (light.size, light.viewpoints) = (None, light.viewpoints.min(2));
    }
    let render = AssertUnwindSafe(|| {
        let times = if scene.motions.is_empty() { &TIMES[..1] } else { &TIMES };
        times.iter().try_for_each(|&seconds| {
            scene.set_time(seconds);
            Renderer::on_cpu().render(&scene, &RenderOptions::default()).map(drop)
        })
    });
    match catch_unwind(render) {
        Err(_) => Err("panics when it is rendered"),
        Ok(Ok(()) | Err(gobo::Error::Limit { .. })) => Ok(End::Used),
        Ok(Err(_)) => Err("is refused when it is rendered"),
    }
}
