//! CPU reference of `wgsl/soften/`: softening of dithered shadows. The visibility behind dithered surfaces is
//! blurred over one window of their pattern and becomes a filter; depths are never blurred.
use super::{occlude::is_dithered, threads::each};
use glam::{BVec3, UVec2, Vec3};
use gobo::records::ViewMaps;

/// Weight of offset `i` in `-radius..=radius`: a window of `2 * radius` texels, with half weights at its
/// ends.
fn weight(i: i32, radius: i32) -> f32 {
    let whole = 0.5 / radius as f32;
    if i.abs() == radius { 0.5 * whole } else { whole }
}

/// Weights, coordinates and distances of a window's texels along one axis, clamped to the map.
pub(super) fn around(size: u32, at: u32, radius: i32) -> impl Iterator<Item = (f32, u32, u32)> {
    (-radius..=radius).map(move |i| {
        let place = (at as i32 + i).clamp(0, size as i32 - 1) as u32;
        (weight(i, radius), place, i.unsigned_abs())
    })
}

/// Dithered surfaces in a texel's window.
struct Window {
    /// Blocked share of the window, per channel.
    blocked: Vec3,
    /// Depth of the nearest dithered surface; 1 without one.
    nearest: f32,
    /// Depth behind the closest hole, along rows and columns; 1 without one.
    hole: f32,
}

impl Window {
    /// `depths`: opaque depths of a texel, per channel.
    fn of(depths: impl Fn(u32) -> [f32; 3], size: UVec2, at: UVec2, radius: i32) -> Self {
        let mut window = Self { blocked: Vec3::ZERO, nearest: 1.0, hole: 1.0 };
        let mut closest = u32::MAX;
        for (of_row, y, down) in around(size.y, at.y, radius) {
            for (weight, x, aside) in around(size.x, at.x, radius) {
                let depths = depths(y * size.x + x);
                let dithered = BVec3::from_array(depths.map(is_dithered));
                let depths = Vec3::from_array(depths);
                window.blocked += of_row * weight * Vec3::select(dithered, Vec3::ONE, Vec3::ZERO);
                let nearest = Vec3::select(dithered, depths, Vec3::ONE).min_element();
                window.nearest = window.nearest.min(nearest);
                if !dithered.all() && down + aside < closest {
                    // A surface that is not dithered has one depth, behind the dithered ones.
                    (closest, window.hole) = (down + aside, depths.max_element());
                }
            }
        }
        window
    }
}

/// Softens the light behind dithered surfaces; `window` as in [`gobo::model::dither::window`]. Depths per
/// channel become one.
pub fn soften(maps: &mut ViewMaps, window: u32) {
    let (radius, size) = ((window / 2) as i32, maps.view.size);
    if radius == 0 {
        return;
    }
    let colored = std::mem::take(&mut maps.colored);
    let depths = |at: u32| {
        let at = at as usize;
        colored.get(at).copied().unwrap_or([maps.opaque[at]; 3])
    };
    let windows = each(maps.filter.len(), |at| {
        Window::of(depths, size, UVec2::new(at as u32 % size.x, at as u32 / size.x), radius)
    });
    for (at, Window { blocked, nearest, hole }) in windows.into_iter().enumerate() {
        for (light, blocked) in maps.filter[at].iter_mut().zip(blocked.to_array()) {
            *light = if blocked > 0.0 { stored(*light * (1.0 - blocked)) } else { *light };
        }
        maps.nearest[at] = maps.nearest[at].min(nearest);
        if is_dithered(maps.opaque[at]) {
            maps.opaque[at] = hole;
        }
    }
}

pub(super) fn texels(size: UVec2) -> impl Iterator<Item = (u32, u32)> {
    (0..size.x * size.y).map(move |i| (i % size.x, i / size.x))
}

/// Rounded to the format of maps, and not negative.
pub(super) fn stored(light: f32) -> f32 {
    half::f16::from_f32(light.max(0.0)).to_f32()
}
