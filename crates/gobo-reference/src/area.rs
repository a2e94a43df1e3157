//! Area lights by definition: the light at a receiver is the mean over points of the light's surface. Each
//! point has hard shadow maps of its own; one point of each light is evaluated at a time.
use super::maps::SceneRecords;
use glam::Vec3;
use gobo::{
    model::{Counters, Light, LightKind, Scene, Shadow, Source, View},
    records::ViewMaps,
};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Points of an area light, the same for all receivers. The share of a disc that a straight edge covers is
/// off by 0.010 on average over directions and distances, and by 0.046 at most; of a sphere by 0.014 and
/// 0.071.
pub(super) const POINTS: usize = 64;
/// Fraction of the golden ratio.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Fits shadow views to the lights of a scene.
pub type Fit<'a> = &'a dyn Fn(&Scene) -> Vec<View>;

/// Lights as one point each, and the shadow maps of these points.
#[derive(Clone, Debug)]
pub(super) struct LightPoints<'a> {
    pub lights: Vec<Light>,
    pub views: Vec<View>,
    pub maps: Vec<&'a ViewMaps>,
}

impl<'a> LightPoints<'a> {
    /// The scene's lights, reduced to their centres.
    pub(super) fn centers(scene: &Scene, views: &[View], maps: &'a [ViewMaps]) -> Self {
        let maps = maps.iter().collect();
        Self { lights: scene.lights.clone(), views: views.to_vec(), maps }
    }
}

