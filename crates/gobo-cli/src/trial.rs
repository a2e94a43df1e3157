//! `gobo info --try`: a small scene rendered by an adapter and by the CPU reference, compared.
use super::{failure::Failure, files, stop, trial_scene::SCENE, values::DeviceArguments};
use gobo::records::ViewMaps;
use gobo_picture::{Frame, RenderOptions, Renderer};
use gobo_scene as scene;
use gobo_scene::Scene;
use serde::Serialize;
use std::{fmt::Write as _, io::Write as _};

/// Difference of light above rounding: some eight times that of software adapters.
const LIGHT: f32 = 4e-3;
/// The same for light depths.
const DEPTH: f32 = 1e-3;
/// The same for a picture's channels [of 255].
const STEPS: f32 = 6.0;
/// Rounding may decide one in this many texels otherwise, at an edge.
const DECIDED: usize = 500;
/// Depths at which curves are compared.
const DEPTHS: u8 = 16;
/// Most wrong texels of a map that are listed.
const NAMED: usize = 4;

#[derive(Debug, Serialize)]
struct TrialReport {
    version: &'static str,
    /// Name, interface and tier.
    adapter: String,
    trusted: bool,
    /// All maps of all views, and the picture.
    compared: Vec<Compared>,
}

/// A map of a view, or the picture.
#[derive(Debug, Serialize)]
struct Compared {
    name: String,
    texels: usize,
    /// Texels that differ by more than rounding.
    apart: usize,
    /// Largest difference.
    worst: f32,
    /// The first of them.
    named: Vec<Texel>,
}

#[derive(Debug, Serialize)]
struct Texel {
    x: usize,
    y: usize,
    found: Vec<f32>,
    expected: Vec<f32>,
}

impl Compared {
    /// `values`: of the adapter and of the reference, `channels` of each texel, row by row.
    fn new(
        name: String,
        width: usize,
        channels: usize,
        limit: f32,
        [found, expected]: [&[f32]; 2],
    ) -> Self {
        let texels = expected.len() / channels;
        let mut all = Self { name, texels, apart: 0, worst: 0.0, named: Vec::new() };
        if found.len() != expected.len() {
            (all.apart, all.worst) = (texels, f32::INFINITY);
            return all;
        }
        let pairs = found.chunks_exact(channels).zip(expected.chunks_exact(channels));
        for (i, (found, expected)) in pairs.enumerate() {
            let differences = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
            // A NaN counts as infinitely far.
            let difference = differences.fold(0.0, |most: f32, difference| {
                if difference.is_nan() { f32::INFINITY } else { most.max(difference) }
            });
            all.worst = all.worst.max(difference);
            if difference > limit {
                all.apart += 1;
                if all.named.len() < NAMED {
                    let (x, y) = (i % width, i / width);
                    let [found, expected] = [found, expected].map(<[f32]>::to_vec);
                    all.named.push(Texel { x, y, found, expected });
                }
            }
        }
        all
    }

    fn is_right(&self) -> bool {
        self.apart <= self.texels / DECIDED
    }
}

/// Prints whether the maps and the picture match the reference's; fails if not.
pub(super) fn run(device: &DeviceArguments, json: bool) -> Result<(), Failure> {
    let mut renderer = device.renderer()?;
    let scene = scene()?;
    let options = RenderOptions { maps: true, ..RenderOptions::default() };
    let found = renderer.render(&scene, &options)?;
    let expected = Renderer::on_cpu().render(&scene, &options)?;
    let compared = compared(&scene, &found, &expected);
    let trusted = compared.iter().all(Compared::is_right);
    let (version, adapter) = (env!("CARGO_PKG_VERSION"), renderer.device());
    let report = TrialReport { version, adapter, trusted, compared };
    if json {
        files::print(&serde_json::to_string_pretty(&report).expect("plain data is JSON"))?;
    } else {
        files::print(text(&report).trim_end())?;
    }
    if trusted {
        return Ok(());
    }
    Err(Failure::Wrong(format!(
        "{} cannot be trusted: try a newer driver, another --adapter, or GOBO_TIER=core; --backend cpu \
         needs none",
        report.adapter
    )))
}

fn scene() -> Result<Scene, Failure> {
    let named = std::env::temp_dir();
    let failed = |source| Failure::file(&named, source);
    let (mut file, _swept) = stop::swept(|| {
        let file = tempfile::Builder::new().prefix("gobo-try-").suffix(".toml").tempfile()?;
        let path = file.path().to_owned();
        Ok((file, path))
    })
    .map_err(failed)?;
    file.write_all(SCENE.as_bytes()).map_err(failed)?;
    Ok(scene::load(file.path())?)
}

