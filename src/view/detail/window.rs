//! Candidates for windows, around places that need fine texels.
use super::{LARGEST, Seen};
use crate::{
    model::{LightKind, Scene, Shadow, View},
    view::{
        fit::{depth_range, light_up, looking},
        window::{BORDER, rounded_up, snapped, stepped},
    },
};
use glam::{DVec2, Mat4, UVec2};

/// Share of a window's half edge over which it fades, for a light without a size.
const FADE: f32 = 0.05;
/// Largest share.
const MOST_FADE: f32 = 0.5;
/// Least number of places for a window.
const LEAST: usize = 6;
/// Number of times that places are halved, to try windows around the halves.
const HALVINGS: u32 = 3;
/// Number of places among which one may stay coarser than it needs.
const FEW: usize = 32;
/// Steps per octave by which windows and their texels grow: few, so that a window made for each frame seldom
/// changes.
const STEPS: [f64; 2] = [4.0, 16.0];

/// A square on the light's plane, in the unit of [`Seen::place`].
pub(super) struct Window {
    low: DVec2,
    high: DVec2,
    pub(super) texel: f64,
    /// Edge \[texels\].
    pub(super) size: u32,
    /// Largest radius of a penumbra at the places, in the unit of [`Seen::place`]: the window fades over it,
    /// because occluders outside are missing there.
    margin: f64,
}

/// Windows around all places that need texels finer than a limit, for limits half an octave apart, and around
/// parts of them. `seen`: in order of the texel that they need; `own`: the light's texel, and `coarsest`: the
/// coarsest of a window.
pub(super) fn wishes(seen: &[Seen], largest: u32, [own, coarsest]: [f64; 2]) -> Vec<Window> {
    let limits = (0..).map(|i| own * (-0.5 * f64::from(i)).exp2());
    let counts = limits.map(|limit| seen.partition_point(|seen| seen.texel < limit));
    let counts = counts.take_while(|&count| count >= LEAST);
    let parts = counts.flat_map(|count| in_parts(seen[..count].to_vec(), HALVINGS));
    parts.filter_map(|part| Window::around(&part, largest, coarsest)).collect()
}

/// The places together, in each half of their box, in the halves' halves, and so on.
fn in_parts(seen: Vec<Seen>, halvings: u32) -> Vec<Vec<Seen>> {
    if halvings == 0 || seen.len() < 2 * LEAST {
        return vec![seen];
    }
    let [low, high] = corners(&seen);
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

/// Corners of the box around places.
fn corners(seen: &[Seen]) -> [DVec2; 2] {
    let low = seen.iter().fold(DVec2::INFINITY, |low, seen| low.min(seen.place));
    [low, seen.iter().fold(DVec2::NEG_INFINITY, |high, seen| high.max(seen.place))]
}

/// Texels of a window inside its border and [`FADE`].
fn inner(size: u32) -> f64 {
    f64::from(size) * f64::from(1.0 - FADE) - 2.0 * BORDER
}

impl Window {
    /// The window around the places `seen`, in order of the texel that they need, of as few texels as
    /// suffice; `None` if its texels are no finer than `coarsest`.
    fn around(seen: &[Seen], largest: u32, coarsest: f64) -> Option<Self> {
        let [low, high] = corners(seen);
        let needed = seen[seen.len() / FEW].texel;
        let margin = seen.iter().map(|seen| seen.reach).fold(0.0, f64::max);
        let edge = rounded_up((high - low).max_element() + 2.0 * margin, STEPS[0]);
        let sizes =
            (0..4).rev().flat_map(|octave| [(largest >> octave) * 3 / 4, largest >> octave]);
        let size = sizes.into_iter().find(|&size| edge / inner(size) <= needed).unwrap_or(largest);
        let texel = rounded_up(edge / inner(size), STEPS[1]);
        let window = Self { low, high, texel, size, margin };
        (texel < coarsest && window.fade() <= MOST_FADE).then_some(window)
    }

    /// A window of `size` texels around places, for a small map; `None` without places.
    pub(super) fn of_small_map(places: impl Iterator<Item = DVec2>, size: u32) -> Option<Self> {
        let none = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let [low, high] = places.fold(none, |[low, high], at| [low.min(at), high.max(at)]);
        let edge = (high - low).max_element();
        (edge > 0.0).then(|| Self { low, high, texel: edge / inner(size), size, margin: 0.0 })
    }

    /// Share of its half edge over which it fades.
    pub(super) fn fade(&self) -> f32 {
        FADE + (2.0 * self.margin / (self.texel * f64::from(self.size))) as f32
    }

    /// Share of the largest window's texels.
    pub(super) fn area(&self) -> f64 {
        (f64::from(self.size) / f64::from(LARGEST)).powi(2)
    }

    pub(super) fn holds(&self, place: DVec2) -> bool {
        place.cmpge(self.low).all() && place.cmple(self.high).all()
    }

    pub(super) fn view(&self, scene: &Scene, base: &View) -> View {
        let middle = (self.low + self.high) * 0.5;
        let size = UVec2::splat(self.size);
        let light = base.light.map(|index| &scene.lights[index]);
        let shadow = light.and_then(|light| light.all_shadows().nth(base.shadow_index(light)));
        let Some(Shadow { kind: LightKind::Spot { position, .. }, far, .. }) = shadow else {
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
        let edge = (self.high - self.low).max_element() + 2.0 * self.margin;
        let step = rounded_up(edge, STEPS[0]) / 8.0;
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
        let reach = f64::from(reach.into_iter().fold(0.0, f32::max)) + self.margin;
        let reach = rounded_up(reach, STEPS[0]);
        let scale = (inner(self.size) * 0.5 / reach) as f32;
        let (_, deepest) = depth_range(&view_from_world, &scene.held_bounds());
        let far = stepped(far.map_or(deepest * 1.01, |far| far * 2.0)).max(1e-4);
        View { size, view_from_world, scale, near: far * 1e-4, far, ..base.clone() }
    }
}
