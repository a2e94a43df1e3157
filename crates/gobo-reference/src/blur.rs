//! CPU reference of `wgsl/blur/`: a Gaussian blur of the filter map and of the curves. Depths are not
//! blurred; the nearest depth becomes the nearest of the window, so that all of a blurred edge is behind it.
//!
//! Texels outside the map have weight 0, and so have blind ones, whose opaque surface is in front of all
//! translucent casters of the window: their light would leak into the shadow beside them.
use super::{
    curve::{
        DEPTHS,
        mean::{add_nodes, merge},
    },
    soften::stored,
    threads::each,
};
use glam::{UVec2, Vec3};
use gobo::{
    model::BLUR_DEVIATIONS,
    records::{NO_OWNER, PackedNode, ViewMaps},
};

/// A blurred texel.
struct BlurredTexel {
    filter: [f32; 3],
    nearest: f32,
    owner: u16,
    nodes: Vec<PackedNode>,
}

/// Blurs the filter map and the curves of a view over windows of `radius` texels to each side.
pub fn blur(maps: &mut ViewMaps, radius: u32) {
    if radius == 0 {
        return;
    }
    let texels = each(maps.filter.len(), |at| blurred(maps, at, radius));
    for (at, texel) in texels.into_iter().enumerate() {
        (maps.filter[at], maps.nearest[at]) = (texel.filter, texel.nearest);
        if let Some(owner) = maps.owner.get_mut(at) {
            *owner = texel.owner;
        }
        if let Some(curve) = &mut maps.curve {
            curve.packed[at * curve.nodes..][..curve.nodes].copy_from_slice(&texel.nodes);
        }
    }
}

fn blurred(maps: &ViewMaps, at: usize, radius: u32) -> BlurredTexel {
    let (mut nearest, mut owner, mut first) = (1.0, NO_OWNER, 1.0_f32);
    for (_, i) in window(maps.view.size, at, radius) {
        if maps.nearest[i] < nearest {
            nearest = maps.nearest[i];
            owner = maps.owner.get(i).copied().unwrap_or(NO_OWNER);
        }
        first = first.min(first_depth(maps, i));
    }
    let seen = || window(maps.view.size, at, radius).filter(|&(_, i)| maps.opaque[i] >= first);
    let all: f32 = seen().map(|(weight, _)| weight).sum();
    let sum: Vec3 = seen().map(|(weight, i)| Vec3::from(maps.filter[i]) * weight).sum();
    let light = if all > 0.0 { sum / all } else { Vec3::ONE };
    let mut nodes = Vec::new();
    if let Some(curve) = &maps.curve {
        let mut ramps = Vec::new();
        for (weight, i) in seen() {
            add_nodes(curve.nodes_of(i), weight / all, curve.gain, &mut ramps);
        }
        nodes.resize(curve.nodes, PackedNode::default());
        merge(&ramps, &mut nodes, curve.gain);
    }
    BlurredTexel { filter: light.to_array().map(stored), nearest, owner, nodes }
}

/// First depth at which a texel loses light; curves also hold casters too faint for a nearest depth.
fn first_depth(maps: &ViewMaps, at: usize) -> f32 {
    let start = maps.curve.as_ref().map_or(0, |curve| curve.nodes_of(at)[0][0] >> 16);
    let first = if start > 0 { (start - 1) as f32 / DEPTHS } else { 1.0 };
    first.min(maps.nearest[at])
}

/// Weights and indices of the window's texels that are on the map, row by row.
fn window(size: UVec2, at: usize, radius: u32) -> impl Iterator<Item = (f32, usize)> {
    let scale = -0.5 * (BLUR_DEVIATIONS / radius as f32).powi(2);
    let middle = UVec2::new(at as u32 % size.x, at as u32 / size.x);
    let low = middle.saturating_sub(UVec2::splat(radius));
    let high = (middle + radius).min(size - 1);
    (low.y..=high.y).flat_map(move |y| (low.x..=high.x).map(move |x| UVec2::new(x, y))).map(
        move |texel| {
            let off = (texel.as_vec2() - middle.as_vec2()).length_squared();
            ((off * scale).exp(), (texel.y * size.x + texel.x) as usize)
        },
    )
}
