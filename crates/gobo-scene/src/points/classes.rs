//! Colours of points: their own, or grey by the strength of the echo, or by their class.
use super::{Fault, Points};
use glam::Vec3;
use std::path::Path;

/// Colour of points without colour, echo or class.
pub(super) const PLAIN: Vec3 = Vec3::splat(0.6);

/// Share of the echoes up to the one shown white: some are far stronger than all others.
const WHITE: f64 = 0.98;

/// Darkest grey, so that every echo is visible.
const DARKEST: f32 = 0.05;

/// Classes of noise (ASPRS LAS 1.4 R15, table 17): low and high.
const NOISE: [u8; 2] = [7, 18];

/// Linear colours of classes of the same table.
const COLORS: [(u8, Vec3); 12] = [
    (2, Vec3::new(0.32, 0.22, 0.13)),
    (3, Vec3::new(0.25, 0.38, 0.1)),
    (4, Vec3::new(0.14, 0.34, 0.08)),
    (5, Vec3::new(0.06, 0.26, 0.06)),
    (6, Vec3::new(0.5, 0.2, 0.14)),
    (9, Vec3::new(0.05, 0.16, 0.42)),
    (10, Vec3::new(0.3, 0.28, 0.27)),
    (11, Vec3::new(0.16, 0.16, 0.17)),
    (13, Vec3::new(0.7, 0.6, 0.1)),
    (14, Vec3::new(0.7, 0.6, 0.1)),
    (15, Vec3::new(0.6, 0.4, 0.1)),
    (17, Vec3::new(0.36, 0.34, 0.36)),
];

/// Whether a class is noise.
pub(super) fn is_noise(class: u8) -> bool {
    NOISE.contains(&class)
}

/// A colour for each point; empty if the file has nothing to derive it from.
pub(super) fn colors(points: &mut Points, notes: &mut Vec<String>, path: &Path) -> Vec<Vec3> {
    let count = points.positions.len();
    // A file may have colours of some points only.
    let is_whole = |length: usize| length == count;
    let is_colored = match &points.part {
        Some(part) => part.is_colored,
        None => points.colors.iter().any(|color| *color != Vec3::ZERO),
    };
    if is_whole(points.colors.len()) && is_colored {
        return std::mem::take(&mut points.colors);
    }
    let mut note = |words: &str| {
        if count > 0 {
            notes.push(format!("{}: {words}", path.display()));
        }
    };
    let white = match &points.part {
        Some(part) => part.quantile(WHITE),
        None => white(&points.intensities),
    };
    if let Some(white) = white.filter(|_| is_whole(points.intensities.len())) {
        note("points have no colours: they are grey by their intensity");
        let grey = |echo: &f32| Vec3::splat((echo / white).clamp(DARKEST, 1.0));
        return points.intensities.iter().map(grey).collect();
    }
    let color = |class: &u8| COLORS.iter().find(|known| known.0 == *class).map(|known| known.1);
    let is_known = |class: &u8| color(class).is_some();
    let is_classed = match &points.part {
        Some(part) => {
            (0..=u8::MAX).any(|class| part.classes[usize::from(class)] && is_known(&class))
        }
        None => points.classes.iter().any(is_known),
    };
    if is_whole(points.classes.len()) && is_classed {
        note("points have neither colours nor intensity: their colours are those of their classes");
        return points.classes.iter().map(|class| color(class).unwrap_or(PLAIN)).collect();
    }
    note("points have no colours");
    Vec::new()
}

/// Alphas of all classes, 1 unless given.
pub(super) fn alphas(points: &Points, given: &[(u8, f32)]) -> Result<[f32; 256], Fault> {
    if points.classes.len() < points.positions.len() {
        return Err(("its points have no classes".to_owned(), "remove `classes`"));
    }
    let mut alphas = [1.0; 256];
    for &(class, alpha) in given {
        alphas[usize::from(class)] = alpha;
    }
    Ok(alphas)
}

/// Strength of the echo that is shown white; `None` without echoes.
fn white(intensities: &[f32]) -> Option<f32> {
    let mut sorted: Vec<f32> = intensities.iter().copied().filter(|echo| *echo > 0.0).collect();
    let at = (sorted.len().checked_sub(1)? as f64 * WHITE) as usize;
    Some(*sorted.select_nth_unstable_by(at, f32::total_cmp).1)
}
