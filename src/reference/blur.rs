//! Twin of `wgsl/blur/`: a Gaussian of the filter map and of the curves. Depths stay sharp: the nearest
//! one is pushed towards the light, to the nearest within the window, so that all of a blurred edge is
//! behind it.
//!
//! Texels beside the map count for nothing, and neither does one that is blind: in which something opaque
//! lies before all that is translucent around. It would let light leak into the shadow beside it.
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

/// The nearest translucent depth of some texels, whose it is, and where the first of their curves
/// begins: what is too faint for a nearest depth counts there.
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

/// Weights and places of the texels of a window that are on the map.
fn window(size: u32, at: u32, radius: u32) -> impl Iterator<Item = (f32, u32)> {
    let scale = -0.5 * (BLUR_DEVIATIONS / radius as f32).powi(2);
    (at.saturating_sub(radius)..=(at + radius).min(size - 1)).map(move |place| {
        let off = place.abs_diff(at) as f32;
        ((off * off * scale).exp(), place)
    })
}

/// Blurs what the translucent casters of a view do to light; `radius` of the window [texels].
pub fn blur(maps: &mut ViewMaps, radius: u32) {
    if radius == 0 {
        return;
    }
    let size = maps.view.size;
    let around = nearest_around(maps, radius);
    // Sum and its weight.
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

/// `rows`: as the filter has them, with the weight of what counts in each row's window.
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
