//! `gobo render`: frames, maps, and their costs.
use super::{
    arguments::{RenderArguments, SimulationName},
    exr,
    failure::Failure,
    files, maps,
    memory::Needs,
    preview::Preview,
    sidecar::{self, Sidecar},
    stop,
};
use gobo::{
    gpu::Backend,
    model::Counters,
    records::Picture,
    render::{Frame, RenderOptions, Renderer},
    scene,
};
use image::{DynamicImage, RgbImage};
use indicatif::{ProgressBar, ProgressStyle};
use serde::{Serialize, Serializer};
use std::path::Path;

/// One line of `--json`.
#[derive(Serialize)]
struct Report<'a> {
    frame: u32,
    picture: std::borrow::Cow<'a, str>,
    #[serde(flatten)]
    counters: &'a Counters,
    /// Stage and its time [ms].
    #[serde(serialize_with = "as_map")]
    stages: &'a [(&'static str, f64)],
    /// Buffer or texture and its size [bytes].
    #[serde(serialize_with = "as_map")]
    bytes: &'a [(&'static str, u64)],
    /// Sum over all buffers and textures.
    peak_bytes: u64,
}

pub(crate) fn run(arguments: &RenderArguments) -> Result<(), Failure> {
    if arguments.backend() == Backend::Cpu && !arguments.debug().is_empty() {
        let message = "--debug needs an adapter: leave --backend cpu out";
        return Err(Failure::Usage(message.to_owned()));
    }
    if arguments.backend() == Backend::Cpu && arguments.simulation == SimulationName::Device {
        let message = "--simulation device needs an adapter: leave --backend cpu out";
        return Err(Failure::Usage(message.to_owned()));
    }
    let is_scene_file = arguments.scene.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    if arguments.no_ground && is_scene_file {
        let message = "--no-ground is for models and particle files: remove it, or the shape that \
                       is the ground of the scene file";
        return Err(Failure::Usage(message.to_owned()));
    }
    let mut load = scene::LoadOptions::default();
    load.set.clone_from(&arguments.set);
    load.ground = !arguments.no_ground;
    load.emitters = false;
    let mut scene = scene::load_as(&arguments.scene, &load)?;
    files::warn(&scene.notes);
    Needs { maps: arguments.maps, picture: true, ..Needs::of(arguments.backend()) }
        .check(&scene)?;
    let mut renderer = Renderer::new(arguments.backend(), arguments.adapter.as_deref())?;
    leave_to_device(&mut scene, &renderer, arguments.simulation);
    let debug = arguments.debug();
    let options = RenderOptions {
        maps: arguments.maps,
        maps_of: None,
        keep: true,
        light: arguments.exr,
        debug: &debug,
        maps_only: false,
    };
    tracing::info!("rendering with {}", renderer.device());
    let light_names = if arguments.maps { maps::light_names(&scene.lights) } else { Vec::new() };
    files::create_dir(&arguments.out)?;

    let inputs = arguments.skip_existing.then(|| sidecar::inputs(&scene, arguments));
    stop::listen()?;
    let frames = arguments.frames();
    let (mut shrunk, mut unmasked) = (0, 0);
    let mut preview = match &arguments.preview {
        Some(path) => Some(Preview::new(path, scene.camera.size, frames.len(), arguments.fps)?),
        None => None,
    };
    let progress = progress_bar(frames.len() as u64);
    for index in frames {
        if stop::is_stopped() {
            return Err(Failure::Stopped { frame: index });
        }
        if let Some(inputs) = &inputs
            && Sidecar::read(&arguments.out, index)
                .is_some_and(|sidecar| sidecar.holds(&arguments.out, inputs))
        {
            let picture = arguments.out.join(format!("frame_{index:04}.png"));
            if let Some(preview) = &mut preview {
                preview.add_file(&picture)?;
            }
            let line = if arguments.json {
                kept_json(index, &picture)
            } else {
                picture.display().to_string()
            };
            progress.suspend(|| files::print(&line))?;
            progress.inc(1);
            continue;
        }
        scene.set_time(f64::from(index) / arguments.fps);
        let frame = renderer.render(&scene, &options)?;
        shrunk = shrunk.max(frame.counters.shrunk);
        unmasked = unmasked.max(frame.counters.unmasked_lights);
        let picture = arguments.out.join(format!("frame_{index:04}.png"));
        if arguments.maps {
            let dir = arguments.out.join("maps").join(format!("frame_{index:04}"));
            maps::write(&dir, &frame.maps, &scene.lights, &light_names, scene.origin)?;
        }
        for (mode, image) in &frame.debug {
            let path = arguments.out.join(format!("frame_{index:04}.{}.png", mode.name()));
            files::write(&path, &maps::png(&image_of(image)))?;
        }
        if arguments.exr {
            let path = arguments.out.join(format!("frame_{index:04}.exr"));
            files::write(&path, &exr::encode(&path, &frame.picture)?)?;
        }
        if let Some(preview) = &mut preview {
            preview.add(&frame.picture)?;
        }
        // Last, so that a picture implies that its frame is complete.
        files::write(&picture, &maps::png(&image_of(&frame.picture)))?;
        if let Some(inputs) = &inputs {
            Sidecar::write(&arguments.out, index, arguments.all_frames(), inputs)?;
        }
        let line = if arguments.json {
            json(index, &picture, &frame)
        } else {
            picture.display().to_string()
        };
        progress.suspend(|| files::print(&line))?;
        progress.inc(1);
    }
    progress.finish_and_clear();
    if let (Some(preview), Some(path)) = (preview, &arguments.preview) {
        preview.finish()?;
        if !arguments.json {
            files::print(&path.display().to_string())?;
        }
    }
    if shrunk > 0 {
        tracing::warn!(
            "{shrunk} shadow maps are smaller than they should be: the atlas is full; use a \
             smaller size for some lights, or a larger texel_budget of [shadow]"
        );
    }
    if unmasked > 0 {
        tracing::warn!(
            "{unmasked} lights are shaded without a mask: all are taken; raise the limit of [mask], or \
             give lights a far"
        );
    }
    let skipped = &scene.skipped;
    if !skipped.is_empty() {
        let reasons: Vec<_> =
            skipped.iter().map(|(reason, count)| format!("{count} {reason}")).collect();
        tracing::warn!("left out: {}", reasons.join(", "));
    }
    Ok(())
}

