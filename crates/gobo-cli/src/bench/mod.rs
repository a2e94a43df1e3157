//! `gobo bench`: cost of shadow maps, compared with the raster pipeline.
mod against;
mod arguments;
mod case;
mod check;
mod clock;
mod masks;
mod measure;
mod occlude;
mod page;
mod raster;
mod report;
mod scene;
mod shares;
mod tune;

pub(crate) use arguments::BenchArguments;
pub use case::bench_discs;

use super::{
    failure::Failure,
    files,
    output::{self, Output},
    wall_clock::WallClock,
};
use against::Earlier;
use arguments::{MAX_LIST, ReceiverName, ShapeName};
use gobo::gpu::{Backend, Gpu, Selection};
use measure::Bench;
use raster::Inputs;
use report::Report;
use tracing::debug_span;

/// Least opacity beside the raster pipeline.
const MIN_RASTER_OPACITY: f32 = 0.005;

pub(crate) fn run(arguments: &BenchArguments, clock: &WallClock) -> Result<(), Failure> {
    let backend = arguments.device.backend();
    if backend == Backend::Cpu {
        return Err(Failure::Usage(
            "gobo bench measures kernels; a software adapter such as lavapipe runs them on the CPU: \
             use --backend vulkan"
                .to_owned(),
        ));
    }
    let outputs = arguments.json.iter().chain(&arguments.html);
    outputs.clone().try_for_each(|path| Output::check(path))?;
    if arguments.stage.is_some() {
        return masks::run(arguments);
    }
    let selection = Selection { backend, adapter: arguments.device.adapter.clone(), tier: None };
    let earlier = arguments.against.as_deref().map(Earlier::read).transpose()?;
    let mut bench = Bench::new(Gpu::new(&selection)?, arguments);
    if let Some(path) = &arguments.scene {
        return scene::run(arguments, bench, path, clock, earlier.as_ref());
    }
    if arguments.tune {
        return tune::run(arguments, bench);
    }
    let mut report = Report::new(&bench, arguments);
    files::print(&report.heading())?;
    let (cases, of_file) = match &arguments.splats {
        Some(path) => {
            let mut splats = gobo_scene::load(path)?.gaussians;
            outputs.clone().try_for_each(|path| Output::check(path))?;
            if splats.is_empty() {
                let help = "name a file of splats, such as a .ply, .spz or .sog";
                return Err(Failure::refused(path, "holds no splats", help));
            }
            (case::cases_of_file(arguments, &mut splats), Some(Inputs::Splats(splats)))
        }
        None => (case::cases(arguments), None),
    };
    for case in cases {
        if arguments.vs.is_some() && case.opacity < MIN_RASTER_OPACITY {
            let message = format!(
                "{case}: fp16 products of the raster pipeline do not change at all below an opacity of \
                 {MIN_RASTER_OPACITY}: leave --vs out"
            );
            return Err(Failure::Usage(message));
        }
        let mut row = if case.casters > MAX_LIST {
            if arguments.vs.is_some()
                || arguments.occlude
                || case.shape != ShapeName::Disc
                || arguments.receiver != ReceiverName::Nearest
                || arguments.kernels
            {
                let message = format!(
                    "{case}: more than {MAX_LIST} casters are measured as discs, without --vs, \
                     --occlude, --kernels and curves"
                );
                return Err(Failure::Usage(message));
            }
            shares::run(&bench, case)?
        } else if arguments.occlude {
            bench.run_occlude(case)?
        } else {
            let inputs = of_file.clone().unwrap_or_else(|| {
                let _generating = debug_span!("generate").entered();
                case.inputs()
            });
            bench.run(case, &inputs, arguments.vs.is_some())?
        };
        row.compute.milliseconds = clock.take();
        files::print(&report::line(&row))?;
        report.rows.push(row);
    }
    if let Some(path) = &arguments.json {
        output::write(path, report.json().as_bytes())?;
    }
    if let Some(path) = &arguments.html {
        output::write(path, page::page(&report).as_bytes())?;
    }
    earlier.map_or(Ok(()), |earlier| earlier.compare(&report, arguments.limit))
}
