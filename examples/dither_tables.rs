//! Writes the tables of `docs/dither.md`: `make tables`.
#[path = "measure/dither.rs"]
mod measure;

use gobo::{
    Counters, Receiver, ShadowSettings, Shadows,
    glam::{Mat4, UVec2},
    gpu::Gpu,
    model::{Casters, Material, Pattern, Projection, Transfer, View, ViewRole},
    wgpu,
};
use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
    time::Instant,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let usual = || Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("docs/dither.md");
    let path = std::env::args_os().nth(1).map_or_else(usual, PathBuf::from);
    let mut page = std::fs::read_to_string(&path)?;
    for (name, table) in [("quality", quality()?), ("flicker", flicker()?), ("cost", cost()?)] {
        page = replaced(&page, name, &table)?;
    }
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

fn quality() -> Result<String, std::fmt::Error> {
    let mut table = "| pattern | levels | coverage, rms | worst | light, dithered | softened \
                     | coloured, dithered | softened |\n|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    for pattern in Pattern::ALL {
        let coverage = measure::coverage_error(pattern);
        let shadow = measure::shadow_error(pattern);
        let colored = measure::colored_error(pattern);
        let levels = pattern.levels().map_or("-".to_owned(), |levels| levels.to_string());
        writeln!(
            table,
            "| `{}` | {levels} | {:.4} | {:.4} | {:.3} | {:.3} | {:.3} | {:.3} |",
            pattern.name(),
            coverage.rms,
            coverage.max,
            shadow.dithered,
            shadow.softened,
            colored.dithered,
            colored.softened
        )?;
    }
    Ok(table)
}

fn flicker() -> Result<String, std::fmt::Error> {
    let mut table = "| pattern | dithered | softened | texels that change | softened, view snaps \
                     |\n|---|---|---|---|---|\n"
        .to_owned();
    let exact = std::iter::once(None);
    for pattern in exact.chain(Pattern::ALL.map(Some)) {
        let flicker = measure::flicker(pattern);
        writeln!(
            table,
            "| {} | {:.4} | {:.4} | {:.1}% | {:.5} |",
            pattern.map_or("exact filter".to_owned(), |pattern| format!("`{}`", pattern.name())),
            flicker.dithered,
            flicker.softened,
            flicker.changed * 100.0,
            flicker.snapping
        )?;
    }
    Ok(table)
}

const COUNTS: [u32; 5] = [10, 100, 1_000, 10_000, 100_000];

/// Frames per count: fewer if the work exceeds the noise.
fn runs(count: u32) -> usize {
    match count {
        0..=10 => 800,
        11..=100 => 120,
        101..=10_000 => 4,
        _ => 1,
    }
}

fn cost() -> Result<String, Box<dyn std::error::Error>> {
    let gpu = Gpu::headless()?;
    let frames = |transfer: Transfer, count: u32| -> Result<_, Box<dyn std::error::Error>> {
        let material = Material { transfer, ..measure::duplicated() };
        let particles = measure::duplicates(count);
        let casters =
            Casters { particles: &particles, materials: &[material], ..Casters::default() };
        let mut shadows = Shadows::new(&gpu.device, &gpu.queue, &gpu.adapter)?;
        let full = Counters {
            pairs_needed: count.saturating_mul(120).max(1 << 16),
            ..Counters::default()
        };
        shadows.grow_from(&full);
        let nearest = ShadowSettings { receiver: Receiver::Nearest, ..ShadowSettings::default() };
        let prepared = shadows.prepare(&casters, &[view()], &nearest)?;
        let frame = || -> Result<f64, Box<dyn std::error::Error>> {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            prepared.record(&mut encoder)?;
            let clock = Clock::start(&gpu);
            gpu.queue.submit([encoder.finish()]);
            gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
            Ok(clock.milliseconds())
        };
        (0..runs(count)).map(|_| frame()).collect::<Result<Vec<f64>, _>>()
    };
    // Other load on the machine only adds time.
    let fastest = |transfer, count| -> Result<f64, Box<dyn std::error::Error>> {
        Ok(frames(transfer, count)?.into_iter().fold(f64::INFINITY, f64::min))
    };
    let mut table = format!(
        "{}; core time of the fastest of many frames.\n\n| duplicates | opaque [ms] | dithered [ms] | \
         dithered, above one caster \
         [us per caster] |\n|---|---|---|---|\n",
        gpu.adapter.name
    );
    let one = fastest(Transfer::Dither, 1)?;
    writeln!(table, "| 1 | {:.2} | {one:.2} | - |", fastest(Transfer::Opaque, 1)?)?;
    for count in COUNTS {
        let (opaque, dithered) =
            (fastest(Transfer::Opaque, count)?, fastest(Transfer::Dither, count)?);
        let per_caster = (dithered - one) * 1e3 / f64::from(count - 1);
        writeln!(table, "| {count} | {opaque:.2} | {dithered:.2} | {per_caster:.2} |")?;
    }
    Ok(table)
}

/// Clock: on a software adapter, CPU time of all threads, which does not depend on other load; otherwise, or
/// if the system does not report it, wall time.
struct Clock {
    start: Instant,
    busy: Option<u64>,
}

impl Clock {
    fn start(gpu: &Gpu) -> Self {
        let software = gpu.adapter.device_type == wgpu::DeviceType::Cpu;
        Self { start: Instant::now(), busy: software.then(Self::busy).flatten() }
    }

    /// CPU time so far [ns].
    fn busy() -> Option<u64> {
        let mut sum = 0;
        for thread in std::fs::read_dir("/proc/self/task").ok()? {
            let stat = std::fs::read_to_string(thread.ok()?.path().join("schedstat")).ok()?;
            sum += stat.split(' ').next()?.parse::<u64>().ok()?;
        }
        Some(sum)
    }

    fn milliseconds(&self) -> f64 {
        match (self.busy, Self::busy()) {
            (Some(first), Some(last)) => last.saturating_sub(first) as f64 * 1e-6,
            _ => self.start.elapsed().as_secs_f64() * 1e3,
        }
    }
}

/// A view along -z; a texel is 1 m wide.
fn view() -> View {
    View {
        role: ViewRole::Whole,
        light: Some(0),
        name: "0",
        projection: Projection::Orthographic,
        size: UVec2::splat(measure::COST_SIZE),
        near: 0.0,
        far: 10.0,
        view_from_world: Mat4::IDENTITY,
        scale: 1.0,
    }
}
