//! Shadow maps as small pictures.
use eframe::egui::{Color32, ColorImage};
use gobo::glam::Vec3;
use gobo_picture::ViewMaps;

/// Longest edge of a picture [pixels].
const EDGE: usize = 160;
/// Colour of texels without a depth.
const NOTHING: Color32 = Color32::from_rgb(24, 34, 58);

/// Maps of one view.
#[derive(Clone)]
pub(super) struct Inset {
    pub(super) view: &'static str,
    /// Size of the view's map [texels].
    pub(super) size: [u32; 2],
    /// Images of the filter, the nearest depth and the opaque depth.
    pub(super) pictures: [ColorImage; 3],
}

pub(super) const NAMES: [&str; 3] = ["filter F", "nearest D", "opaque Z"];

impl Inset {
    pub(super) fn of(maps: &ViewMaps) -> Self {
        let size = [maps.view.size.x, maps.view.size.y];
        let filter = smaller(size, |texels| {
            let sum: Vec3 = texels.iter().map(|&t| Vec3::from(maps.filter[t])).sum();
            let mean = sum / texels.len() as f32;
            let [r, g, b] = mean.to_array().map(to_srgb);
            Color32::from_rgb(r, g, b)
        });
        let depths = [&maps.nearest, &maps.opaque].map(|depths| depth_picture(size, depths));
        let [nearest, opaque] = depths;
        Self { view: maps.view.name, size, pictures: [filter, nearest, opaque] }
    }
}

/// Image of depths: the nearest is white, the farthest dark.
fn depth_picture(size: [u32; 2], depths: &[f32]) -> ColorImage {
    let there = || depths.iter().copied().filter(|&depth| depth < 1.0);
    let (first, last) = there().fold((1.0_f32, 0.0_f32), |(a, b), d| (a.min(d), b.max(d)));
    let range = (last - first).max(1e-6);
    smaller(size, |texels| {
        let nearest = texels.iter().map(|&t| depths[t]).fold(1.0, f32::min);
        match nearest {
            1.0 => NOTHING,
            depth => Color32::from_gray((255.0 - 215.0 * (depth - first) / range) as u8),
        }
    })
}

/// Reduced image of a map; `pixel`: colour for the texels of a pixel.
fn smaller(size: [u32; 2], pixel: impl Fn(&[usize]) -> Color32) -> ColorImage {
    let [width, height] = size.map(|edge| edge as usize);
    let step = width.max(height).div_ceil(EDGE).max(1);
    let small = [width, height].map(|edge| edge.div_ceil(step));
    let mut texels = Vec::with_capacity(step * step);
    let mut pixels = Vec::with_capacity(small[0] * small[1]);
    for y in 0..small[1] {
        for x in 0..small[0] {
            texels.clear();
            for row in y * step..((y + 1) * step).min(height) {
                texels.extend((x * step..((x + 1) * step).min(width)).map(|c| row * width + c));
            }
            pixels.push(pixel(&texels));
        }
    }
    ColorImage::new(small, pixels)
}

/// `linear`: clamped to 0..=1.
pub(super) fn to_srgb(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let curve =
        if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (curve * 255.0 + 0.5) as u8
}
