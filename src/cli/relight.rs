//! `gobo relight`: splats with the light of a scene in their colours.
use super::{
    arguments::RelightArguments,
    failure::Failure,
    files,
    memory::Needs,
    output::{self, Output},
};
use gobo::{
    glam::{DMat2, DVec2, DVec3, Vec3},
    internals::{
        reference::shading::{Lighting, incoming},
        view::shadow_views,
    },
    model::{
        Gaussian, GaussianOpacity, Light, LightKind, Projection, Receiver, ReceiverPoint,
        ShadowFilter, View,
    },
    render::Renderer,
    scene::{self, Scene, splats},
};
use std::f32::consts::FRAC_1_PI;

/// Nodes of the curves, if the scene has none.
const NODES: u32 = 16;

/// Texels around a point of the spline filter, whose splats are looked up [texels].
const TAPS: f64 = 2.2;

/// Points that are looked up at a time.
const MOST_POINTS: usize = 1 << 22;

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
    prepare(&mut scene);
    let lit: Vec<Gaussian> = scene.gaussians[relit.range.clone()].to_vec();
    let points = (lit.len() * scene.lights.len()) as u64;
    Needs { points, ..Needs::of(arguments.moment.device.backend()) }.check(&scene)?;
    let mut renderer = arguments.moment.device.renderer()?;
    tracing::info!("looking light up with {}", renderer.device());
    let shares = shares(&mut renderer, &scene, &lit)?;
    let mut colors: Vec<Vec3> = cloud.splats.iter().map(|splat| splat.color).collect();
    let mut missing = vec![true; colors.len()];
    for (gaussian, share) in lit.iter().zip(shares) {
        let i = relit.index_of(gaussian);
        colors[i] *= share;
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

/// Curves say how much light is left before each splat; the reach of the filter says which texels a splat must not
/// find itself in.
fn prepare(scene: &mut Scene) {
    let shadow = &mut scene.shadow;
    if shadow.receiver != Receiver::Curve {
        (shadow.receiver, shadow.nodes) = (Receiver::Curve, NODES);
    }
    (shadow.blur, shadow.filter) = (0, ShadowFilter::Spline);
    for light in &mut scene.lights {
        light.look_up.filter = None;
    }
}

/// Share of the light that arrives at each splat of what would arrive with nothing between, the scene's ambient
/// light included, as the picture lights particles.
fn shares(renderer: &mut Renderer, scene: &Scene, lit: &[Gaussian]) -> Result<Vec<Vec3>, Failure> {
    let lighting = Lighting::new(scene, &[], &[]);
    let views = shadow_views(scene);
    let ambient = scene.mean_ambient();
    let count = scene.lights.len();
    let mut all = Vec::with_capacity(lit.len());
    for part in lit.chunks((MOST_POINTS / count.max(1).pow(2)).max(1)) {
        let points: Vec<ReceiverPoint> = part
            .iter()
            .flat_map(|gaussian| {
                let opacity = scene.materials[gaussian.material as usize].gaussian;
                let views = &views;
                scene.lights.iter().enumerate().map(move |(index, light)| {
                    let of_light = views.iter().filter(|view| view.light == Some(index));
                    let before = before(gaussian, opacity, light, of_light);
                    ReceiverPoint { position: before + scene.origin, normal: Vec3::ZERO }
                })
            })
            .collect();
        let found = if count > 0 { renderer.light_points(scene, &points)? } else { Vec::new() };
        all.extend(part.iter().enumerate().map(|(i, gaussian)| {
            let (mut open, mut left) = (ambient, ambient);
            for (index, light) in lighting.lights().iter().enumerate() {
                // Isotropic scattering: `PointKind::Particle`.
                let arriving = incoming(light, gaussian.center).1 * (0.25 * FRAC_1_PI);
                open += arriving;
                left += arriving * Vec3::from_array(found[(i * count + index) * count + index]);
            }
            Vec3::select(open.cmpgt(Vec3::ZERO), left / open, Vec3::ONE)
        }));
    }
    Ok(all)
}

/// The point on the way from a splat's centre to the light from which no texel around it finds the splat itself in
/// front. `views`: those of the light.
fn before<'a>(
    gaussian: &Gaussian,
    opacity: GaussianOpacity,
    light: &Light,
    views: impl Iterator<Item = &'a View>,
) -> Vec3 {
    let center = gaussian.center;
    let ray = match light.kind.with_unit_direction() {
        LightKind::Directional { direction } => direction,
        LightKind::Spot { position, .. } | LightKind::Point { position } => {
            (center - position).normalize_or(Vec3::NEG_Y)
        }
    };
    // Edge of a texel at the splat, and the step of depths in curves.
    let (mut texel, mut step) = (0.0_f64, 0.0_f64);
    for view in views {
        let along = f64::from(-view.view_from_world.transform_point3(center).z);
        let spread = match view.projection {
            // Depths are along the axis, and planes of hits are perpendicular to the ray.
            Projection::Perspective => along.max(0.0),
            Projection::Orthographic => 1.0,
        };
        texel = texel.max(spread / f64::from(view.scale));
        step = step.max(f64::from(view.far - view.near) / 65535.0);
    }
    let slack = match light.kind {
        LightKind::Directional { .. } => 2.0 * step,
        LightKind::Spot { .. } | LightKind::Point { .. } => 2.0 * step + TAPS * texel,
    };
    center - ray * (own_reach(gaussian, opacity, ray, texel) + slack) as f32
}

