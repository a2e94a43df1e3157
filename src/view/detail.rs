//! Windows of finer texels where the picture shows edges of shadows in coarse ones.
//!
//! Two small pictures of the triangles, as the camera and as the light sees them, say where edges of shadows may be
//! seen, and how wide a texel may be there to be no wider than a pixel. What they miss has the texels of the light's
//! own map. Windows move by whole texels and grow in steps, as all windows do.
use super::{
    Projection, View, ViewRole,
    atlas::{Atlas, AtlasLimits},
    fit::{depth_range, fitted_views, light_up, looking},
    raster::{Image, Nearest, Raster},
    window::{rounded_up, snapped, stepped},
};
use crate::model::{Light, LightKind, Material, Scene, ShadowFilter, Transfer};
use glam::{DMat2, DVec2, DVec3, IVec2, Mat4, UVec2, Vec3};

/// Names of the windows, the finest first.
const NAMES: [&str; 6] = ["detail0", "detail1", "detail2", "detail3", "detail4", "detail5"];
/// Pixels of the picture to one of the small picture, each way.
const COARSE: u32 = 8;
/// Edge of the small map [texels].
const MAP: u32 = 512;
/// Least factor between the texels of a light's own map and those of a window.
const FINER: f64 = 1.2;
/// Windows that are tried, by half octaves of what their places need.
const LIMITS: i32 = 14;
/// Places that are asked what a window brings.
const ASKED: usize = 1000;
/// What a window of [`LARGEST`] texels a side must bring: mean square of the share by which texels are too wide.
const PRICE: f64 = 0.003;
/// Share of that price for a window of few texels.
const FIXED: f64 = 0.1;
/// Texels of a light's windows, in windows of [`LARGEST`] a side.
const MOST_TEXELS: f64 = 4.0;
/// Edge of the largest window [texels].
const LARGEST: u32 = 2048;
/// How often places are halved, to try windows of their own around the halves.
const HALVINGS: u32 = 3;
/// Width of a texel that is narrow enough [pixels].
const FINENESS: f64 = 0.6;
/// Largest such share.
const MOST_EXCESS: f64 = 8.0;
/// Places to one that is left coarser than it needs.
const FEW: usize = 32;
/// Steps of an octave of a window's texels.
const FINE_STEPS: f64 = 16.0;
/// Texels of the small map within which an edge is looked for.
const EDGES: i32 = 2;
/// Most lights that have windows.
const MOST_LIGHTS: usize = 4;
/// Steps of an octave in which windows grow.
const STEPS: f64 = 4.0;
/// Least places that a window is made for.
const LEAST: usize = 6;
/// Share of a window's half edge over which it fades.
const FADE: f32 = 0.05;
/// Border on each side of a window: a texel of filtering, the spline's half and half a texel of snapping [texels].
const BORDER: f64 = 3.0;
/// Sizes of windows [texels].
const SIZES: [u32; 9] = [128, 192, 256, 384, 512, 768, 1024, 1536, LARGEST];
/// Sizes that windows of curves have: up to 1024 texels.
const WITH_CURVES: usize = 7;
/// Least cosine at which a surface is measured.
const MIN_COSINE: f64 = 0.1;

impl View {
    /// Whether it is a window of finer texels, which only pictures have.
    pub fn is_detail(&self) -> bool {
        NAMES.contains(&self.name)
    }
}

/// A place of the picture beside an edge of a shadow.
#[derive(Clone, Copy)]
struct Seen {
    /// On the light's plane: [m], or in a perspective view at 1 m along the axis.
    place: DVec2,
    /// Widest texel there that is narrow enough, in the same unit.
    texel: f64,
}

/// [`fitted_views`], and windows of finer texels before those of lights that they are for, if the scene's settings ask for
/// them.
pub fn picture_views(scene: &Scene, limits: &AtlasLimits) -> (Vec<View>, usize) {
    let (bases, shrunk) = fitted_views(scene, limits);
    if !scene.shadow.detail || !bases.iter().any(|base| has_windows(scene, base)) {
        return (bases, shrunk);
    }
    let picture = Picture::new(scene);
    let limits = limits.within(scene.shadow.texel_budget);
    let mut views: Vec<View> = Vec::with_capacity(bases.len());
    let mut rest = MOST_LIGHTS;
    for (index, base) in bases.iter().enumerate() {
        if rest > 0 && has_windows(scene, base) {
            rest -= 1;
            let first = views.len();
            views.extend(windows(scene, &picture, base));
            let sizes: Vec<_> = views.iter().chain(&bases[index..]).map(|view| view.size).collect();
            if Atlas::pack(&sizes, &limits).is_none() {
                views.truncate(first);
            }
        }
        views.push(base.clone());
    }
    (views, shrunk)
}

