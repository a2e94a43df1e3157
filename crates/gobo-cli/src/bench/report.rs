//! Results as a table for people and as JSON for scripts.
use super::{
    arguments::{BenchArguments, ShapeName},
    case::Case,
    measure::{Bench, KernelRow, Measured, Row},
};
use gobo::Receiver;
use serde::Serialize;
use std::fmt;

#[derive(Clone, Debug, Serialize)]
pub(super) struct Report<R = Row> {
    version: &'static str,
    pub(super) adapter: String,
    pub(super) driver: String,
    pub(super) tier: &'static str,
    reason: String,
    /// `wall` [submit to done] or `timestamps`.
    pub(super) clock: &'static str,
    /// Kind of the casters: `particles`, `splats`, opaque `triangles`, or those of a `scene`.
    casters: &'static str,
    /// Nodes of a curve, for maps with curves.
    #[serde(skip_serializing_if = "Option::is_none")]
    nodes: Option<u32>,
    pub(super) rows: Vec<R>,
}

impl<R: Serialize> Report<R> {
    pub(super) fn new(bench: &Bench, arguments: &BenchArguments) -> Self {
        let gpu = &bench.gpu;
        Self {
            version: env!("CARGO_PKG_VERSION"),
            adapter: gpu.adapter.name.clone(),
            driver: format!("{} {}", gpu.adapter.driver, gpu.adapter.driver_info).trim().to_owned(),
            tier: gpu.tier.name(),
            reason: gpu.tier_reason.clone(),
            clock: bench.clock.name(),
            casters: match arguments.shape {
                _ if arguments.scene.is_some() => "scene",
                _ if arguments.occlude => "triangles",
                _ if arguments.splats.is_some() => "splats",
                ShapeName::Gaussian => "splats",
                ShapeName::Disc => "particles",
            },
            nodes: (bench.settings.receiver == Receiver::Curve).then_some(bench.settings.nodes),
            rows: Vec::new(),
        }
    }

    pub(super) fn json(&self) -> String {
        serde_json::to_string_pretty(self).expect("plain data is JSON") + "\n"
    }

    pub(super) fn adapter_and_clock(&self) -> String {
        let Self { adapter, driver, reason, clock, .. } = self;
        format!("{adapter} ({driver}), {reason}, {clock} clock")
    }

    /// Adapter and clock, and the names of the columns.
    pub(super) fn heading(&self) -> String {
        format!(
            "{}\n{:>8} {:>9} {:>7} {:>6} {:>6} {:>5} \
             {:>25} {:>25} {:>9} {:>6}",
            self.adapter_and_clock(),
            "casters",
            "footprint",
            "opacity",
            "layout",
            "lights",
            "size",
            "compute [ms] (min..max)",
            "raster [ms] (min..max)",
            "two-pass",
            "ratio",
        )
    }
}

/// A row of the table, and below it the stages.
pub(super) fn line(row: &Row) -> String {
    let Case { casters, footprint, opacity, layout, lights, size, .. } = row.case;
    let mut line = format!(
        "{:>8} {footprint:>9} {opacity:>7} {:>6} {lights:>6} {size:>5} {:>25}",
        short(casters),
        layout.name(),
        times(&row.compute),
    );
    if let Some(raster) = &row.raster {
        let times = spread(raster.raster_ms, raster.raster_min, raster.raster_max);
        let two_pass = raster.raster_two_pass_ms.map_or("-".to_owned(), |ms| format!("{ms:.2}"));
        line += &format!(" {times:>25} {two_pass:>9} {:>6.2}", raster.ratio);
    }
    line + "\n" + &below(&row.compute)
}

/// Median, least and largest [ms].
fn spread(median: f64, min: f64, max: f64) -> String {
    format!("{median:.2} ({min:.2}..{max:.2})")
}

pub(super) fn times(compute: &Measured) -> String {
    spread(compute.compute_ms, compute.compute_min, compute.compute_max)
}

/// Stages, pairs and memory, and the phases of the command.
pub(super) fn below(compute: &Measured) -> String {
    let stages: Vec<_> =
        compute.stages.iter().map(|(name, ms)| format!("{name} {ms:.2}")).collect();
    let bytes: u64 = compute.bytes.iter().map(|(_, bytes)| bytes).sum();
    let mut line = format!(
        "{:>9}{}; {} pairs, {:.1} MiB",
        "",
        stages.join(", "),
        compute.pairs,
        bytes as f64 / f64::from(1 << 20)
    );
    if compute.scattered > 0 {
        line += &format!("; {} scattered", compute.scattered);
    }
    if compute.overflowed > 0 {
        line += &format!(", {} of them past the pair capacity", compute.overflowed);
    }
    for KernelRow { stage, kernel, dispatches, ms } in &compute.kernels {
        line += &format!("\n{:>9}{stage}/{kernel} {ms:.3}", "");
        if *dispatches > 1 {
            line += &format!(" in {dispatches}");
        }
    }
    let all: f64 = compute.milliseconds.iter().map(|(_, ms)| ms).sum();
    let phases = compute.milliseconds.iter().map(|(name, ms)| format!("{name} {:.2}", ms * 1e-3));
    let phases = phases.collect::<Vec<_>>().join(", ");
    line + &format!("\n{:>9}in {:.2} s: {phases}", "", all * 1e-3)
}

/// A count as `10k`, `1.5m`.
pub(super) fn short(count: u32) -> String {
    match count {
        0..1_000 => count.to_string(),
        1_000..1_000_000 => format!("{}k", f64::from(count) / 1e3),
        _ => format!("{}m", f64::from(count) / 1e6),
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { shape, casters, footprint, opacity, layout, lights, size } = self;
        let (casters, layout) = (short(*casters), layout.name());
        write!(
            f,
            "{casters} {} of {footprint} texels, opacity {opacity}, {layout}, {lights} lights, \
             size {size}",
            shape.plural()
        )
    }
}
