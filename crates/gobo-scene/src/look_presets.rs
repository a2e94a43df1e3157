//! Named tables of colours.
use super::look::Row;
use glam::Vec3;

/// A table of colours.
pub(super) struct Preset {
    pub(super) name: &'static str,
    /// Whether its values are shares of a window, and not Hounsfield units.
    pub(super) is_of_window: bool,
    pub(super) rows: fn() -> Vec<Row>,
}

pub(super) const PRESETS: [Preset; 6] = [
    Preset { name: "bone", is_of_window: false, rows: bone },
    Preset { name: "skin", is_of_window: false, rows: skin },
    Preset { name: "body", is_of_window: false, rows: body },
    Preset { name: "heat", is_of_window: true, rows: heat },
    Preset { name: "ice", is_of_window: true, rows: ice },
    Preset { name: "hues", is_of_window: true, rows: hues },
];

/// Water is 0 and air -1000; fat is about -100, muscle 50, spongy bone 300 and dense bone above 1000.
fn of_body(rows: &[(f32, [f32; 3], f32)]) -> Vec<Row> {
    let row = |&(value, color, opacity)| Row { value, color: Vec3::from(color), opacity };
    rows.iter().map(row).collect()
}

const FAT: [f32; 3] = [1.0, 0.82, 0.56];
const SKIN: [f32; 3] = [0.94, 0.66, 0.5];
const MUSCLE: [f32; 3] = [0.8, 0.24, 0.18];
const SPONGY: [f32; 3] = [0.9, 0.7, 0.5];
const DENSE: [f32; 3] = [1.0, 0.97, 0.9];

fn bone() -> Vec<Row> {
    of_body(&[(180.0, SPONGY, 0.0), (400.0, SPONGY, 0.35), (1200.0, DENSE, 1.0)])
}

fn skin() -> Vec<Row> {
    of_body(&[(-600.0, SKIN, 0.0), (-250.0, SKIN, 0.6), (0.0, SKIN, 1.0)])
}

fn body() -> Vec<Row> {
    of_body(&[
        (-400.0, FAT, 0.0),
        (-100.0, FAT, 0.01),
        (60.0, MUSCLE, 0.04),
        (250.0, SPONGY, 0.15),
        (1000.0, DENSE, 1.0),
    ])
}

/// Shares 0 to 1 in steps, with opacities that grow evenly.
fn of_window(steps: u8, color: impl Fn(f32) -> Vec3) -> Vec<Row> {
    let share = |i: u8| f32::from(i) / f32::from(steps);
    let row = |value| Row { value, color: color(value), opacity: value };
    (0..=steps).map(share).map(row).collect()
}

/// Red rises first, then green, then blue, each in a third of the range.
fn heat() -> Vec<Row> {
    of_window(6, |value| {
        (Vec3::splat(value * 3.0) - Vec3::new(0.0, 1.0, 2.0)).clamp(Vec3::ZERO, Vec3::ONE)
    })
}

/// From deep blue to white: blue is 1, green the square root of the value, red the value.
fn ice() -> Vec<Row> {
    of_window(6, |value| Vec3::new(value, value.sqrt(), 1.0))
}

/// Hues from blue through green to red: each channel is a triangle function.
fn hues() -> Vec<Row> {
    of_window(8, |value| {
        let peaks = Vec3::new(1.0, 0.5, 0.0);
        (1.5 - (Vec3::splat(value) - peaks).abs() * 3.0).clamp(Vec3::ZERO, Vec3::ONE)
    })
}