/// Whether a view is one that windows refine. Filters and blurs that are texels wide are as wide as their user chose.
fn has_windows(scene: &Scene, base: &View) -> bool {
    let Some(light) = base.light.map(|index| &scene.lights[index]) else { return false };
    let shadow = &scene.shadow;
    let filter = light.look_up.filter.unwrap_or(shadow.filter);
    let is_narrow =
        matches!(filter, ShadowFilter::None | ShadowFilter::Bilinear | ShadowFilter::Spline);
    let is_cone = matches!(light.kind, LightKind::Spot { .. }) && light.near.is_none();
    let is_sun = matches!(light.kind, LightKind::Directional { .. });
    is_narrow
        && shadow.blur == 0
        && !shadow.soften
        && !shadow.colored
        && base.role == ViewRole::Whole
        && light.area().is_none()
        && (is_cone || is_sun)
}

/// Windows for `base`, the finest first: one by one those by which texels come closest to what places need.
fn windows(scene: &Scene, picture: &Picture<'_>, base: &View) -> Vec<View> {
    let mut seen = picture.places(base);
    seen.sort_by(|a, b| a.texel.total_cmp(&b.texel));
    let coarsest = 1.0 / f64::from(base.scale);
    let sizes = if scene.shadow.curve_nodes() == 0 { &SIZES[..] } else { &SIZES[..WITH_CURVES] };
    let limits = (0..LIMITS).map(|i| coarsest * (-0.5 * f64::from(i)).exp2());
    let counts = limits.map(|limit| seen.partition_point(|seen| seen.texel < limit));
    let counts = counts.filter(|&count| count >= LEAST);
    let parts = counts.flat_map(|count| in_parts(seen[..count].to_vec(), HALVINGS));
    let wishes: Vec<Window> =
        parts.filter_map(|part| Window::around(&part, sizes, coarsest)).collect();
    let asked: Vec<Seen> = seen.iter().step_by(seen.len() / ASKED + 1).copied().collect();
    let price = PRICE * asked.len() as f64;
    let mut chosen: Vec<&Window> = Vec::new();
    let mut least = excess(&asked, &chosen, coarsest);
    while chosen.len() < NAMES.len() {
        let with = |window| [&chosen[..], &[window]].concat();
        let left = MOST_TEXELS - chosen.iter().map(|window| window.area()).sum::<f64>();
        let small = wishes.iter().filter(|window| window.area() <= left);
        // What a window brings, for its share of texels.
        let gains = small.map(|window| {
            let cost = excess(&asked, &with(window), coarsest);
            (least - cost - price * (FIXED + window.area()), cost, window)
        });
        let best = gains.max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, cost, window)) = best.filter(|&(gain, ..)| gain > 0.0) else { break };
        chosen.push(window);
        least = cost;
    }
    chosen.sort_by(|a, b| a.texel.total_cmp(&b.texel));
    let count = chosen.len() as u32;
    (0..)
        .zip(chosen)
        .map(|(index, window)| {
            let role = ViewRole::Window { index, count: count + 1, fade: FADE };
            View { name: NAMES[index as usize], role, ..window.view(scene, base) }
        })
        .collect()
}

/// Places together, and those of the halves of their box, of the halves' halves, and so on.
fn in_parts(seen: Vec<Seen>, halvings: u32) -> Vec<Vec<Seen>> {
    if halvings == 0 || seen.len() < 2 * LEAST {
        return vec![seen];
    }
    let low = seen.iter().fold(DVec2::INFINITY, |low, seen| low.min(seen.place));
    let high = seen.iter().fold(DVec2::NEG_INFINITY, |high, seen| high.max(seen.place));
    let (size, middle) = (high - low, (low + high) * 0.5);
    let is_first = |seen: &Seen| {
        if size.x > size.y { seen.place.x < middle.x } else { seen.place.y < middle.y }
    };
    let (first, rest) = seen.iter().copied().partition::<Vec<_>, _>(is_first);
    let halves = [first, rest].into_iter().filter(|half| half.len() >= LEAST);
    let mut parts: Vec<_> = halves.flat_map(|half| in_parts(half, halvings - 1)).collect();
    parts.push(seen);
    parts
}

