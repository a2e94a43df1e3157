//! Shadow views from lights: maps, cube maps and cascades, and their sizes.
use super::{Projection, Receivers, View, ViewRole, cascades, cover::Cover, importance};
use crate::{
    model::{
        Bounds, Camera, InvalidLight, Light, LightKind, MAX_SHADOWS, MAX_VIEWPOINTS, Scene, Shadow,
    },
    view::{
        atlas::{AtlasLimits, Wish, shrink_to_fit},
        window::{LightBox, stepped},
    },
};
use glam::{Mat3, Mat4, UVec2, Vec2, Vec3};

/// Up vector of a light that looks along `forward` (unit).
pub(super) fn light_up(forward: Vec3) -> Vec3 {
    if forward.y.abs() > 0.99 { Vec3::Z } else { Vec3::Y }
}

/// `view_from_world` of a view that looks along `forward` (unit).
pub(super) fn looking(position: Vec3, forward: Vec3, up: Vec3) -> Mat4 {
    let right = forward.cross(up).normalize();
    let axes = Mat3::from_cols(right, right.cross(forward), -forward).transpose();
    Mat4::from_cols(
        axes.x_axis.extend(0.0),
        axes.y_axis.extend(0.0),
        axes.z_axis.extend(0.0),
        (-(axes * position)).extend(1.0),
    )
}

/// Range of depths along the axis that encloses the box \[m\].
pub(super) fn depth_range(view_from_world: &Mat4, bounds: &Bounds) -> (f32, f32) {
    bounds
        .corners()
        .iter()
        .map(|&c| -view_from_world.transform_point3(c).z)
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(near, far), depth| {
            (near.min(depth), far.max(depth))
        })
}

/// Directions of the faces of a point light's cube, in order of [`ViewRole::Face`].
const CUBE: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

