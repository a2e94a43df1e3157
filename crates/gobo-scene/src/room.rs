//! Closed rooms, whose own picture is taken from within.
use super::{
    exposure::seen,
    rays::{Met, Rays},
    subject::Subject,
};
use glam::{UVec2, Vec3};
use gobo::model::{Bounds, Camera};
use std::{
    collections::{BTreeMap, BTreeSet},
    f32::consts::TAU,
};

/// Places on the floor at which an eye may be, in each direction, and the shares of the room that they span.
const PLACES: u32 = 7;
const MARGIN: f32 = 0.06;
/// Directions in which walls are looked for.
const DIRECTIONS: u32 = 64;
/// Least share of them with walls of a room, doors included; and of one that is a box from outside.
const CLOSED: f32 = 0.85;
const SHUT: f32 = 0.97;
/// Height of the eye, of what it looks at and of the lamp [heights of the room there].
const EYE: f32 = 0.62;
const TARGET: f32 = 0.35;
const LAMP: f32 = 0.88;
/// Least distance of the eye to what is around it [widths of the room].
const NEAR: f32 = 0.03;
/// Share of the way across the room by which an eye may be nearer than a corner if it is so many times as
/// far from walls.
const NEARER: f32 = 0.1;
const OFF_WALL: f32 = 3.0;
/// Rays of the picture from outside.
const RAYS: UVec2 = UVec2::new(32, 18);
/// Thickness of walls [widths of the room].
const THICK: f32 = 0.06;

/// A closed room.
pub(super) struct Interior {
    /// Places of the eye and of what it looks at.
    pub(super) eye: Vec3,
    pub(super) target: Vec3,
    /// Place of a lamp under its ceiling.
    pub(super) lamp: Vec3,
}

/// A place in the room.
struct Standpoint {
    eye: Vec3,
    lamp: Vec3,
    /// Height of what is looked at from there, world space \[m\].
    level: f32,
    /// Share of the directions that end at a wall's inner side.
    closed: f32,
    /// Middle of what is seen from there, by the squares of its distances.
    middle: Vec3,
    /// Distance of what is nearest \[m\].
    nearest: f32,
    /// Ids of what is seen.
    ids: BTreeSet<u32>,
}

impl Interior {
    /// The room that a file is, if what is to be seen of it is within: its walls show their backs outside, or
    /// they are a box that hides what stands in it. `camera`: the one that sees it from outside.
    pub(super) fn of(subject: &Subject<'_>, camera: &Camera) -> Option<Self> {
        let Bounds { min, max } = subject.bounds;
        let size = max - min;
        if size.min_element() <= 0.05 * size.max_element() {
            return None;
        }
        let rays = Rays::new(subject.triangles(), &subject.scene.materials);
        if !rays.is_whole() {
            return None;
        }
        let places: Vec<Standpoint> = grid(&subject.bounds)
            .filter_map(|place| Standpoint::at(&rays, place, size))
            .filter(|it| it.closed >= CLOSED)
            .collect();
        let center = subject.bounds.center();
        let aside = |place: Vec3| (place - center).with_y(0.0).length();
        let middle = places.iter().min_by(|a, b| aside(a.eye).total_cmp(&aside(b.eye)))?;
        let outside = seen(&rays, camera, RAYS);
        let backs = outside.iter().filter(|met| !met.is_front).count();
        if 2 * backs < outside.len() && !hides(subject, &outside, &places) {
            return None;
        }
        // From a corner, or an end, across the room.
        let usual = Vec3::new(0.55, 0.0, 0.8);
        let score = |it: &Standpoint| {
            let across = (it.eye - it.middle).with_y(0.0);
            across.length() + 0.2 * across.dot(usual)
        };
        let is_free = |it: &&Standpoint| {
            let is_clear = |met: f32| met > 0.4;
            it.nearest > NEAR * size.x.min(size.z)
                && rays.first(it.eye, it.middle - it.eye).is_none_or(|met| is_clear(met.distance))
        };
        let free = places.iter().filter(is_free);
        let corner = free.clone().max_by(|a, b| score(a).total_cmp(&score(b)))?;
        // Not along a corridor's wall.
        let across = (corner.middle - corner.eye).with_y(0.0);
        let is_off_wall = |it: &&Standpoint| {
            let nearer = (it.eye - corner.eye).dot(across) / across.length_squared();
            nearer <= NEARER && it.nearest >= OFF_WALL * corner.nearest
        };
        let off_wall = free.filter(is_off_wall).max_by(|a, b| a.nearest.total_cmp(&b.nearest));
        let from = off_wall.unwrap_or(corner);
        let target = from.middle.with_y(from.level);
        Some(Self { eye: from.eye, target, lamp: middle.lamp })
    }
}

