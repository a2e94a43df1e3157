//! Images as uploaded: each with means over ever larger squares of texels, so that a picture filters the area
//! that a sample sees (Williams 1983, "Pyramidal Parametrics").
use crate::model::Texture;
use glam::{UVec2, Vec2, Vec3, Vec4};

/// Most taps along the longer side of the area that a sample of the picture sees of an image.
pub const MAX_IMAGE_TAPS: u32 = 4;

/// Weight below which the last tap of an area is rounding alone.
pub const LEAST_TAP: f32 = 1e-5;

/// Weight of the colour of clear texels in means that are weighted by alpha: just enough that an image
/// without any opacity has a colour.
pub const CLEAR_WEIGHT: f32 = 1.0 / 65536.0;

/// A level of an image: level 0 is the image, and each is half as large as the one before, rounded down.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImageLevel {
    /// Texels.
    pub size: UVec2,
    /// Rgba bytes as in [`Texture::rgba`].
    pub rgba: Vec<u8>,
}

/// Levels of an image of `size`, down to one texel.
pub fn image_level_count(size: UVec2) -> u32 {
    size.max_element().max(1).ilog2() + 1
}

/// Size of a level of an image of `size` \[texels\].
pub fn image_level_size(size: UVec2, level: u32) -> UVec2 {
    (size >> level).max(UVec2::ONE)
}

/// Linear value of an sRGB byte (IEC 61966-2-1).
pub fn linear_from_srgb(value: u8) -> f32 {
    linear_value(f32::from(value))
}

fn linear_value(byte: f32) -> f32 {
    let v = byte / 255.0;
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// Coarser levels of a texture: means of light, weighted by opacity, since clear texels are invisible.
pub fn image_levels(texture: &Texture) -> Vec<ImageLevel> {
    let linear: [f32; 256] = std::array::from_fn(|byte| linear_from_srgb(byte as u8));
    // Linear values at which the nearest byte becomes the next.
    let steps: [f32; 255] = std::array::from_fn(|byte| linear_value(byte as f32 + 0.5));
    let byte = |value: f32| steps.partition_point(|&step| step <= value) as u8;
    let whole = UVec2::new(texture.width, texture.height);
    let mut levels: Vec<ImageLevel> = Vec::new();
    for level in 1..image_level_count(whole) {
        let (from, texels) =
            levels.last().map_or((whole, &texture.rgba), |last| (last.size, &last.rgba));
        let (texels, size) = (texels.as_chunks().0, image_level_size(whole, level));
        let across: Vec<_> = (0..size.x).map(|x| covered(x, from.x, size.x)).collect();
        let mut rgba = Vec::with_capacity(4 * size.element_product() as usize);
        for y in 0..size.y {
            let down = covered(y, from.y, size.y);
            for columns in &across {
                // Rgb times its weight, and alpha.
                let mut sum = Vec4::ZERO;
                for (row, of_row) in down.iter() {
                    for (column, of_column) in columns.iter() {
                        let [r, g, b, a]: [u8; 4] = texels[(row * from.x + column) as usize];
                        let alpha = f32::from(a) / 255.0;
                        let rgb = [r, g, b].map(|c| linear[usize::from(c)]);
                        let texel = (Vec3::from_array(rgb) * (alpha + CLEAR_WEIGHT)).extend(alpha);
                        sum += texel * (of_row * of_column);
                    }
                }
                let color = sum.truncate() / (sum.w + CLEAR_WEIGHT);
                rgba.extend(color.to_array().map(byte));
                rgba.push((sum.w * 255.0).round() as u8);
            }
        }
        levels.push(ImageLevel { size, rgba });
    }
    levels
}

/// Texels of a level along an axis that a texel of the next one covers, with their shares: two, or three of
/// an odd number.
struct Covered {
    first: u32,
    shares: [f32; 3],
}

impl Covered {
    fn iter(&self) -> impl Iterator<Item = (u32, f32)> + use<> {
        (self.first..).zip(self.shares).filter(|&(_, share)| share > 0.0)
    }
}

/// The texels that texel `i` of `to` covers of `from`.
fn covered(i: u32, from: u32, to: u32) -> Covered {
    let scale = from as f32 / to as f32;
    let (start, end) = (i as f32 * scale, ((i + 1) as f32 * scale).min(from as f32));
    let first = start as u32;
    let share = |texel: f32| ((end.min(texel + 1.0) - start.max(texel)) / scale).max(0.0);
    Covered { first, shares: [0.0, 1.0, 2.0].map(|next| share(first as f32 + next)) }
}

/// Area of a sample of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageDetail {
    /// Edge of the sample's square \[pixels\].
    pub reach: f32,
    /// Mean opacity from which a cutout is solid where its texels are smaller than that square: it differs
    /// between samples, so that in their mean the solid share is the texels' coverage.
    pub threshold: f32,
}

impl ImageDetail {
    /// Detail of a picture with `samples` per pixel; `offset`: of the sample \[pixels\].
    pub fn new(samples: u32, offset: Vec2) -> Self {
        Self {
            reach: 1.0 / (samples.max(1) as f32).sqrt(),
            threshold: (offset.x + 0.5).clamp(0.05, 0.95),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(width: u32, height: u32, rgba: Vec<u8>) -> Texture {
        Texture { name: String::new(), width, height, rgba }
    }

    #[test]
    fn levels_are_means_of_light() {
        let chart = [[0, 0, 0, 255], [255, 255, 255, 255]].concat().repeat(6);
        let levels = image_levels(&texture(4, 3, chart));
        let sizes: Vec<_> = levels.iter().map(|level| level.size.to_array()).collect();
        assert_eq!(sizes, [[2, 1], [1, 1]]);
        // Half the light is 188 in sRGB, not 128.
        assert_eq!(levels[0].rgba, [188, 188, 188, 255].repeat(2));
        assert_eq!(levels[1].rgba, [188, 188, 188, 255]);
    }

    #[test]
    fn odd_sizes_count_each_texel_alike() {
        let row = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]].concat();
        // A third of the light.
        assert_eq!(image_levels(&texture(3, 1, row))[0].rgba, [156, 156, 156, 255]);
    }

    #[test]
    fn what_is_clear_has_no_colour() {
        let leaf = [[200, 40, 10, 255], [0, 255, 255, 0]].concat();
        assert_eq!(image_levels(&texture(2, 1, leaf))[0].rgba, [200, 40, 10, 128]);
    }
}
