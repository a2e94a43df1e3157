//! `gobo bench --tune`: each choice that a [`Tuning`] leaves open, beside the adapter's own, in turns.
use super::{
    arguments::BenchArguments,
    case::{self, Case, casters_of},
    clock::Times,
    measure::Bench,
    report::Report,
};
use crate::{failure::Failure, files, output};
use gobo::{
    gpu::FETCH_FEATURES,
    shadows::Config,
    stage::{buckets::BUCKET_PAIRS, sort::Partition, tuning::Tuning},
};
use serde::Serialize;

/// Least gain that is advised \[share of the adapter's own time\]: less is noise.
const LEAST_GAIN: f64 = 0.03;

/// Another value of one field of the tuning.
struct Choice {
    field: &'static str,
    value: String,
    config: Config,
}

/// A choice in a case.
#[derive(Clone, Debug, Serialize)]
struct Tuned {
    #[serde(flatten)]
    case: Case,
    field: &'static str,
    value: String,
    /// Median time \[ms\].
    compute_ms: f64,
    /// Median time with the adapter's own tuning, in turns \[ms\].
    own_ms: f64,
    /// `compute_ms / own_ms`: below 1 if the choice is faster.
    ratio: f64,
}

/// Every other value of each field that the device can run.
fn choices(own: &Config, has_fetch: bool) -> Vec<Choice> {
    let mut all = Vec::new();
    let mut add = |field, value: String, change: &dyn Fn(&mut Config)| {
        let mut config = *own;
        change(&mut config);
        // Toggles follow the tuning.
        config.toggles.scatter_tiny = config.tuning.scatter_tiny;
        config.toggles.queued = own.toggles.queued && config.tuning.queued;
        if config != *own {
            all.push(Choice { field, value, config });
        }
    };
    let on = |is: bool| if is { "true" } else { "false" }.to_owned();
    for pairs in [256, 512, 1024, 2048, 4096, 8192] {
        add("disc_segment", pairs.to_string(), &|config| config.tuning.disc_segment = pairs);
    }
    for partition in [Partition::Serial, Partition::Wide] {
        add("partition", format!("{partition:?}"), &|config| config.tuning.partition = partition);
    }
    for pairs in [0, BUCKET_PAIRS] {
        // Only wide partitions bin by buckets.
        add("bucket_pairs", pairs.to_string(), &|config| {
            config.tuning.bucket_pairs = pairs;
            config.tuning.partition =
                if pairs > 0 { Partition::Wide } else { config.tuning.partition };
        });
    }
    for is in [false, true] {
        let set = |change: fn(&mut Tuning, bool)| {
            move |config: &mut Config| change(&mut config.tuning, is)
        };
        add("scatter_tiny", on(is), &set(|tuning, is| tuning.scatter_tiny = is));
        add("columns", on(is), &set(|tuning, is| tuning.columns = is));
        add("kinds_apart", on(is), &set(|tuning, is| tuning.kinds_apart = is));
        add("interleaved", on(is), &set(|tuning, is| tuning.interleaved = is));
        if !is || has_fetch {
            add("queued", on(is), &set(|tuning, is| tuning.queued = is));
            add("loaded", on(is), &set(|tuning, is| tuning.loaded = is));
        }
    }
    all
}

/// Measures all choices in all cases, and prints what the tuning should say.
pub(super) fn run(arguments: &BenchArguments, mut bench: Bench) -> Result<(), Failure> {
    let own = Config::new(bench.gpu.tier, &bench.gpu.adapter);
    let mut report: Report<Tuned> = Report::new(&bench, arguments);
    files::print(&report.adapter_and_clock())?;
    let choices = choices(&own, bench.gpu.has(FETCH_FEATURES));
    for case in case::cases(arguments) {
        let inputs = case.inputs();
        let (views, materials) = (case.views(), [case.material()]);
        let casters = casters_of(&inputs, &materials);
        bench.config = own;
        let usual = bench.prepare(&casters, &views)?;
        for Choice { field, value, config } in &choices {
            bench.config = *config;
            let other = bench.prepare(&casters, &views)?;
            let record = |encoder: &mut _| {
                other.record(encoder).expect("no later frame is prepared");
            };
            let times = bench.times(&usual, &[&record])?;
            let row = tuned(case, field, value, times[0], times[1]);
            files::print(&format!(
                "{case}: {field} = {value}: {:.3} ms, {:.3} of {:.3} ms",
                row.compute_ms, row.ratio, row.own_ms
            ))?;
            report.rows.push(row);
        }
    }
    files::print(&advice(&report.rows))?;
    if let Some(path) = &arguments.json {
        output::write(path, report.json().as_bytes())?;
    }
    Ok(())
}

fn tuned(case: Case, field: &'static str, value: &str, own: Times, other: Times) -> Tuned {
    let (compute_ms, own_ms) = (other.median, own.median);
    Tuned { case, field, value: value.to_owned(), compute_ms, own_ms, ratio: compute_ms / own_ms }
}

/// Recommended tuning: for each field the value that is fastest in the mean of all cases, and nowhere slower
/// than the adapter's own by more than it gains.
fn advice(rows: &[Tuned]) -> String {
    let mut best: Vec<(&str, &str, f64)> = Vec::new();
    for row in rows {
        let of_choice = rows.iter().filter(|it| (it.field, &it.value) == (row.field, &row.value));
        let ratios: Vec<_> = of_choice.map(|it| it.ratio).collect();
        let mean = (ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64).exp();
        let worst = ratios.iter().copied().fold(0.0, f64::max);
        if mean > 1.0 - LEAST_GAIN || worst - 1.0 > 1.0 - mean {
            continue;
        }
        match best.iter_mut().find(|(field, ..)| *field == row.field) {
            Some(known) if known.2 > mean => *known = (row.field, &row.value, mean),
            Some(_) => {}
            None => best.push((row.field, &row.value, mean)),
        }
    }
    if best.is_empty() {
        return "Tuning: as it is".to_owned();
    }
    let of = |(field, value, mean): &(&str, &str, f64)| format!("{field} = {value} ({mean:.2})");
    format!("Tuning: {}", best.iter().map(of).collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::arguments::{Layout, ShapeName};

    fn row(field: &'static str, value: &str, own_ms: f64, compute_ms: f64) -> Tuned {
        let case = Case {
            shape: ShapeName::Disc,
            casters: 1,
            footprint: 1.0,
            opacity: 1.0,
            layout: Layout::Spread,
            lights: 1,
            size: 16,
        };
        let times = |median| Times { median, min: median, max: median };
        tuned(case, field, value, times(own_ms), times(compute_ms))
    }

    #[test]
    fn the_fastest_value_that_harms_no_case_is_advised() {
        let rows = [
            row("a", "1", 10.0, 9.0),
            row("a", "1", 5.0, 4.5),
            row("a", "2", 10.0, 5.0),
            row("a", "2", 5.0, 9.0),
            row("b", "3", 10.0, 9.9),
            row("c", "4", 10.0, 8.0),
            row("c", "5", 10.0, 7.0),
        ];
        assert_eq!(advice(&rows), "Tuning: a = 1 (0.90), c = 5 (0.70)");
        assert_eq!(advice(&rows[4..5]), "Tuning: as it is");
    }
}