/// Places at a third of the height, away from the borders.
fn grid(bounds: &Bounds) -> impl Iterator<Item = Vec3> {
    let (min, size) = (bounds.min, bounds.max - bounds.min);
    let share = |i: u32| MARGIN + (1.0 - 2.0 * MARGIN) * i as f32 / (PLACES - 1) as f32;
    (0..PLACES * PLACES)
        .map(move |i| min + size * Vec3::new(share(i % PLACES), 1.0 / 3.0, share(i / PLACES)))
}

/// Evenly distributed directions (Swinbank and Purser 2006).
fn directions() -> impl Iterator<Item = Vec3> {
    const GOLDEN: f32 = 0.618_034;
    (0..DIRECTIONS).map(|i| {
        let y = 1.0 - (2.0 * i as f32 + 1.0) / DIRECTIONS as f32;
        let (sine, cosine) = (TAU * GOLDEN * i as f32).sin_cos();
        Vec3::new(cosine, 0.0, sine) * (1.0 - y * y).sqrt() + Vec3::Y * y
    })
}

impl Standpoint {
    /// A place between a floor and a ceiling above and below `place`; `size`: of everything.
    fn at(rays: &Rays<'_>, place: Vec3, size: Vec3) -> Option<Self> {
        let floor = rays.first(place, Vec3::NEG_Y).filter(|met| met.is_front)?;
        let ceiling = rays.first(place, Vec3::Y).filter(|met| met.is_front)?;
        let height = ceiling.place.y - floor.place.y;
        if height < size.y / 3.0 {
            return None;
        }
        let at = |share: f32| place.with_y(floor.place.y + share * height);
        let eye = at(EYE);
        let met: Vec<_> = directions().filter_map(|along| rays.first(eye, along)).collect();
        let walls: Vec<_> = met.iter().filter(|met| met.is_front).collect();
        let count = walls.len() as f32;
        // Far walls count more: they fill the picture.
        let weight = |met: &Met<'_>| met.distance * met.distance;
        let weights: f32 = walls.iter().map(|met| weight(met)).sum();
        let weighted: Vec3 = walls.iter().map(|met| met.place * weight(met)).sum();
        Some(Self {
            eye,
            lamp: at(LAMP),
            level: at(TARGET).y,
            closed: count / DIRECTIONS as f32,
            middle: weighted / weights.max(f32::MIN_POSITIVE),
            nearest: walls.iter().map(|met| met.distance).fold(f32::INFINITY, f32::min),
            ids: walls.iter().map(|met| met.triangle.id).collect(),
        })
    }
}

/// Whether a shut box hides things that stand in it. `outside`: what is seen from there.
fn hides(subject: &Subject<'_>, outside: &[Met<'_>], places: &[Standpoint]) -> bool {
    let Bounds { min, max } = subject.bounds;
    let size = max - min;
    let slack = THICK * size.x.min(size.z);
    let depth = |met: &Met<'_>| (met.place - min).min(max - met.place).min_element();
    let is_box = outside.iter().all(|met| depth(met) <= 0.25 * slack);
    let shut = places.iter().filter(|it| it.closed >= SHUT).count();
    if !is_box || 2 * shut < places.len() {
        return false;
    }
    let mut things = BTreeMap::new();
    for triangle in subject.triangles() {
        let (low, high) = things.entry(triangle.id).or_insert((Vec3::INFINITY, Vec3::NEG_INFINITY));
        for corner in triangle.positions {
            (*low, *high) = (low.min(corner), high.max(corner));
        }
    }
    let is_apart = |(low, high): (Vec3, Vec3)| {
        let gap = (low - min).min(max - high);
        gap.x.min(gap.z) > slack && max.y - high.y > slack
    };
    places
        .iter()
        .flat_map(|it| &it.ids)
        .any(|id| things.get(id).is_some_and(|bounds| is_apart(*bounds)))
}