/// How much wider than needed texels are: squares of excess, summed over places.
fn excess(seen: &[Seen], windows: &[&Window], coarsest: f64) -> f64 {
    let of = |seen: &Seen| {
        let holds = windows.iter().filter(|window| window.holds(seen.place));
        let texel = holds.map(|window| window.texel).fold(coarsest, f64::min);
        (texel / seen.texel - 1.0).clamp(0.0, MOST_EXCESS).powi(2)
    };
    seen.iter().map(of).sum()
}

struct Window {
    low: DVec2,
    high: DVec2,
    texel: f64,
    size: u32,
}

impl Window {
    /// The window around places of `seen`, which are in order of what they need, by one of the sizes; `None` if its
    /// texels are hardly finer than `coarsest`.
    fn around(seen: &[Seen], sizes: &[u32], coarsest: f64) -> Option<Self> {
        let low = seen.iter().fold(DVec2::INFINITY, |low, seen| low.min(seen.place));
        let high = seen.iter().fold(DVec2::NEG_INFINITY, |high, seen| high.max(seen.place));
        // A few places are left coarser than they need.
        let needed = seen[seen.len() / FEW].texel;
        let edge = rounded_up((high - low).max_element(), STEPS);
        let is_enough = |size: &&u32| edge / inner(**size) <= needed;
        let size = *sizes.iter().find(is_enough).or(sizes.last())?;
        let texel = rounded_up(edge / inner(size), FINE_STEPS);
        (texel * FINER <= coarsest).then_some(Self { low, high, texel, size })
    }

    /// Share of the texels of the largest window.
    fn area(&self) -> f64 {
        (f64::from(self.size) / f64::from(LARGEST)).powi(2)
    }

    fn holds(&self, place: DVec2) -> bool {
        place.cmpge(self.low).all() && place.cmple(self.high).all()
    }

    fn view(&self, scene: &Scene, base: &View) -> View {
        let middle = (self.low + self.high) * 0.5;
        let size = UVec2::splat(self.size);
        let light = base.light.map(|index| &scene.lights[index]);
        let Some(&Light { kind: LightKind::Spot { position, .. }, far, .. }) = light else {
            let middle = snapped(middle, self.texel).as_vec2();
            let view_from_world =
                Mat4::from_translation(-middle.extend(0.0)) * base.view_from_world;
            return View {
                size,
                view_from_world,
                scale: (1.0 / self.texel) as f32,
                ..base.clone()
            };
        };
        // A cone of its own around the window, which turns in steps.
        let step = rounded_up((self.high - self.low).max_element(), STEPS) / 8.0;
        let middle = snapped(middle, step);
        let from_view = base.view_from_world.inverse();
        let along = from_view.transform_vector3(middle.as_vec2().extend(-1.0)).normalize();
        let view_from_world = looking(position, along, light_up(along));
        let turned = view_from_world * from_view;
        let corners = [
            [self.low.x, self.low.y],
            [self.low.x, self.high.y],
            [self.high.x, self.low.y],
            [self.high.x, self.high.y],
        ];
        let reach = corners.map(|[x, y]| {
            let p = turned.transform_point3(DVec2::new(x, y).as_vec2().extend(-1.0));
            (p.truncate() / -p.z).abs().max_element()
        });
        let reach = rounded_up(reach.into_iter().fold(0.0, f32::max).into(), STEPS);
        let scale = (inner(self.size) * 0.5 / reach) as f32;
        let (_, deepest) = depth_range(&view_from_world, &scene.bounds());
        let far = stepped(far.map_or(deepest * 1.01, |far| far * 2.0)).max(1e-4);
        View { size, view_from_world, scale, near: far * 1e-4, far, ..base.clone() }
    }
}

/// Texels of a window inside its border and fade.
fn inner(size: u32) -> f64 {
    f64::from(size) * f64::from(1.0 - FADE) - 2.0 * BORDER
}

/// What the picture shows, and how wide a pixel is there.
struct Picture<'a> {
    scene: &'a Scene,
    seen: Image,
    eye: DVec3,
    /// Right, up and forward.
    axes: [DVec3; 3],
    /// Width of a pixel at 1 m along the axis [m].
    pixel: f64,
}

