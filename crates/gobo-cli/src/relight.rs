//! `gobo relight`: splats with the light of a scene in their colours.
use super::{
    arguments::RelightArguments,
    curves,
    failure::Failure,
    files,
    memory::Needs,
    output::{self, Output},
};
use gobo::glam::Vec3;
use gobo_picture::set_to_relight;
use gobo_scene as scene;
use gobo_scene::{
    Relit,
    splats::{self, Harmonics},
};
use std::path::Path;

/// Format of the written file of splats.
#[derive(Clone, Copy)]
enum SplatOutput {
    Ply,
    Sog,
    Spz,
}

pub(crate) fn run(arguments: &RelightArguments) -> Result<(), Failure> {
    let out = &arguments.out;
    let ending = out.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let written = match ending.as_deref() {
        Some("ply") => SplatOutput::Ply,
        Some("sog") => SplatOutput::Sog,
        Some("spz") => SplatOutput::Spz,
        _ => {
            let help = "let the name end in .ply, .spz or .sog";
            return Err(Failure::refused(out, "no kind of splats that gobo writes", help));
        }
    };
    let mut load = scene::LoadOptions::default();
    load.set.clone_from(&arguments.moment.set);
    load.start = false;
    let mut relit = scene::load_with_splats(&arguments.scene, &load, &arguments.splats)?;
    Output::check(out)?;
    let mut scene = std::mem::take(&mut relit.scene);
    let cloud = &relit.cloud;
    if cloud.extinction.is_some() {
        let help = "name splats with opacities";
        return Err(Failure::refused(&arguments.splats, "holds a medium, not splats", help));
    }
    files::warn(&scene.notes);
    scene.set_time(f64::from(arguments.moment.frame) / arguments.moment.fps);
    set_to_relight(&mut scene);
    let lit = &scene.gaussians[relit.range.clone()];
    let points = (lit.len() * scene.lights.len()) as u64;
    Needs { points, ..Needs::of(arguments.moment.device.backend()) }.check(&scene)?;
    let mut renderer = arguments.moment.device.renderer()?;
    tracing::info!("looking light up with {}", renderer.device());
    curves::warn_before(&scene);
    let shares = renderer.relight(&scene, lit)?;
    let mut colors: Vec<Vec3> = cloud.splats.iter().map(|splat| splat.color).collect();
    let mut harmonics = harmonics_of(&arguments.splats, &relit)?;
    let mut missing = vec![true; colors.len()];
    for (gaussian, share) in lit.iter().zip(shares) {
        let i = relit.index_of(gaussian);
        let share = Vec3::from_array(share);
        colors[i] *= share;
        harmonics.scale(i, share);
        missing[i] = false;
    }
    let missing = missing.into_iter().filter(|&is_missing| is_missing).count();
    if missing > 0 {
        tracing::warn!("{missing} splats are too far for the scene: they keep their colours");
    }
    let bytes = match written {
        SplatOutput::Ply => Ok(splats::to_ply(&cloud.splats, &colors, &harmonics)),
        SplatOutput::Sog => splats::to_sog(&cloud.splats, &colors, &harmonics),
        SplatOutput::Spz => splats::to_spz(&cloud.splats, &colors, &harmonics),
    };
    let bytes =
        bytes.map_err(|error| Failure::refused(out, error.to_string(), "write a .ply instead"))?;
    output::write(out, &bytes)?;
    output::print_name(out)
}

/// Higher harmonics of the splats of a file, in their order.
fn harmonics_of(path: &Path, relit: &Relit) -> Result<Harmonics, Failure> {
    let cloud = &relit.cloud;
    if cloud.harmonics == 0 {
        return Ok(Harmonics::default());
    }
    let Some(stored) = relit.harmonics(path)? else {
        tracing::warn!(
            "{}: harmonics of splats that nodes rotate or mirror are not written: the colours of \
             the output are the same from all sides; convert the file to .ply to keep them",
            path.display()
        );
        return Ok(Harmonics::default());
    };
    Ok(if cloud.rows.is_empty() { stored } else { stored.of_rows(&cloud.rows) })
}
