//! Writes the table of many views in `benches/NOTES.md`, `make tables`: what a frame of their maps asks of a
//! GPU.
use gobo::{
    Shadows,
    gpu::{Gpu, Selection, Tier},
    stage::{buckets::BUCKET_PAIRS, sort::Partition},
    view::shadow_views,
};
use std::{
    error::Error,
    fmt::Write as _,
    path::{Path, PathBuf},
};

const OPEN: &str = "<!-- table views -->\n";
const CLOSE: &str = "<!-- end views -->";

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let path =
        std::env::args_os().nth(1).map_or_else(|| root.join("benches/NOTES.md"), PathBuf::from);
    let mut table =
        "| scene | views | tier | on GPUs: dispatches, waits | with a sort: dispatches, waits \
                     | on software adapters: dispatches, waits |\n|---|---|---|---|---|---|\n"
            .to_owned();
    let scenes = ["data/lamps.toml", "data/gallery/market.toml"];
    for (name, tier) in
        scenes.into_iter().flat_map(|name| [(name, Tier::Native), (name, Tier::Core)])
    {
        let gpu = Gpu::new(&Selection { tier: Some(tier), ..Selection::default() })?;
        let scene = gobo_scene::load(&root.join(name))?;
        let views = shadow_views(&scene);
        write!(table, "| `{name}` | {} | {tier} |", views.len())?;
        // A frame is counted first, so that those after it are told of.
        let mut first = Shadows::new(&gpu.device, &gpu.queue, &gpu.adapter)?;
        let prepared = first.prepare(&scene.casters(), &views, &scene.shadow)?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        prepared.record_counts(&mut encoder)?;
        gpu.queue.submit([encoder.finish()]);
        let counted = prepared.counters()?;
        for (partition, bucket_pairs) in
            [(Partition::Wide, BUCKET_PAIRS), (Partition::Wide, 0), (Partition::Serial, 0)]
        {
            let mut shadows = Shadows::new(&gpu.device, &gpu.queue, &gpu.adapter)?;
            shadows.configure(|config| {
                config.tuning.partition = partition;
                config.tuning.bucket_pairs = bucket_pairs;
                config.toggles.scatter_tiny = partition == Partition::Wide;
            });
            shadows.grow_from(&counted);
            let inputs = Default::default();
            let prepared =
                shadows.prepare_uncompiled(&scene.casters(), &views, &scene.shadow, &inputs)?;
            let commands = prepared.commands();
            write!(table, " {}, {} |", commands.dispatch_count(), commands.wait_count())?;
        }
        writeln!(table)?;
    }
    let page = std::fs::read_to_string(&path)?;
    let start = page.find(OPEN).ok_or("the page has no table of views")? + OPEN.len();
    let end = page.find(CLOSE).ok_or("the table of views has no end")?;
    std::fs::write(&path, format!("{}{table}{}", &page[..start], &page[end..]))?;
    print!("{table}");
    Ok(())
}