fn compared(scene: &Scene, found: &Frame, expected: &Frame) -> Vec<Compared> {
    let mut all = Vec::new();
    for (index, expected) in expected.maps.iter().enumerate() {
        let Some(light) = expected.view.light else { continue };
        let name = format!("{}.{}", scene.lights[light].name, expected.view.name);
        let width = expected.view.size.x as usize;
        let mut add = |map: &str, channels, limit, of: fn(&ViewMaps) -> Vec<f32>| {
            let values = [found.maps.get(index).map(of).unwrap_or_default(), of(expected)];
            let values = [values[0].as_slice(), values[1].as_slice()];
            let name = format!("{name}.{map}");
            all.push(Compared::new(name, width, channels, limit, values));
        };
        add("filter", 3, LIGHT, |maps| maps.filter.as_flattened().to_vec());
        add("nearest", 1, DEPTH, |maps| maps.nearest.clone());
        add("opaque", 1, DEPTH, |maps| maps.opaque.clone());
        add("curve", 3 * usize::from(DEPTHS), LIGHT, |maps| {
            let Some(curve) = &maps.curve else { return Vec::new() };
            let depths = (0..DEPTHS).map(|i| (f32::from(i) + 0.5) / f32::from(DEPTHS));
            let light =
                |texel| depths.clone().flat_map(move |z| curve.light_at(texel, z).to_array());
            (0..curve.texel_count()).flat_map(light).collect()
        });
    }
    let steps = |frame: &Frame| -> Vec<f32> {
        frame.picture.rgb.as_flattened().iter().copied().map(f32::from).collect()
    };
    let (found, width) = (steps(found), expected.picture.size.x as usize);
    let values = [found.as_slice(), &steps(expected)];
    all.push(Compared::new("picture".to_owned(), width, 3, STEPS, values));
    all
}

fn text(report: &TrialReport) -> String {
    let mut text = format!("tried {}\n", report.adapter);
    for compared in report.compared.iter().filter(|compared| compared.apart > 0) {
        let Compared { name, texels, apart, worst, .. } = compared;
        // Writing to a string does not fail.
        let _ = writeln!(text, "  {name}: {apart} of {texels} texels apart, by up to {worst}");
        for Texel { x, y, found, expected } in &compared.named {
            let _ = writeln!(text, "    ({x}, {y}) is {found:?} instead of {expected:?}");
        }
    }
    let wrong = report.compared.iter().filter(|compared| !compared.is_right()).count();
    let (all, version) = (report.compared.len(), report.version);
    let _ = if report.trusted {
        writeln!(
            text,
            "all {all} maps and pictures are those of the CPU reference of gobo {version}"
        )
    } else {
        writeln!(text, "{wrong} of {all} maps and pictures are not those of the CPU reference")
    };
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apart(change: impl Fn(&mut Vec<f32>)) -> Compared {
        let expected: Vec<f32> = (0..3000_u16).map(|i| f32::from(i) / 3000.0).collect();
        let mut found = expected.clone();
        change(&mut found);
        Compared::new("sun.0.filter".to_owned(), 40, 3, LIGHT, [&found, &expected])
    }

    #[test]
    fn what_differs_is_named() {
        assert_eq!(apart(|_| ()).apart, 0);
        let rounded = apart(|found| found.iter_mut().for_each(|value| *value += 1e-3));
        assert!(rounded.is_right() && rounded.worst > 9e-4);
        let edges = apart(|found| [0, 299].iter().for_each(|&i| found[i] += 0.5));
        assert!(edges.apart == 2 && edges.is_right());
        let wrong = apart(|found| [0, 299, 2000].iter().for_each(|&i| found[i] += 0.5));
        assert!(wrong.apart == 3 && !wrong.is_right());
        let named: Vec<_> = wrong.named.iter().map(|texel| [texel.x, texel.y]).collect();
        assert_eq!(named, [[0, 0], [19, 2], [26, 16]]);
        let nan = apart(|found| found[5] = f32::NAN);
        assert!(nan.apart == 1 && nan.worst == f32::INFINITY);
        assert!(!apart(|found| found.truncate(9)).is_right());
        assert!(!apart(Vec::clear).is_right());
    }
}