/// Leaves emitters to the adapter, and says which it cannot simulate.
fn leave_to_device(scene: &mut scene::Scene, renderer: &Renderer, simulation: SimulationName) {
    let is_wanted = match simulation {
        SimulationName::Auto => !renderer.is_software(),
        SimulationName::Device => true,
        SimulationName::Cpu => false,
    };
    if let Some(most) = renderer.most_simulated().filter(|_| is_wanted) {
        files::warn(&scene.simulate_on_device(most));
    }
}

/// Progress bar on standard error, hidden unless that is a terminal.
fn progress_bar(frame_count: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:30} frame {pos}/{len} ({eta} left)");
    ProgressBar::new(frame_count).with_style(style.expect("the template is valid"))
}

fn image_of(picture: &Picture) -> DynamicImage {
    let bytes = picture.rgb.as_flattened().to_vec();
    let image = RgbImage::from_raw(picture.size.x, picture.size.y, bytes);
    DynamicImage::from(image.expect("a picture has all its pixels"))
}

fn json(index: u32, picture: &Path, frame: &Frame) -> String {
    let report = Report {
        frame: index,
        picture: picture.to_string_lossy(),
        counters: &frame.counters,
        stages: &frame.stages,
        bytes: &frame.memory,
        peak_bytes: frame.memory.iter().map(|&(_, bytes)| bytes).sum(),
    };
    serde_json::to_string(&report).expect("plain data is JSON")
}

/// JSON entry of a frame that was skipped because it exists.
fn kept_json(index: u32, picture: &Path) -> String {
    let picture = picture.to_string_lossy();
    serde_json::json!({ "frame": index, "picture": picture, "kept": true }).to_string()
}

/// Serializes entries in order; values of equal names are added.
pub(super) fn as_map<T, S>(entries: &[(&'static str, T)], serializer: S) -> Result<S::Ok, S::Error>
where
    T: Copy + Serialize + std::ops::AddAssign,
    S: Serializer,
{
    let mut sums: Vec<(&str, T)> = Vec::with_capacity(entries.len());
    for &(name, value) in entries {
        match sums.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => *sum += value,
            None => sums.push((name, value)),
        }
    }
    serializer.collect_map(sums)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_has_every_figure() {
        let frame = Frame {
            picture: Picture { size: glam::UVec2::ONE, rgb: vec![[0; 3]], light: Vec::new() },
            debug: Vec::new(),
            maps: Vec::new(),
            counters: Counters { pairs: 7, skipped: [("radius", 2)].into(), ..Default::default() },
            stages: vec![("sort", 1.5), ("bin", 1.0), ("sort", 0.5)],
            memory: vec![("pairs", 56), ("sums", 8)],
        };
        let line = json(3, Path::new("out/frame_0003.png"), &frame);
        assert!(!line.contains('\n'));
        let value: serde_json::Value = serde_json::from_str(&line).unwrap();
        assert_eq!(value["frame"], 3);
        assert_eq!(value["picture"], "out/frame_0003.png");
        assert_eq!(value["pairs"], 7);
        assert_eq!(value["skipped"]["radius"], 2);
        assert_eq!(value["stages"], serde_json::json!({ "sort": 2.0, "bin": 1.0 }));
        assert_eq!(value["bytes"], serde_json::json!({ "pairs": 56, "sums": 8 }));
        assert_eq!(value["peak_bytes"], 64);
        for name in [
            "casters",
            "views_rendered",
            "views_kept",
            "culled",
            "hidden",
            "visible",
            "segments",
            "scattered",
            "overflowed",
            "shrunk",
            "cluster_lights",
            "clusters_overflowed",
            "masks",
            "unmasked_lights",
        ] {
            assert_eq!(value[name], 0, "{name}");
        }
    }
}
