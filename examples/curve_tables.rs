//! Writes the tables of `docs/curves.md`, `docs/gaussians.md`, `docs/grids.md` and `docs/strands.md`: `make
//! quality`. With names of tables, only those.
#[path = "measure/avsm.rs"]
mod avsm;
#[path = "measure/curves.rs"]
mod curves;
#[path = "measure/deep.rs"]
mod deep;
#[allow(dead_code, reason = "tests compare maps with it")]
#[path = "../tests/common/grid_truth.rs"]
mod grid_truth;
#[path = "measure/grids.rs"]
mod grids;
#[path = "measure/kernels.rs"]
mod kernels;
#[path = "measure/moments.rs"]
mod moments;
#[path = "measure/rays.rs"]
mod rays;
#[path = "measure/rivals.rs"]
mod rivals;
#[path = "measure/splats.rs"]
mod splats;
#[allow(dead_code, reason = "tests compare maps with it")]
#[path = "../tests/common/strand_truth.rs"]
mod strand_truth;
#[path = "measure/strands.rs"]
mod strands;

use curves::{Method, Rays, Sample};
use gobo::{
    gpu::{Gpu, Selection},
    model::Scene,
    records::ViewMaps,
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene as scene;
use rays::{asset, scene_of};
use std::{cell::RefCell, error::Error, fmt::Write as _, path::Path, time::Instant};

type Table = fn() -> Result<Option<String>, Box<dyn Error>>;

/// Tables: their page, their name there, and the function that makes them; `None` if their files are absent.
const TABLES: [(&str, &str, Table); 7] = [
    ("docs/curves.md", "quality", || Ok(Some(quality()?))),
    ("docs/curves.md", "kernels", || kernel_table().map(Some)),
    ("docs/gaussians.md", "generated", generated_splats),
    ("docs/gaussians.md", "captured", captured_splats),
    ("docs/grids.md", "generated", generated_grids),
    ("docs/grids.md", "smoke", smoke),
    ("docs/strands.md", "fur", fur),
];

fn main() -> Result<(), Box<dyn Error>> {
    let names: Vec<String> = std::env::args().skip(1).collect();
    let is_named = |page: &str, name: &str| {
        names.is_empty() || names.iter().any(|given| *given == format!("{page}:{name}"))
    };
    for (page, name, table) in TABLES.into_iter().filter(|(page, name, _)| is_named(page, name)) {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(page);
        if let Some(table) = table()? {
            let text = replaced(&std::fs::read_to_string(&path)?, name, &table)?;
            std::fs::write(&path, text)?;
            println!("{page}: {name}");
        } else {
            println!("{page}: {name}: files absent, left as it is");
        }
    }
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

/// Errors of the kernels' own maps of the bench's discs.
fn kernel_table() -> Result<String, Box<dyn Error>> {
    let gpu = Gpu::new(&Selection::default())?;
    let mut table =
        "| discs | K | hits a ray | mean | 99 % | max |\n|---|---|---|---|---|---|\n".to_owned();
    for casters in [1000, 100_000, 1_000_000] {
        let discs = kernels::Discs::new(casters);
        for nodes in [4, 8, 16] {
            let kernels::Row { mean, high, most } = kernels::Row::of(&discs.errors(&gpu, nodes)?);
            let (start, hits) = (kernels::Row::start(casters, nodes), discs.hits());
            writeln!(table, "{start} {hits:.1} | {mean:.5} | {high:.4} | {most:.3} |")?;
        }
    }
    Ok(table)
}

/// Renders the maps of a scene's first view, by the kernels.
fn renderer() -> Result<impl Fn(&Scene) -> ViewMaps, Box<dyn Error>> {
    let renderer = RefCell::new(Renderer::on(Gpu::new(&Selection::default())?)?);
    let options = RenderOptions { maps: true, maps_only: true, ..RenderOptions::default() };
    Ok(move |scene: &Scene| {
        let frame = renderer.borrow_mut().render(scene, &options);
        let mut frame = frame.unwrap_or_else(|error| panic!("{error}"));
        frame.maps.swap_remove(0)
    })
}

/// Rays of each cloud and grid.
const RAYS: usize = 300;

fn generated_splats() -> Result<Option<String>, Box<dyn Error>> {
    let splats = |generate: &str| scene_of(&format!("[[splats]]\ngenerate = {generate}\n"));
    let cloud = splats("{ kind = \"cloud\", count = 20000, seed = 3, radius = 0.06 }")?;
    let smoke = splats("{ kind = \"smoke\", count = 20000, seed = 3, radius = 0.08 }")?;
    let clouds = [
        ("cloud of 20,000", splats::Cloud::new(cloud, 256, RAYS)),
        ("column of 20,000", splats::Cloud::new(smoke, 256, RAYS)),
    ];
    splat_table(&clouds).map(Some)
}

fn captured_splats() -> Result<Option<String>, Box<dyn Error>> {
    let files = ["gaussian-smoke-835.ply", "biker.compressed.ply"];
    let (Some(smoke), Some(biker)) = (asset(files[0]), asset(files[1])) else { return Ok(None) };
    // With its own density, unlike the file rendered alone.
    let smoke = scene_of(&format!("[[splats]]\nfile = {:?}\n", smoke.display().to_string()))?;
    let clouds = [
        ("gaussian-smoke-835", splats::Cloud::new(smoke, 256, RAYS)),
        ("biker", splats::Cloud::new(scene::load(&biker)?, 1024, RAYS)),
    ];
    splat_table(&clouds).map(Some)
}

fn splat_table(clouds: &[(&str, splats::Cloud)]) -> Result<String, Box<dyn Error>> {
    let mut table = "| method | bytes |".to_owned();
    for (name, cloud) in clouds {
        write!(table, " {name} ({:.0} hits a ray), mean | 99 % |", cloud.hits())?;
    }
    write!(table, "\n|---|---|{}\n", "---|---|".repeat(clouds.len()))?;
    let render = renderer()?;
    for method in splats::Method::ALL {
        let bytes = method.bytes();
        let bytes = if bytes == 0 { "-".to_owned() } else { bytes.to_string() };
        write!(table, "| {} | {bytes} |", method.name())?;
        for (_, cloud) in clouds {
            let errors = cloud.errors(method, &render);
            write!(table, " {:.4} | {:.3} |", errors.mean(), errors.quantile(0.99))?;
        }
        table.push('\n');
    }
    Ok(table)
}

fn generated_grids() -> Result<Option<String>, Box<dyn Error>> {
    let grid = |kind: &str| {
        let generate = format!("generate = {{ kind = \"{kind}\", seed = 3, voxels = 96 }}");
        let factor = "density = { factor = 4 }\ncolor = [1, 0.7, 0.4]";
        scene_of(&format!("[[volume]]\n{generate}\n{factor}\n"))
    };
    let volumes = [
        ("cloud", grids::Volume::new(grid("cloud")?, 256, RAYS)),
        ("plume", grids::Volume::new(grid("plume")?, 256, RAYS)),
    ];
    volume_table(&volumes, &grids::Method::ALL).map(Some)
}

fn fur() -> Result<Option<String>, Box<dyn Error>> {
    let of = |count: u32, length: f32| scene_of(&strands::fur(count, length));
    let volumes = [
        ("2,000 hairs", grids::Volume::of_hair(of(2000, 0.3)?, 128, RAYS)),
        ("20,000 hairs", grids::Volume::of_hair(of(20_000, 0.3)?, 128, RAYS)),
    ];
    volume_table(&volumes, &grids::Method::OF_HAIR).map(Some)
}

fn smoke() -> Result<Option<String>, Box<dyn Error>> {
    let Some(file) = asset("smoke.vdb") else { return Ok(None) };
    let volume = grids::Volume::new(scene::load(&file)?, 512, RAYS);
    volume_table(&[("smoke.vdb", volume)], &grids::Method::ALL).map(Some)
}

fn volume_table(
    volumes: &[(&str, grids::Volume)],
    methods: &[grids::Method],
) -> Result<String, Box<dyn Error>> {
    let mut table = "| method | bytes |".to_owned();
    for (name, _) in volumes {
        write!(table, " {name}, mean | 99 % |")?;
    }
    write!(table, "\n|---|---|{}\n", "---|---|".repeat(volumes.len()))?;
    let render = renderer()?;
    for &method in methods {
        write!(table, "| {} | {} |", method.name(), method.bytes())?;
        for (_, volume) in volumes {
            let errors = volume.errors(method, &render);
            write!(table, " {:.5} | {:.3} |", errors.mean(), errors.quantile(0.99))?;
        }
        table.push('\n');
    }
    Ok(table)
}
