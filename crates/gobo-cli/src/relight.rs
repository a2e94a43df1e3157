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
use gobo_scene::splats;

/// Kind of a file of splats that is written.
#[derive(Clone, Copy)]
enum Written {
    Ply,
    Spz,
}

pub(crate) fn run(arguments: &RelightArguments) -> Result<(), Failure> {
    let out = &arguments.out;
    let ending = out.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let written = match ending.as_deref() {
        Some("ply") => Written::Ply,
        Some("spz") => Written::Spz,
        _ => {
            let help = "let the name end in .ply or .spz";
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
    let mut missing = vec![true; colors.len()];
    for (gaussian, share) in lit.iter().zip(shares) {
        let i = relit.index_of(gaussian);
        colors[i] *= Vec3::from_array(share);
        missing[i] = false;
    }
    let missing = missing.into_iter().filter(|&is_missing| is_missing).count();
    if missing > 0 {
        tracing::warn!("{missing} splats are too far for the scene: they keep their colours");
    }
    let bytes = match written {
        Written::Ply => splats::to_ply(&cloud.splats, &colors),
        Written::Spz => splats::to_spz(&cloud.splats, &colors)
            .map_err(|error| Failure::refused(out, error.to_string(), "write a .ply instead"))?,
    };
    output::write(out, &bytes)?;
    output::print_name(out)
}