impl<'a> Picture<'a> {
    fn new(scene: &'a Scene) -> Self {
        let camera = &scene.camera;
        let view = View::from_camera(camera, &scene.bounds());
        let is_seen = |material: &Material| material.transfer.is_opaque() && material.visible;
        let seen = Raster::new(&view, camera.size / COARSE).nearest(scene, is_seen);
        let forward = (camera.target - camera.eye).as_dvec3().normalize();
        let right = forward.cross(camera.up.as_dvec3()).normalize();
        let pixel = (f64::from(camera.fov_y) * 0.5).tan() * 2.0 / f64::from(camera.size.y);
        let axes = [right, right.cross(forward), forward];
        Self { scene, seen, eye: camera.eye.as_dvec3(), axes, pixel }
    }

    /// Places where the picture may show edges of shadows of `base`.
    fn places(&self, base: &View) -> Vec<Seen> {
        let map = Raster::new(base, UVec2::splat(MAP));
        let casts = |material: &Material| material.casts && material.transfer != Transfer::None;
        let nearest = map.nearest(self.scene, casts);
        self.seen.hits().filter_map(|hit| self.place(hit, base, &map, &nearest)).collect()
    }

    fn place(&self, hit: &Nearest, base: &View, map: &Raster, nearest: &Image) -> Option<Seen> {
        let at = map.texel_of(hit.point)?;
        let is_wide = base.projection == Projection::Perspective;
        let view_from_world = base.view_from_world.as_dmat4();
        let in_light = view_from_world.transform_point3(hit.point);
        let spread = if is_wide { -in_light.z } else { 1.0 };
        let slope = if is_wide { in_light.truncate() / in_light.z } else { DVec2::ZERO };
        let toward = if is_wide { -in_light } else { DVec3::Z };
        let toward = view_from_world.inverse().transform_vector3(toward).normalize();
        let [a, b, c] = self.scene.triangles[hit.triangle as usize].positions.map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let away = hit.point - self.eye;
        let normal = if normal.dot(away) > 0.0 { -normal } else { normal };
        if normal.dot(toward) < MIN_COSINE {
            return None;
        }
        let cell = f64::from(base.size.x) / f64::from(MAP) / f64::from(base.scale) * spread;
        let cover = |texel: IVec2| {
            let hit_there = nearest.at(texel)?;
            let material = self.scene.triangles[hit_there.triangle as usize].material;
            let is_opaque = self.scene.materials[material as usize].transfer.is_opaque();
            let is_in_front = (hit_there.point - hit.point).dot(normal) > 0.5 * cell;
            is_in_front.then_some(if is_opaque { u32::MAX } else { material })
        };
        let around =
            (-EDGES..=EDGES).flat_map(|y| (-EDGES..=EDGES).map(move |x| at + IVec2::new(x, y)));
        let mut around = around.filter(|&texel| map.contains(texel));
        let covers = cover(at);
        if around.all(|texel| cover(texel) == covers) {
            return None;
        }
        // From the light's plane through the surface to the picture.
        let tangent = normal.any_orthonormal_vector();
        let tangents = [tangent, normal.cross(tangent)];
        let of_light = |way: DVec3| {
            let moved = view_from_world.transform_vector3(way);
            (moved.truncate() - slope * moved.z) / spread
        };
        let [right, up, forward] = self.axes;
        let flat = |p: DVec3| DVec2::new(p.dot(right), p.dot(up));
        let distance = away.dot(forward);
        let of_picture = |way: DVec3| {
            (flat(way) - flat(away) * (way.dot(forward) / distance)) / (distance * self.pixel)
        };
        let light = DMat2::from_cols(of_light(tangents[0]), of_light(tangents[1]));
        let picture = DMat2::from_cols(of_picture(tangents[0]), of_picture(tangents[1]));
        let picture_from_light = picture * light.inverse();
        // The larger singular value.
        let sum =
            picture_from_light.x_axis.length_squared() + picture_from_light.y_axis.length_squared();
        let area = picture_from_light.determinant();
        let stretch = ((sum + (sum * sum - 4.0 * area * area).max(0.0).sqrt()) * 0.5).sqrt();
        let place = in_light.truncate() / spread;
        (stretch.is_finite() && stretch > 0.0 && place.is_finite())
            .then(|| Seen { place, texel: FINENESS / stretch })
    }
}
