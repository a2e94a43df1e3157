//! Every figure of `docs/dither.md`, measured again: `make tables` writes them.
use crate::{
    common::{TIERS, map_frame, scenes::empty},
    dither_study as measure,
};
use gobo::{
    glam::Vec3,
    model::{Light, LightKind, Material, Pattern, Transfer},
};
use gobo_scene::Scene;

/// Half a unit of the last digit, and differences between implementations of sine.
const ROUNDED: f32 = 0.002;

fn page() -> String {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/dither.md");
    std::fs::read_to_string(page).unwrap()
}

/// Numbers in a table's row, without other cells.
fn row(table: &str, name: &str) -> Vec<f32> {
    let page = page();
    let start = page.find(&format!("<!-- table {table} -->")).expect("the table is marked");
    let name = format!("| {name} |");
    let row = page[start..].lines().find(|line| line.starts_with(&name)).expect("a row");
    let cells = row[name.len()..].split('|').map(|cell| cell.trim().trim_end_matches('%'));
    cells.filter_map(|cell| cell.parse().ok()).collect()
}

fn pattern_row(table: &str, pattern: Pattern) -> Vec<f32> {
    row(table, &format!("`{}`", pattern.name()))
}

fn same(stated: f32, measured: f32) -> bool {
    (stated - measured).abs() <= ROUNDED
}

#[test]
fn stated_quality_is_measured() {
    for pattern in Pattern::ALL {
        let mut stated = pattern_row("quality", pattern);
        if pattern.levels().is_some() {
            stated.remove(0);
        }
        let coverage = measure::coverage_error(pattern);
        let shadow = measure::shadow_error(pattern);
        let colored = measure::colored_error(pattern);
        let measured = [
            coverage.rms,
            coverage.max,
            shadow.dithered,
            shadow.softened,
            colored.dithered,
            colored.softened,
        ];
        assert_eq!(stated.len(), 6);
        for (stated, measured) in stated.iter().zip(measured) {
            assert!(same(*stated, measured), "{pattern:?}: {stated} is {measured}");
        }
        assert!(shadow.softened < 0.3 * shadow.dithered, "{pattern:?} {shadow:?}");
        assert!(colored.softened < 0.3 * colored.dithered, "{pattern:?} {colored:?}");
        assert!(!same(stated[2], measured[3]), "the check can fail");
    }
}

#[test]
#[ignore = "many frames of each pattern: make test-all"]
fn stated_flicker_is_measured() {
    for pattern in std::iter::once(None).chain(Pattern::ALL.map(Some)) {
        let name = pattern.map_or("exact filter".to_owned(), |p| format!("`{}`", p.name()));
        let stated = row("flicker", &name);
        let flicker = measure::flicker(pattern);
        let measured = [flicker.dithered, flicker.softened, flicker.changed * 100.0];
        assert_eq!(stated.len(), 4);
        for (column, (stated, measured)) in stated.iter().zip(measured).enumerate() {
            // The share of texels has one decimal: half of it is 0.05.
            let digits = if column == 2 { 0.06 } else { ROUNDED };
            let rounded = if measured > 1.0 { 0.2 } else { digits.max(0.1 * measured) };
            assert!((stated - measured).abs() <= rounded, "{name}: {stated} is {measured}");
        }
        // Half a unit of the stated digits: rays of the moved view are rounded differently.
        assert!(flicker.snapping < 5e-6 && stated[3] == 0.0, "{name}: {flicker:?}");
        if pattern.is_some() {
            assert!(flicker.changed <= 0.05, "{name}: {flicker:?}");
        }
    }
}

/// Work of a frame per caster: walked pairs, and segments of tiles.
#[test]
#[ignore = "a hundred thousand casters: make test-all"]
fn work_per_caster_is_flat() {
    let per_caster = |count: u32, transfer: Transfer| {
        let scene = duplicates(count, transfer);
        let counters = map_frame(TIERS[1], &scene).counters;
        assert_eq!((counters.visible, counters.overflowed), (u64::from(count), 0));
        counters.pairs as f64 / f64::from(count)
    };
    let work = [10, 100, 1_000, 100_000].map(|count| per_caster(count, Transfer::Dither));
    let (least, most) = work.iter().fold((f64::MAX, 0.0_f64), |(a, b), w| (a.min(*w), b.max(*w)));
    assert!(least > 1.0 && most / least <= 1.3, "{work:?}");
    assert_eq!(per_caster(1_000, Transfer::Opaque), work[2]);
}

/// Scene of `measure::duplicates` under one light, whose map they fill: pairs are counted, and hardly walked.
fn duplicates(count: u32, transfer: Transfer) -> Scene {
    let mut scene = empty(vec![Material { transfer, ..measure::duplicated() }]);
    scene.particles = measure::duplicates(count);
    let kind = LightKind::Directional { direction: Vec3::NEG_Z };
    scene.lights = vec![Light { kind, ..crate::common::scenes::light(kind) }];
    scene.shadow.size = 32;
    scene
}
