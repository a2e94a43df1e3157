//! Writes the tables of `docs/dither.md`: `make tables`.
use gobo::{
    caster::{Material, Particle, Profile, Transfer},
    dither::{Pattern, measure},
    glam::{Mat4, UVec2, Vec3, Vec4},
    gpu::{Gpu, Timeline},
    pipeline::{CasterSet, Config, Pipeline},
    scene::generate::Chance,
    view::{Part, Projection, View},
    wgpu,
};
use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
    time::Instant,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let usual = || Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/dither.md");
    let path = std::env::args_os().nth(1).map_or_else(usual, PathBuf::from);
    let mut page = std::fs::read_to_string(&path)?;
    for (name, table) in [("quality", quality()?), ("flicker", flicker()?), ("cost", cost()?)] {
        page = replaced(&page, name, &table)?;
    }
    std::fs::write(&path, page)?;
    println!("{}", path.display());
    Ok(())
}

/// What is between the markers of a table, anew.
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

/// Duplicates of a disc of 2 texels radius and 50%, spread over a map of 512x512 texels.
const COUNTS: [u32; 6] = [1, 10, 100, 1_000, 10_000, 100_000];
const RUNS: usize = 30;

fn cost() -> Result<String, Box<dyn std::error::Error>> {
    let gpu = Gpu::headless()?;
    let mut pipeline = Pipeline::new(&gpu.device, Config::new(gpu.tier, &gpu.adapter));
    let mut frame = |transfer: Transfer, count: u32| -> Result<f64, Box<dyn std::error::Error>> {
        let flat = Material { transfer, profile: Profile::Flat, ..Material::default() };
        let particles = duplicates(count);
        let casters = CasterSet::new(&gpu.device, &gpu.queue, &particles, &[], &[flat], &[])?;
        let prepared = pipeline.prepare(&gpu.device, &gpu.queue, &casters, &[view()], None)?;
        let mut best = f64::INFINITY;
        for _ in 0..RUNS {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            prepared.record(pipeline.kernels(), &mut encoder, &mut Timeline::untimed());
            let clock = Instant::now();
            gpu.queue.submit([encoder.finish()]);
            gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
            best = best.min(clock.elapsed().as_secs_f64() * 1e3);
        }
        Ok(best)
    };
    let mut table = format!(
        "{}; the fastest of {RUNS} frames.\n\n| duplicates | opaque [ms] | dithered [ms] \
         | dithered / opaque | above one caster [us per caster] |\n|---|---|---|---|---|\n",
        gpu.adapter.name
    );
    let mut one = 0.0;
    for count in COUNTS {
        let (opaque, dithered) = (frame(Transfer::Opaque, count)?, frame(Transfer::Dither, count)?);
        let per_caster = if count == 1 {
            one = dithered;
            "-".to_owned()
        } else {
            format!("{:.2}", (dithered - one).max(0.0) * 1e3 / f64::from(count - 1))
        };
        writeln!(
            table,
            "| {count} | {opaque:.2} | {dithered:.2} | {:.2} | {per_caster} |",
            dithered / opaque
        )?;
    }
    Ok(table)
}

fn duplicates(count: u32) -> Vec<Particle> {
    let mut chance = Chance::new(3);
    let mut along = || chance.within(-250.0, 250.0);
    (0..count)
        .map(|id| Particle {
            center: Vec3::new(along(), along(), -5.0 + along() * 0.01),
            radius: 2.0,
            color: Vec4::new(1.0, 1.0, 1.0, 0.5),
            rotation: 0.0,
            material: 0,
            id,
        })
        .collect()
}

/// Looks along -z; a texel is a metre wide.
fn view() -> View {
    View {
        part: Part::Whole,
        light: Some(0),
        name: "0",
        projection: Projection::Orthographic,
        size: UVec2::splat(512),
        near: 0.0,
        far: 10.0,
        view_from_world: Mat4::IDENTITY,
        scale: 1.0,
    }
}