/// Names of the views of a shadow.
struct Names {
    faces: [&'static str; 6],
    /// A whole view, or cascades.
    numbers: [&'static str; 6],
    /// Windows of finer texels.
    details: [&'static str; MOST_DETAILS],
}

/// Most windows of finer texels of a view.
pub(super) const MOST_DETAILS: usize = 6;
/// Number of shadows with names: a light's own, the further ones, and those of its source's other parts.
const NAMED: usize = MAX_SHADOWS + MAX_VIEWPOINTS as usize - 1;

macro_rules! names {
    ($($prefix:literal)*) => {[$(Names {
        faces: [
            concat!($prefix, "px"), concat!($prefix, "nx"), concat!($prefix, "py"),
            concat!($prefix, "ny"), concat!($prefix, "pz"), concat!($prefix, "nz"),
        ],
        numbers: [
            concat!($prefix, "0"), concat!($prefix, "1"), concat!($prefix, "2"),
            concat!($prefix, "3"), concat!($prefix, "4"), concat!($prefix, "5"),
        ],
        details: [
            concat!($prefix, "detail0"), concat!($prefix, "detail1"), concat!($prefix, "detail2"),
            concat!($prefix, "detail3"), concat!($prefix, "detail4"), concat!($prefix, "detail5"),
        ],
    }),*]};
}

#[rustfmt::skip]
const NAMES: [Names; NAMED] = names!(
    "" "s1_" "s2_" "s3_" "p1_" "p2_" "p3_" "p4_" "p5_" "p6_" "p7_" "p8_"
);

/// Index into [`NAMES`] of a shadow of a light; `number`: its index among [`Light::all_shadows`].
fn names_of(light: &Light, number: usize) -> usize {
    let count = light.viewpoint_count() as usize;
    match number {
        0 => 0,
        _ if number < count => MAX_SHADOWS + number - 1,
        _ => number - count + 1,
    }
}

impl View {
    /// Index of its shadow among those of its light; see [`Light::all_shadows`].
    pub fn shadow_index(&self, light: &Light) -> usize {
        let has = |number: usize| {
            let Names { faces, numbers, details } = &NAMES[names_of(light, number)];
            [faces, numbers, details].iter().any(|names| names.contains(&self.name))
        };
        (0..light.all_shadows().count()).find(|&number| has(number)).unwrap_or(0)
    }

    /// Whether it is a window of finer texels, which only pictures have.
    pub fn is_detail(&self) -> bool {
        NAMES.iter().any(|names| names.details.contains(&self.name))
    }
}

/// Names of the windows of finer texels of one of a light's shadows, the finest first; `number`: its index
/// among [`Light::all_shadows`].
pub(super) fn detail_names(light: &Light, number: usize) -> [&'static str; MOST_DETAILS] {
    NAMES[names_of(light, number)].details
}

/// Width over which the border of a further shadow's cone fades out \[share of its half edge\].
const EDGE_FADE: f32 = 0.1;

/// The shadow views of all lights, in order of lights; see [`fitted_views`].
pub fn shadow_views(scene: &Scene) -> Vec<View> {
    fitted_views(scene, &AtlasLimits::CORE).0
}

/// The shadow views of all lights, in order of lights, with maps that fit the scene's texel budget and an
/// atlas of `limits`; and the number of maps that are smaller than requested.
pub fn fitted_views(scene: &Scene, limits: &AtlasLimits) -> (Vec<View>, usize) {
    views_around(scene, limits, &Receivers::default())
}

/// Like [`fitted_views`], with near and far planes that enclose `receivers` as well as the scene's.
pub fn views_around(
    scene: &Scene,
    limits: &AtlasLimits,
    receivers: &Receivers,
) -> (Vec<View>, usize) {
    let cover = Cover::of_scene(scene).around(receivers);
    let mut wishes: Vec<Wish> = Vec::new();
    for (index, light) in scene.lights.iter().enumerate() {
        let usual = importance::usual_size(scene, index);
        for shadow in light.all_shadows() {
            let size = UVec2::splat(shadow.size.unwrap_or(usual));
            let wish = Wish { size, fixed: shadow.size.is_some() };
            wishes.extend(std::iter::repeat_n(wish, shadow.view_count()));
        }
    }
    let shrunk = shrink_to_fit(&mut wishes, &limits.within(scene.shadow.texel_budget));
    let mut views: Vec<View> = Vec::with_capacity(wishes.len());
    for (index, light) in scene.lights.iter().enumerate() {
        let first = views.len();
        let size_of = |i: usize| wishes[first + i].size.x;
        views.extend(views_of(index, light, &size_of, Some(&scene.camera), &cover));
    }
    (views, shrunk)
}

/// The shadow views of one light. `index`: the light's; `size`: edge of its maps \[texels\] if it sets none;
/// `bounds`: of all casters and receivers (world space \[m\]). Without a `camera` to follow, a light has one
/// view of the whole scene instead of cascades.
///
/// # Errors
/// If a number of the light ([`Light::check`]), of the camera or of `bounds` is not finite or out of its
/// range.
pub fn light_views(
    index: usize,
    light: &Light,
    size: u32,
    camera: Option<&Camera>,
    bounds: &Bounds,
) -> Result<Vec<View>, InvalidLight> {
    light.check(index)?;
    let invalid = |problem| InvalidLight { index, problem };
    if bounds.min.is_nan() || bounds.max.is_nan() || !bounds.or_unit().radius().is_finite() {
        return Err(invalid("the box around its casters and receivers must be finite"));
    }
    let of_camera = camera.filter(|_| light.all_shadows().any(|it| it.cascades.is_some()));
    of_camera.and_then(Camera::problem).map_or(Ok(()), |problem| Err(invalid(problem)))?;
    let sizes: Vec<u32> = light
        .all_shadows()
        .flat_map(|s| std::iter::repeat_n(s.size.unwrap_or(size), s.view_count()))
        .collect();
    Ok(views_of(index, light, &|i| sizes[i], camera, &Cover::of_box(bounds.or_unit())))
}

/// `size_of`: edge of the map of each view \[texels\].
fn views_of(
    index: usize,
    light: &Light,
    size_of: &dyn Fn(usize) -> u32,
    camera: Option<&Camera>,
    cover: &Cover<'_>,
) -> Vec<View> {
    let mut views = Vec::with_capacity(light.view_count());
    let mut first = 0;
    let viewpoints = light.viewpoint_count() as usize;
    for (number, mut shadow) in light.all_shadows().enumerate() {
        let size_of = |i: usize| size_of(first + i);
        if viewpoints > 1 && number < viewpoints {
            shadow.kind = wider(shadow.kind, &light.kind, &cover.all);
        }
        // Only a light's own shadows cover all of its light.
        let role = match shadow.kind {
            _ if number < viewpoints => ViewRole::Whole,
            LightKind::Directional { .. } => ViewRole::Window { index: 0, count: 1, fade: 0.0 },
            _ => ViewRole::Window { index: 0, count: 1, fade: EDGE_FADE },
        };
        let owner = Owner { light: index, names: &NAMES[names_of(light, number)], role };
        views.extend(owner.shadow_views(&shadow, &size_of, camera, cover));
        first += shadow.view_count();
    }
    views
}

/// A cone from a point of a light's source, wide enough for the light's own cone within the scene.
fn wider(kind: LightKind, light: &LightKind, bounds: &Bounds) -> LightKind {
    let (LightKind::Spot { position, direction, angle }, LightKind::Spot { position: middle, .. }) =
        (kind, light)
    else {
        return kind;
    };
    let away = (bounds.center() - position).dot(direction.normalize());
    let slope = (angle * 0.5).tan();
    let wider = 1.0 + (position.distance(*middle) / (away * slope).abs().max(1e-6)).min(1.0);
    LightKind::Spot { position, direction, angle: 2.0 * (slope * wider).atan() }
}

/// Light and names of the views being fitted.
struct Owner<'a> {
    light: usize,
    names: &'a Names,
    /// Role of a single view.
    role: ViewRole,
}

impl Owner<'_> {
    fn shadow_views(
        &self,
        shadow: &Shadow,
        size_of: &dyn Fn(usize) -> u32,
        camera: Option<&Camera>,
        cover: &Cover<'_>,
    ) -> Vec<View> {
        let Shadow { near, far, .. } = *shadow;
        let Names { faces, numbers, .. } = self.names;
        match (shadow.kind.with_unit_direction(), shadow.cascades, camera) {
            (LightKind::Directional { direction }, Some(cascades), Some(camera)) => {
                let (light, bounds) = (self.light, &cover.all);
                let fit =
                    cascades::Fit { light, names: numbers, direction, near, far, camera, bounds };
                fit.views(&cascades, size_of)
            }
            (LightKind::Directional { direction }, ..) => {
                vec![self.directional(shadow, size_of(0), direction, cover)]
            }
            (LightKind::Spot { position, direction, angle }, ..) => {
                let view_from_world = looking(position, direction, light_up(direction));
                let base = self.base(numbers[0], self.role, size_of(0), view_from_world);
                vec![perspective(base, shadow, angle, &cover.all)]
            }
            (LightKind::Point { position }, ..) => (0..6)
                .map(|face| {
                    let view_from_world = looking(position, CUBE[face], light_up(CUBE[face]));
                    let role = ViewRole::Face(face as u32);
                    let base = self.base(faces[face], role, size_of(face), view_from_world);
                    perspective(base, shadow, std::f32::consts::FRAC_PI_2, &cover.all)
                })
                .collect(),
        }
    }

    /// A view without depth range and scale.
    fn base(&self, name: &'static str, role: ViewRole, size: u32, view_from_world: Mat4) -> View {
        View {
            light: Some(self.light),
            name,
            role,
            projection: Projection::Perspective,
            size: UVec2::splat(size),
            near: 0.0,
            far: 0.0,
            view_from_world,
            scale: 0.0,
        }
    }

    /// A view fitted to the casters: a square window, with planes that enclose the casters and every receiver
    /// within it. Outside the window there is light. Casters that move leave the texels of others in place
    /// until the window grows by a step.
    fn directional(&self, shadow: &Shadow, size: u32, direction: Vec3, cover: &Cover<'_>) -> View {
        let axes = looking(Vec3::ZERO, direction, light_up(direction));
        let extent = LightBox::new(&axes, &cover.casters);
        let (texel, middle) = extent.window(size);
        let (middle, reach) =
            (middle.as_vec2(), Vec2::splat((texel * f64::from(size) * 0.5) as f32));
        let deepest = cover.deepest(&axes, middle - reach, middle + reach).min(extent.min.z);
        let near = shadow.near.unwrap_or(0.0);
        let front = extent.front(shadow.near.or(shadow.far).is_some());
        let far = shadow.far.unwrap_or_else(|| extent.far(front, deepest, near));
        let shift = Mat4::from_translation(-middle.extend(front));
        let base = self.base(self.names.numbers[0], self.role, size, shift * axes);
        let scale = (1.0 / texel) as f32;
        View { projection: Projection::Orthographic, near, far, scale, ..base }
    }
}

/// Completes a view with its depth range and scale.
fn perspective(mut view: View, shadow: &Shadow, angle: f32, bounds: &Bounds) -> View {
    let (_, deepest) = depth_range(&view.view_from_world, bounds);
    let margin = (bounds.radius() * 0.01).max(1e-4);
    let beyond = shadow.near.map_or(margin, |near| near * 2.0);
    view.far = shadow.far.unwrap_or_else(|| stepped(deepest + margin).max(beyond));
    view.near = shadow.near.unwrap_or(view.far * 1e-4);
    view.scale = view.size.x as f32 * 0.5 / (angle * 0.5).tan();
    view
}
