//! Light that arrives at splats, which are casters themselves: for their colours.
use super::Renderer;
use glam::{DMat2, DVec2, DVec3, Vec3};
use gobo::{
    Error,
    model::{
        Gaussian, GaussianOpacity, Light, LightKind, Projection, Receiver, ReceiverPoint, Scene,
        ShadowFilter, View,
    },
    records::{CASTER_BIAS, LARGEST_BIAS},
    view::shadow_views,
};
use gobo_reference::shading::{Lighting, incoming};
use std::f32::consts::FRAC_1_PI;

/// Fewest nodes of the curves.
const NODES: u32 = 16;

/// Reach of the spline filter around a point whose splats are looked up \[texels\].
const TAPS: f64 = 2.2;

/// Most points that are looked up at once.
const MOST_POINTS: usize = 1 << 22;

/// Sets the shadows of a scene so that [`Renderer::relight`] tells casters before a splat from those behind
/// it: curves give the light left before each splat, and the filter's reach the texels in which a splat must
/// not find itself.
pub fn set_to_relight(scene: &mut Scene) {
    let shadow = &mut scene.shadow;
    (shadow.receiver, shadow.nodes) = (Receiver::Curve, shadow.nodes.max(NODES));
    (shadow.blur, shadow.filter) = (0, ShadowFilter::Spline);
    for light in &mut scene.lights {
        light.look_up.filter = None;
    }
}

impl Renderer {
    /// Light that arrives at each splat, as a share of the light that would arrive with nothing between,
    /// including the scene's ambient light, as the picture lights particles: linear rgb, splat by splat.
    /// `lit`: splats of the scene, after [`set_to_relight`].
    ///
    /// # Errors
    /// Those of [`Self::light_points`].
    pub fn relight(&mut self, scene: &Scene, lit: &[Gaussian]) -> Result<Vec<[f32; 3]>, Error> {
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
                        let bias = light.look_up.bias.or(scene.shadow.bias);
                        let before = before(gaussian, opacity, light, bias, of_light);
                        ReceiverPoint { position: before + scene.origin, normal: Vec3::ZERO }
                    })
                })
                .collect();
            let found = if count > 0 { self.light_points(scene, &points)? } else { Vec::new() };
            all.extend(part.iter().enumerate().map(|(i, gaussian)| {
                let (mut open, mut left) = (ambient, ambient);
                for (index, light) in lighting.lights().iter().enumerate() {
                    // Isotropic scattering: `PointKind::Particle`.
                    let arriving = incoming(light, gaussian.center).1 * (0.25 * FRAC_1_PI);
                    open += arriving;
                    left += arriving * Vec3::from_array(found[(i * count + index) * count + index]);
                }
                Vec3::select(open.cmpgt(Vec3::ZERO), left / open, Vec3::ONE).to_array()
            }));
        }
        Ok(all)
    }
}

/// The point on the way from a splat's centre to the light from which no texel around it finds the splat in
/// front, nor, where no bias is stated, a neighbour that overlaps it. `views`: those of the light.
fn before<'a>(
    gaussian: &Gaussian,
    opacity: GaussianOpacity,
    light: &Light,
    bias: Option<f32>,
    views: impl Iterator<Item = &'a View>,
) -> Vec3 {
    let center = gaussian.center;
    let ray = match light.kind.with_unit_direction() {
        LightKind::Directional { direction } => direction,
        LightKind::Spot { position, .. } | LightKind::Point { position } => {
            (center - position).normalize_or(Vec3::NEG_Y)
        }
    };
    // Edge of a texel at the splat, and the depth range.
    let (mut texel, mut range) = (0.0_f64, 0.0_f64);
    for view in views {
        let along = f64::from(-view.view_from_world.transform_point3(center).z);
        let spread = match view.projection {
            // Depths are along the axis, and planes of hits are perpendicular to the ray.
            Projection::Perspective => along.max(0.0),
            Projection::Orthographic => 1.0,
        };
        texel = texel.max(spread / f64::from(view.scale));
        range = range.max(f64::from(view.far - view.near));
    }
    let step = range / 65535.0;
    let slack = match light.kind {
        LightKind::Directional { .. } => 2.0 * step,
        LightKind::Spot { .. } | LightKind::Point { .. } => 2.0 * step + TAPS * texel,
    };
    let beside = match bias {
        Some(_) => 0.0,
        None => (f64::from(CASTER_BIAS) * texel).min(f64::from(LARGEST_BIAS) * range),
    };
    center - ray * (own_reach(gaussian, opacity, ray, texel) + slack + beside) as f32
}

/// Largest distance towards the light by which a splat's own hits precede its centre, within the filter's
/// texels of `texel` metres: the depth of a hit is the splat's mean depth at the hit's place across the ray.
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
        // The ramp of a medium begins inside it.
        GaussianOpacity::Medium { .. } => f64::from(gaussian.reach(opacity)) * rest.max(0.0).sqrt(),
        _ => 0.0,
    };
    // An infinite slope or NaN belongs to a needle along the ray.
    if tilted.is_finite() {
        tilted + ramp
    } else {
        f64::from(gaussian.reach(opacity)) * along.length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

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
