//! Windows of maps in 64 bits, by the formulas of docs/soft.md and docs/dither.md: sums over all texels of a
//! window.
use gobo::{
    glam::{DVec3, UVec2, Vec3},
    records::ViewMaps,
};

/// Offsets and indices of a window's texels; `None` outside the map.
fn window(
    size: UVec2,
    at: usize,
    radius: i32,
) -> impl Iterator<Item = ([i32; 2], [i32; 2], Option<usize>)> {
    let size = size.as_ivec2();
    let middle = [at as i32 % size.x, at as i32 / size.x];
    let offsets = (-radius..=radius).flat_map(move |j| (-radius..=radius).map(move |i| [i, j]));
    offsets.map(move |off| {
        let [x, y] = [middle[0] + off[0], middle[1] + off[1]];
        let is_on = (0..size.x).contains(&x) && (0..size.y).contains(&y);
        (off, [x, y], is_on.then_some((y * size.x + x) as usize))
    })
}

/// Gaussian mean over the window of a texel, two standard deviations each way, of the map's texels for which
/// `sees` is true.
pub(crate) fn gaussian(
    size: UVec2,
    at: usize,
    radius: i32,
    light: impl Fn(usize) -> Vec3,
    sees: impl Fn(usize) -> bool,
) -> DVec3 {
    let (mut sum, mut all) = (DVec3::ZERO, 0.0);
    for ([i, j], _, texel) in window(size, at, radius) {
        let Some(texel) = texel.filter(|&texel| sees(texel)) else { continue };
        let deviations = 2.0 * f64::from(i * i + j * j).sqrt() / f64::from(radius);
        let weight = (-0.5 * deviations * deviations).exp();
        sum += weight * light(texel).as_dvec3();
        all += weight;
    }
    if all > 0.0 { sum / all } else { DVec3::ONE }
}

/// Least depth of a window's texels in the map.
pub(crate) fn least(size: UVec2, at: usize, radius: i32, depth: impl Fn(usize) -> f32) -> f32 {
    window(size, at, radius).filter_map(|(.., texel)| texel).map(depth).fold(1.0, f32::min)
}

/// Light of a texel in a softened map, and its nearest and opaque depth. The last bit of an opaque depth
/// marks a dithered surface; outside the map, the texels of its border count.
pub(crate) fn softened(maps: &ViewMaps, at: usize, radius: i32) -> (DVec3, f32, f32) {
    let size = maps.view.size;
    let end = size.as_ivec2() - 1;
    let (mut share, mut nearest, mut hole, mut closest) = (0.0, maps.nearest[at], 1.0, i32::MAX);
    for (off, [x, y], _) in window(size, at, radius) {
        let texel = (y.clamp(0, end.y) * (end.x + 1) + x.clamp(0, end.x)) as usize;
        let depth = maps.opaque[texel];
        let weight = |i: i32| if i.abs() == radius { 0.25 } else { 0.5 } / f64::from(radius);
        let away = off[0].abs() + off[1].abs();
        if depth.to_bits() & 1 == 1 {
            share += weight(off[0]) * weight(off[1]);
            nearest = nearest.min(depth);
        } else if away < closest {
            (closest, hole) = (away, depth);
        }
    }
    let light = Vec3::from(maps.filter[at]).as_dvec3() * (1.0 - share);
    let is_dithered = maps.opaque[at].to_bits() & 1 == 1;
    (light, nearest, if is_dithered { hole } else { maps.opaque[at] })
}
