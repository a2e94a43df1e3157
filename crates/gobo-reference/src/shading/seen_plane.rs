//! CPU reference of `wgsl/shade/seen_plane.wgsl`: the surface under a point without a normal, estimated from
//! a map's depths around it.
use glam::{Vec2, Vec3};
use gobo::records::{GpuView, ViewMaps};

/// Distances from the point of the rings of samples, nearest first \[texels\].
pub const FIRST_RING: f32 = 2.0;
/// Largest distance from the point of texels that are asked \[texels\].
pub const LAST_RING: f32 = 54.0;
/// Each distance over the one before.
pub const NEXT_RING: f32 = 3.0;
/// Directions of a ring's samples.
const AROUND: [Vec2; 8] = [
    Vec2::X,
    Vec2::NEG_X,
    Vec2::Y,
    Vec2::NEG_Y,
    Vec2::ONE,
    Vec2::new(-1.0, 1.0),
    Vec2::new(1.0, -1.0),
    Vec2::NEG_ONE,
];
/// Texels of a ring that must lie on the plane.
pub const LEAST_ON_PLANE: u32 = 4;
/// Texels over which the plane may change by as much as a surface on it is off.
pub const ROUGH: f32 = 0.0625;

/// Normal of the plane, view space, of any length and side; zero where the map shows none. `point`: view
/// space; `bias`: tolerance of a surface on the plane \[m\].
pub(super) fn seen_normal(view: &GpuView, maps: &ViewMaps, point: Vec3, bias: f32) -> Vec3 {
    let is_perspective = view.perspective > 0.0;
    // Depth is linear in the texel in a parallel view, its inverse in a perspective one.
    let linear = |depth: f32| if is_perspective { 1.0 / depth.max(1e-6) } else { depth };
    let at_point = linear(-point.z);
    let spread = view.scale / if is_perspective { (-point.z).max(1e-6) } else { 1.0 };
    let center = Vec2::new(point.x, -point.y) * spread;
    let slack = bias * if is_perspective { at_point * at_point } else { 1.0 };
    // Offset from the point [texels], and the depth of its surface relative to the point.
    let seen = |offset: Vec2| {
        let texel = (center + view.size * 0.5 + offset).floor();
        let texel = texel.clamp(Vec2::ZERO, view.size - 1.0);
        let i = (texel.y * view.size.x + texel.x) as usize;
        let depth = maps
            .colored
            .get(i)
            .map_or(maps.opaque[i], |depths| depths.iter().fold(0.0, |a, b| b.max(a)));
        let off = linear(view.near + depth * (view.far - view.near)) - at_point;
        (depth < 1.0).then(|| (texel + 0.5 - view.size * 0.5 - center).extend(off))
    };
    let rings = std::iter::successors(Some(FIRST_RING), |ring| Some(ring * NEXT_RING));
    for ring in rings.take_while(|ring| *ring <= LAST_RING) {
        let around: Vec<_> = AROUND.iter().filter_map(|&to| seen(to * ring)).collect();
        let Some(by_texel) = change_by_texel(&around, ring) else { continue };
        let most_off = slack + ROUGH * by_texel.abs().element_sum();
        let is_on = |seen: &&Vec3| (seen.z - by_texel.dot(seen.truncate())).abs() <= most_off;
        if around.iter().filter(is_on).count() >= LEAST_ON_PLANE as usize {
            let across = Vec2::new(-by_texel.x, by_texel.y) * view.scale;
            return if is_perspective {
                across.extend(at_point - by_texel.dot(center))
            } else {
                (-across).extend(1.0)
            };
        }
    }
    Vec3::ZERO
}

/// Change of the plane through the point and two of the surfaces around it, in different directions, that are
/// least off: surfaces that hide it are far off.
fn change_by_texel(around: &[Vec3], ring: f32) -> Option<Vec2> {
    let least_off = |a: &&Vec3, b: &&Vec3| a.z.abs().total_cmp(&b.z.abs());
    let first = around.iter().min_by(least_off)?;
    let across = |other: &Vec3| first.truncate().perp_dot(other.truncate());
    // For opposite texels it is at most `ring`.
    let second = around.iter().filter(|other| across(other).abs() > ring).min_by(least_off)?;
    let turned =
        Vec2::new(first.z * second.y - second.z * first.y, second.z * first.x - first.z * second.x);
    Some(turned / across(second))
}
