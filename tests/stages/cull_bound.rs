//! Upper bounds of pairs: no list makes more pairs than the CPU predicts.
use super::cull::{PARAMS, materials, particle, reach, views};
use crate::common::scenes::{Chance, triangle};
use gobo::{
    glam::Vec3,
    model::{Bounds, Particle, Triangle},
    records::{CasterRecord, GpuMaterial, GpuView, TileRect, TriangleRecord},
    shadows::cull::{CasterReach, PairBound, TileLoadBound},
};
use gobo_reference::project::{ProjectParams, project_caster, project_triangle};
use std::collections::HashMap;

/// Parameters without the scatter path: every caster has tiles.
const TILES: ProjectParams = ProjectParams { scatter: false, ..PARAMS };

/// Pairs of the rectangles of one list.
fn counted(rects: impl IntoIterator<Item = TileRect>) -> PairBound {
    let mut of_tile: HashMap<(u32, u32), u32> = HashMap::new();
    let (mut pairs, mut of_caster) = (0, 0);
    for rect in rects {
        let mut tiles = 0;
        for tile in rect.tiles(None) {
            *of_tile.entry(tile).or_default() += 1;
            tiles += 1;
        }
        pairs += u64::from(tiles);
        of_caster = of_caster.max(tiles);
    }
    PairBound { pairs, of_tile: of_tile.into_values().max().unwrap_or(0), of_caster }
}

fn particle_rect(view: &GpuView, particle: &Particle) -> TileRect {
    let material = &materials()[particle.material as usize];
    let (caster, record) = (CasterRecord::new(particle, material), GpuMaterial::new(material, &[]));
    project_caster(view, 0, (&caster, 0), &record, None, TILES).rect
}

fn assert_holds(bound: PairBound, counted: PairBound, what: impl Fn() -> String) {
    let holds = counted.pairs <= bound.pairs
        && counted.of_tile <= bound.of_tile
        && counted.of_caster <= bound.of_caster;
    assert!(holds, "{counted:?} is more than {bound:?}: {}", what());
}

/// Groups of one caster, so that no neighbour conceals a bound that is too small.
#[test]
fn one_caster_makes_no_more_pairs_than_its_bound() {
    let mut chance = Chance::new(21);
    let mut tight = 0;
    for view in views(&mut chance, 400) {
        for _ in 0..300 {
            let particle = particle(&mut chance);
            let around = reach(&particle);
            let mut load = TileLoadBound::new(&view);
            load.add(
                &around,
                1,
                CasterReach::all((around.max - around.min).max_element() * 0.5, 1),
                1.0,
            );
            let counted = counted([particle_rect(&view, &particle)]);
            assert_holds(load.bound(), counted, || format!("{particle:?} in {view:?}"));
            tight += usize::from(counted.pairs > 0 && load.bound().pairs <= 4 * counted.pairs);
        }
    }
    assert!(tight > 5_000, "and not by far: {tight}");
}

#[test]
fn one_triangle_makes_no_more_pairs_than_its_bound() {
    let mut chance = Chance::new(22);
    let mut seen = 0;
    for view in views(&mut chance, 300) {
        for id in 0..200 {
            let (corner, size) = (chance.vec3(-20.0, 20.0), 0.01 * 3000_f32.powf(chance.unit()));
            let positions = [0; 3].map(|_| corner + chance.vec3(-size, size));
            let triangle = Triangle { id, ..triangle(positions, 0) };
            let bounds = positions.iter().fold(Bounds::EMPTY, |b, &p| b.with_sphere(p, 0.0));
            let [a, b, c] = positions;
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            let mut load = TileLoadBound::new(&view);
            load.add(&bounds, 1, CasterReach::all(0.5 * longest, 1), 1.0);
            let record = TriangleRecord::new(&triangle);
            let (projected, _) = project_triangle(&view, 0, &record, 0, 0, TILES);
            let counted = counted([projected.rect]);
            assert_holds(load.bound(), counted, || format!("{triangle:?} in {view:?}"));
            seen += usize::from(counted.pairs > 0);
        }
    }
    assert!(seen > 5_000, "{seen}");
}

/// Groups as the pipeline forms them: of many sizes, side by side and on top of each other.
#[test]
fn a_list_makes_no_more_pairs_than_its_bound() {
    let mut chance = Chance::new(23);
    for view in views(&mut chance, 200) {
        let mut load = TileLoadBound::new(&view);
        let mut rects = Vec::new();
        for _ in 0..1 + chance.below(6) {
            let (middle, spread) = (chance.vec3(-10.0, 10.0), chance.within(0.01, 4.0));
            let mut bounds = Bounds::EMPTY;
            let (mut reaches, count) = (CasterReach::default(), 1 + chance.below(100) as u32);
            for _ in 0..count {
                let place = middle + chance.vec3(-spread, spread);
                let one = Particle {
                    center: place,
                    radius: 0.2 * chance.unit() + 0.01,
                    ..particle(&mut chance)
                };
                let around = reach(&one);
                bounds =
                    Bounds { min: bounds.min.min(around.min), max: bounds.max.max(around.max) };
                reaches.add((around.max - around.min).max_element() * 0.5);
                rects.push(particle_rect(&view, &one));
            }
            load.add(&bounds, count, reaches, 1.0);
        }
        assert_holds(load.bound(), counted(rects), || format!("{view:?}"));
    }
}

/// The largest caster of a group does not count for all: the bound decides how many parts are recorded.
#[test]
fn one_large_caster_among_small_ones_counts_once() {
    let mut chance = Chance::new(25);
    let (mut bounds, mut found) = (0, 0);
    for view in views(&mut chance, 400) {
        let (mut load, mut around, mut reaches) =
            (TileLoadBound::new(&view), Bounds::EMPTY, CasterReach::default());
        let mut rects = Vec::new();
        for i in 0..200 {
            let radius = if i == 77 { 4.0 } else { 0.02 };
            let center = chance.vec3(-1.0, 1.0);
            let one = Particle { center, radius, ..particle(&mut chance) };
            let of_one = reach(&one);
            around = Bounds { min: around.min.min(of_one.min), max: around.max.max(of_one.max) };
            reaches.add((of_one.max - of_one.min).max_element() * 0.5);
            rects.push(particle_rect(&view, &one));
        }
        load.add(&around, 200, reaches, 1.0);
        let counted = counted(rects);
        assert_holds(load.bound(), counted, || format!("{view:?}"));
        if view.perspective == 0.0 && counted.pairs > 200 {
            (bounds, found) = (bounds + load.bound().pairs, found + counted.pairs);
        }
    }
    assert!(found > 0 && bounds < 8 * found, "{bounds} for {found}");
}

/// With NaN all tiles may be touched.
#[test]
fn what_is_no_number_may_touch_all_tiles() {
    let mut chance = Chance::new(24);
    let view = views(&mut chance, 1)[0];
    let tiles = (view.size / 16.0).ceil();
    let mut load = TileLoadBound::new(&view);
    load.add(&Bounds { min: Vec3::NAN, max: Vec3::NAN }, 7, CasterReach::all(f32::NAN, 7), 1.0);
    let all = (tiles.x * tiles.y) as u32;
    assert_eq!(load.bound(), PairBound { pairs: 7 * u64::from(all), of_tile: 7, of_caster: all });
}