/// Mean of `evaluate` over the points of all area lights, one point of each at a time; `maps` of `views`:
/// those of the lights' centres.
pub(super) fn mean_over_points(
    scene: &Scene,
    views: &[View],
    maps: &[ViewMaps],
    fit: Fit<'_>,
    evaluate: impl Fn(&LightPoints<'_>) -> Vec<Vec3>,
) -> Vec<Vec3> {
    let has_area = |view: &View| view.light.is_some_and(|i| scene.lights[i].area().is_some());
    if !views.iter().any(has_area) {
        return evaluate(&LightPoints::centers(scene, views, maps));
    }
    let records = SceneRecords::new(scene.casters(), &scene.shadow.within_curve_budget(views));
    let is_window = |view: &View| has_area(view) && view.is_detail();
    let is_kept = |view: &View| !is_of_viewpoint(view, scene) && !is_window(view);
    let (views, maps): (Vec<_>, Vec<_>) =
        views.iter().cloned().zip(maps).filter(|(view, _)| is_kept(view)).unzip();
    let mut moved = scene.clone();
    moved.lights.iter_mut().for_each(|light| light.viewpoints = 1);
    let centers = LightPoints { lights: moved.lights.clone(), views, maps };
    let (views, lights) = (&centers.views, &centers.lights);
    let mut sum = Vec::new();
    for i in 0..POINTS {
        let lights = (0..).zip(lights);
        moved.lights =
            lights.map(|(index, light)| light_at(light, index, scene, views, i)).collect();
        let mut points = LightPoints { lights: moved.lights.clone(), ..centers.clone() };
        let fitted = fit(&moved);
        let same = |view: &View| {
            fitted.iter().find(|fitted| (fitted.light, fitted.name) == (view.light, view.name))
        };
        let soft = (0..views.len()).filter(|&k| has_area(&views[k]));
        let soft: Vec<(usize, &View)> = soft.filter_map(|k| Some((k, same(&views[k])?))).collect();
        let mut counters = Counters::default();
        let rendered: Vec<_> =
            soft.iter().map(|(_, view)| records.render(view, &mut counters)).collect();
        for (&(k, view), maps) in soft.iter().zip(&rendered) {
            (points.views[k], points.maps[k]) = (view.clone(), maps);
        }
        let light = evaluate(&points);
        sum.resize(light.len(), Vec3::ZERO);
        sum.iter_mut().zip(light).for_each(|(sum, light)| *sum += light);
    }
    sum.iter().map(|sum| *sum / POINTS as f32).collect()
}

/// Whether a view belongs to a viewpoint beyond the first.
fn is_of_viewpoint(view: &View, scene: &Scene) -> bool {
    view.light.is_some_and(|index| {
        let light = &scene.lights[index];
        (1..light.viewpoint_count() as usize).contains(&view.shadow_index(light))
    })
}

/// A light, or point `i` of an area light.
fn light_at(light: &Light, index: usize, scene: &Scene, views: &[View], i: usize) -> Light {
    let Some(source) = light.area() else { return light.clone() };
    let kind = |kind: LightKind| kind_at(kind.with_unit_direction(), &source, i);
    let mut sizes = views.iter().filter(|view| view.light == Some(index)).map(|view| view.size.x);
    let mut shadows: Vec<Shadow> = light.all_shadows().collect();
    for shadow in &mut shadows {
        shadow.kind = kind(shadow.kind);
        shadow.size = sizes.by_ref().take(shadow.view_count()).max();
    }
    let mut first = shadows.remove(0);
    if let (LightKind::Spot { position, direction, angle }, Some(size)) = (first.kind, first.size) {
        // As wide as the whole light's cone at the scene's distance.
        let away = (scene.held_bounds().center() - position).dot(direction.normalize());
        let slope = (angle * 0.5).tan();
        let wider = 1.0 + (radius(&source) / (away * slope).abs().max(1e-6)).min(1.0);
        let angle = 2.0 * (slope * wider).atan();
        first.kind = LightKind::Spot { position, direction, angle };
        first.size = Some((size as f32 * wider).ceil() as u32);
    }
    Light { kind: first.kind, size: first.size, shadows, ..light.clone() }
}

/// Radius of a sphere around the source \[m\].
fn radius(source: &Source) -> f32 {
    match *source {
        Source::Sphere { radius } | Source::Disc { radius, .. } => radius,
        Source::Rect { width, height, .. } => 0.5 * width.hypot(height),
        Source::Sun { .. } => 0.0,
    }
}

/// The position or, for a sun, the direction of point `i` of a light.
fn kind_at(kind: LightKind, source: &Source, i: usize) -> LightKind {
    let offset = offset(source, i);
    match kind {
        LightKind::Directional { direction } => {
            let (right, up) = direction.any_orthonormal_pair();
            let direction = direction + right * offset.x + up * offset.y;
            LightKind::Directional { direction: direction.normalize() }
        }
        LightKind::Spot { position, direction, angle } => {
            LightKind::Spot { position: position + offset, direction, angle }
        }
        LightKind::Point { position } => LightKind::Point { position: position + offset },
    }
}

/// Offset of point `i` of a source from its centre, world space \[m\]; for a sun a slope along its first two
/// axes.
fn offset(source: &Source, i: usize) -> Vec3 {
    // A Fibonacci lattice, with a third coordinate for spheres.
    let u = (i as f32 + 0.5) / POINTS as f32;
    let v = (i as f64 * GOLDEN).fract() as f32;
    let w = (0.5 + i as f64 * std::f64::consts::SQRT_2).fract() as f32;
    let (sine, cosine) = (TAU * v).sin_cos();
    let [right, up] = source.half_axes();
    match source {
        Source::Disc { .. } => u.sqrt() * (right * cosine + up * sine),
        // The axes are its edges divided by the root of 3.
        Source::Rect { .. } => 3f32.sqrt() * (right * (u - 0.5) + up * (v - 0.5)),
        Source::Sun { .. } => right.x * u.sqrt() * Vec3::new(cosine, sine, 0.0),
        // A sphere appears as a disc from everywhere: each projection of a ball with density 1 / sqrt(1 -
        // r^2) at radius r has even density (by Abel's transform).
        Source::Sphere { .. } => {
            let (height, out) = (2.0 * u - 1.0, 2.0 * (u * (1.0 - u)).sqrt());
            right.x * ball_radius(w) * Vec3::new(out * cosine, out * sine, height)
        }
    }
}

/// Radius that encloses a share of a unit ball with density 1 / sqrt(1 - r^2).
fn ball_radius(share: f32) -> f32 {
    // With r = sin t, the share is (2 t - sin 2 t) / pi.
    let (mut low, mut high) = (0.0_f32, FRAC_PI_2);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        let inside = (2.0 * middle - (2.0 * middle).sin()) / (2.0 * FRAC_PI_2);
        (low, high) = if inside < share { (middle, high) } else { (low, middle) };
    }
    low.sin()
}
