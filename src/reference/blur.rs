//! Twin of `wgsl/blur/`: a Gaussian of the filter map and of the curves. Depths are not blurred; the
//! nearest one becomes the nearest of the window, so that all of a blurred edge is behind it.
//!
//! Texels off the map have no weight, and neither have blind ones, whose opaque surface is in front of all
//! translucent casters of the window: their light would leak into the shadow next to them.
use super::{
    curve::{
        DEPTHS,
        mean::{add_nodes, merge},
    },
    filter::{stored, texels},
    threads::each,
};
use crate::{
    model::BLUR_DEVIATIONS,
    records::{CurveMap, NO_OWNER, ViewMaps},
};
use glam::{UVec2, Vec3, Vec4};

/// Nearest translucent depth of some texels, its owner, and the first depth of their curves, which also
/// hold casters too faint for a nearest depth.
#[derive(Clone, Copy, Debug)]
struct Near {
    depth: f32,
    owner: u16,
    first: f32,
}

impl Near {
    const NONE: Self = Self { depth: 1.0, owner: NO_OWNER, first: 1.0 };

    fn of(maps: &ViewMaps, at: usize) -> Self {
        let depth = maps.nearest[at];
        let start = maps.curve.as_ref().map_or(0, |curve| curve.nodes_of(at)[0][0] >> 16);
        let first = if start > 0 { (start - 1) as f32 / DEPTHS } else { 1.0 };
        let owner = maps.owner.get(at).copied().unwrap_or(NO_OWNER);
        Self { depth, owner, first: first.min(depth) }
    }

    fn and(self, other: Self) -> Self {
        let nearer = if other.depth < self.depth { other } else { self };
        Self { first: self.first.min(other.first), ..nearer }
    }
}

/// Weights and coordinates of the window's texels that are on the map.
fn window(size: u32, at: u32, radius: u32) -> impl Iterator<Item = (f32, u32)> {
    let scale = -0.5 * (BLUR_DEVIATIONS / radius as f32).powi(2);
    (at.saturating_sub(radius)..=(at + radius).min(size - 1)).map(move |place| {
        let off = place.abs_diff(at) as f32;
        ((off * off * scale).exp(), place)
    })
}

/// Blurs the filter map and the curves of a view over windows of `radius` texels to each side.
pub fn blur(maps: &mut ViewMaps, radius: u32) {
    if radius == 0 {
        return;
    }
    let size = maps.view.size;
    let around = nearest_around(maps, radius);
    // Sums and, in w, their weights.
    let rows: Vec<Vec4> = texels(size)
        .map(|(x, y)| {
            let first = y * size.x;
            let near = around[(first + x) as usize].first;
            let sees = |&(_, x): &(f32, u32)| !is_blind(maps, first + x, near);
            let light = |x| Vec3::from(maps.filter[(first + x) as usize]).extend(1.0);
            window(size.x, x, radius).filter(sees).map(|(weight, x)| light(x) * weight).sum()
        })
        .collect();
    if let Some(curve) = &maps.curve {
        maps.curve = Some(blurred_curves(maps, curve, &around, &rows, radius));
    }
    for (at, (x, y)) in texels(size).enumerate() {
        let row = |(weight, y)| rows[(y * size.x + x) as usize] * weight;
        let sum: Vec4 = window(size.y, y, radius).map(row).sum();
        let light = if sum.w > 0.0 { sum.truncate() / sum.w } else { Vec3::ONE };
        maps.filter[at] = light.to_array().map(stored);
    }
    maps.nearest = around.iter().map(|near| near.depth).collect();
    if !maps.owner.is_empty() {
        maps.owner = around.iter().map(|near| near.owner).collect();
    }
}

fn is_blind(maps: &ViewMaps, at: u32, near: f32) -> bool {
    maps.opaque[at as usize] < near
}

fn nearest_around(maps: &ViewMaps, radius: u32) -> Vec<Near> {
    let size = maps.view.size;
    let rows: Vec<Near> = texels(size)
        .map(|(x, y)| {
            let row = |(_, x)| Near::of(maps, (y * size.x + x) as usize);
            window(size.x, x, radius).map(row).fold(Near::NONE, Near::and)
        })
        .collect();
    let column = |(x, y): (u32, u32)| {
        let near = |(_, y)| rows[(y * size.x + x) as usize];
        window(size.y, y, radius).map(near).fold(Near::NONE, Near::and)
    };
    texels(size).map(column).collect()
}

/// `rows`: sums of the filter over each row's window and, in w, their weights.
fn blurred_curves(
    maps: &ViewMaps,
    curve: &CurveMap,
    around: &[Near],
    rows: &[Vec4],
    radius: u32,
) -> CurveMap {
    let size = maps.view.size;
    let mean_of = |from: &CurveMap, taps: &mut dyn Iterator<Item = (f32, u32)>| {
        let mut ramps = Vec::new();
        for (share, at) in taps {
            add_nodes(from.nodes_of(at as usize), share, curve.gain, &mut ramps);
        }
        let mut nodes = vec![[0; 2]; curve.nodes];
        merge(&ramps, &mut nodes, curve.gain);
        nodes
    };
    let row = |at: usize| {
        let (x, y) = place(size, at);
        let taps = window(size.x, x, radius).map(|(weight, x)| (weight, y * size.x + x));
        let seen = taps.filter(|&(_, i)| !is_blind(maps, i, around[at].first));
        mean_of(curve, &mut seen.map(|(weight, i)| (weight / rows[at].w, i)))
    };
    let packed = |nodes: Vec<Vec<_>>| CurveMap { packed: nodes.concat(), ..*curve };
    let by_rows = packed(each(rows.len(), row));
    let column = |at: usize| {
        let (x, y) = place(size, at);
        let taps = || {
            let taps = window(size.y, y, radius).map(|(weight, y)| (weight, y * size.x + x));
            taps.map(|(weight, i)| (weight * rows[i as usize].w, i))
        };
        let all: f32 = taps().map(|(weight, _)| weight).sum();
        mean_of(&by_rows, &mut taps().map(|(weight, i)| (weight / all.max(1e-6), i)))
    };
    packed(each(rows.len(), column))
}

fn place(size: UVec2, at: usize) -> (u32, u32) {
    (at as u32 % size.x, at as u32 / size.x)
}
