//! A chest as a CT scanner records it, in Hounsfield units: air is -1000, water 0, dense bone above 1000.
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Value at a place: x and z from -1 to 1 across the box, y from 0 at its floor to 1; the chest faces +z.
/// `lumps`: noise of about -0.5 to 1 that makes tissue uneven.
pub(super) fn hounsfield(place: Vec3, lumps: f32) -> f32 {
    let at = Vec3::new(place.x, place.y * 2.0 - 1.0, place.z);
    // Shoulders are narrower than the chest.
    let width = 1.0 - 0.25 * step(at.y - 0.82, 0.3);
    let flat = (Vec2::new(at.x / 0.95, at.z / 0.86) / width).abs();
    let depth = 1.0 - (flat.x.powf(2.4) + flat.y.powf(2.4)).powf(1.0 / 2.4);
    let mut value = -1000.0;
    let mut fill = |inside: f32, tissue: f32| value += (tissue - value) * inside;
    fill(step(depth, 0.03), 10.0);
    fill(step(depth - 0.03, 0.02), -95.0 + 20.0 * lumps);
    fill(step(depth - 0.09 - 0.02 * lumps, 0.03), 55.0 + 25.0 * lumps);
    for side in [-1.0, 1.0] {
        let lung = ball(at, Vec3::new(0.4 * side, 0.05, 0.02), Vec3::new(0.3, 0.8, 0.5));
        fill(step(lung, 0.08), -830.0 + 260.0 * lumps.max(0.0).powi(2));
    }
    let heart = ball(at, Vec3::new(0.14, -0.2, 0.2), Vec3::new(0.32, 0.34, 0.3));
    fill(step(heart, 0.1), 130.0 + 30.0 * lumps);
    let liver = ball(at, Vec3::new(-0.3, -0.95, 0.1), Vec3::new(0.5, 0.3, 0.5));
    fill(step(liver, 0.1), 75.0);
    let bone = spine(at).max(ribs(at)).max(front(at));
    // A shell of dense bone around a spongy core.
    let dense = 1.0 - step(bone - 0.4, 0.4);
    fill(step(bone, 0.35), 330.0 + 60.0 * lumps + 850.0 * dense);
    value
}

/// Smooth step from 0 to 1 about `inside` = 0, over a width.
fn step(inside: f32, width: f32) -> f32 {
    let t = (0.5 + inside / width).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Depth inside an ellipsoid: 1 at its centre, 0 at its surface.
fn ball(at: Vec3, center: Vec3, radii: Vec3) -> f32 {
    1.0 - ((at - center) / radii).length()
}

/// Depth inside a capsule around a segment: 1 on the segment, 0 at the radius.
fn rod(at: Vec3, [from, to]: [Vec3; 2], radius: f32) -> f32 {
    let way = to - from;
    let t = ((at - from).dot(way) / way.length_squared()).clamp(0.0, 1.0);
    1.0 - (at - from - way * t).length() / radius
}

/// Vertebrae with their processes, and the discs between them.
fn spine(at: Vec3) -> f32 {
    const VERTEBRAE: f32 = 5.0;
    let phase = at.y * VERTEBRAE;
    let waist = (phase * TAU).cos();
    let body = Vec2::new(at.x / 0.15, (at.z + 0.5) / 0.14).length();
    let body = 1.0 - body / (1.0 + 0.12 * waist.abs()) - step(-0.8 - waist, 0.2);
    let middle = phase.round() / VERTEBRAE;
    let back = [Vec3::new(0.0, middle, -0.58), Vec3::new(0.0, middle - 0.1, -0.76)];
    let aside = |side: f32| {
        let way = [Vec3::new(0.05 * side, middle, -0.6), Vec3::new(0.2 * side, middle, -0.66)];
        rod(at, way, 0.04)
    };
    body.max(rod(at, back, 0.045)).max(aside(-1.0)).max(aside(1.0))
}

/// Ten pairs, each an arc that falls from the spine to the front.
fn ribs(at: Vec3) -> f32 {
    let rib = |i: u8| {
        let share = f32::from(i) / 9.0;
        let height = -0.72 + 1.5 * share;
        let narrow = 1.0 - 0.45 * (share - 0.25).max(0.0).powi(2) * 2.2;
        let ring = Vec2::new(at.x / 0.72, (at.z - 0.02) / 0.6) / narrow;
        let fall = at.y - height + 0.3 * (at.z + 0.55);
        let tube = Vec2::new((ring.length() - 1.0) * 0.65 / 0.045, fall / 0.055).length();
        // The lowest pairs end at the sides, the others at the breastbone.
        let end = if i < 2 { 0.1 } else { 0.57 };
        1.0 - tube
            - step(at.z - end, 0.1) * step(0.08 - at.x.abs() + if i < 2 { 9.0 } else { 0.0 }, 0.05)
    };
    (0..10).map(rib).fold(f32::NEG_INFINITY, f32::max)
}

/// Breastbone and collarbones.
fn front(at: Vec3) -> f32 {
    let breast = ball(at, Vec3::new(0.0, 0.16, 0.6), Vec3::new(0.09, 0.5, 0.05));
    let collar = |side: f32| {
        let way = [Vec3::new(0.07 * side, 0.7, 0.58), Vec3::new(0.66 * side, 0.84, 0.2)];
        rod(at, way, 0.05)
    };
    breast.max(collar(-1.0)).max(collar(1.0))
}
