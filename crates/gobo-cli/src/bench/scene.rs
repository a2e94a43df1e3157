//! `gobo bench --scene`: the maps of a scene's first frame, rendered anew in each run.
use super::{
    against::Earlier,
    arguments::BenchArguments,
    measure::{Bench, Measured},
    report::{self, Report},
};
use crate::{
    failure::Failure,
    files,
    output::{self, Output},
    wall_clock::WallClock,
};
use gobo::view::shadow_views;
use gobo_scene as scene;
use serde::Serialize;
use std::path::Path;

#[derive(Clone, Debug, Serialize)]
struct SceneRow<'a> {
    scene: &'a Path,
    /// Casters in all views.
    visible: u64,
    views: usize,
    /// Texels of all maps.
    texels: u64,
    #[serde(flatten)]
    compute: Measured,
}

/// Prints the results, writes them as JSON with `--json`, and compares them with those of `--against`.
pub(super) fn run(
    arguments: &BenchArguments,
    mut bench: Bench,
    path: &Path,
    clock: &WallClock,
    earlier: Option<&Earlier>,
) -> Result<(), Failure> {
    let scene = scene::load_with(path, &arguments.set)?;
    arguments.json.as_deref().map(Output::check).transpose()?;
    let (casters, views) = (scene.casters(), shadow_views(&scene));
    if views.is_empty() {
        let help = "give it a light that casts shadows";
        return Err(Failure::refused(path, "has no shadow maps", help));
    }
    let pair_budget = arguments.pair_budget.unwrap_or(scene.shadow.pair_budget);
    bench.settings = gobo::ShadowSettings { pair_budget, ..scene.shadow };
    let mut report = Report::new(&bench, arguments);
    files::print(&report.adapter_and_clock())?;
    let prepared = bench.prepare(&casters, &views)?;
    let times = bench.times(&prepared, &[])?;
    let mut row = SceneRow {
        scene: path,
        visible: prepared.counters()?.visible,
        views: views.len(),
        texels: views.iter().map(|view| u64::from(view.size.x) * u64::from(view.size.y)).sum(),
        compute: bench.measured(&prepared, times[0])?,
    };
    row.compute.milliseconds = clock.take();
    let (times, below) = (report::times(&row.compute), report::below(&row.compute));
    let SceneRow { visible, views, texels, .. } = row;
    files::print(&format!(
        "{}: {visible} casters in {views} views, {texels} texels, {times} ms\n{below}",
        path.display()
    ))?;
    report.rows.push(row);
    if let Some(path) = &arguments.json {
        output::write(path, report.json().as_bytes())?;
    }
    earlier.map_or(Ok(()), |earlier| earlier.compare(&report, arguments.limit))
}