/// How far towards the light a splat's own hits are before its centre, within the filter's texels of `texel` metres:
/// the depth of a hit is its mean over the splat at the hit's place across the ray.
fn own_reach(gaussian: &Gaussian, opacity: GaussianOpacity, ray: Vec3, texel: f64) -> f64 {
    let axes = gaussian.axes().as_dmat3().transpose();
    let [along, x, y] = {
        let ray = ray.as_dvec3().normalize();
        let (x, y) = ray.any_orthonormal_pair();
        [ray, x, y].map(|direction: DVec3| axes * direction)
    };
    let across = DMat2::from_cols(DVec2::new(x.dot(x), x.dot(y)), DVec2::new(x.dot(y), y.dot(y)));
    let slope = across.inverse() * DVec2::new(x.dot(along), y.dot(along));
    let of_slope = slope.dot(DVec2::new(x.dot(along), y.dot(along))).clamp(0.0, along.dot(along));
    let rest = along.dot(along) - of_slope;
    let tilted =
        (f64::from(gaussian.reach(opacity)) * of_slope.sqrt()).min(slope.length() * TAPS * texel);
    let ramp = match opacity {
        // The whole medium: its ramp begins in it.
        GaussianOpacity::Medium { .. } => f64::from(gaussian.reach(opacity)) * rest.max(0.0).sqrt(),
        _ => 0.0,
    };
    // A slope that is not finite is that of a needle along the ray.
    if tilted.is_finite() {
        tilted + ramp
    } else {
        f64::from(gaussian.reach(opacity)) * along.length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gobo::glam::Quat;

    #[test]
    fn a_splat_that_faces_the_light_has_no_reach() {
        let flat = Gaussian { sigma: Vec3::new(1.0, 0.01, 0.5), ..Gaussian::default() };
        let reach = |ray| own_reach(&flat, GaussianOpacity::Splat, ray, 0.1);
        assert!(reach(Vec3::NEG_Y).abs() < 1e-6);
        let medium = GaussianOpacity::Medium { density: 1.0 };
        let whole = 0.01 * f64::from(flat.reach(medium));
        assert!((own_reach(&flat, medium, Vec3::NEG_Y, 0.1) - whole).abs() < 1e-6);
    }

    /// Hits of a pancake of slope 1 are as deep as they are aside.
    #[test]
    fn a_tilted_splat_reaches_as_far_as_the_filter() {
        let turned = Gaussian {
            sigma: Vec3::new(1.0, 1e-4, 1.0),
            rotation: Quat::from_rotation_x(45f32.to_radians()),
            ..Gaussian::default()
        };
        let reach = |texel| own_reach(&turned, GaussianOpacity::Splat, Vec3::NEG_Y, texel);
        assert!((reach(0.01) - TAPS * 0.01).abs() < 1e-5, "{}", reach(0.01));
        // No farther than the splat itself, whose depth deviates by 1/sqrt(2) [m].
        assert!(
            (reach(10.0) - f64::from(turned.reach(GaussianOpacity::Splat)) * 0.5f64.sqrt()).abs()
                < 1e-3
        );
    }
}
