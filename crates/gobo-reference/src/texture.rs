//! CPU reference of `wgsl/hit/texture.wgsl`: bilinear, repeating, row 0 at v = 0; in the picture trilinear,
//! over the footprint of a sample.
use glam::{UVec2, Vec2, Vec3, Vec4};
use gobo::{
    model::Texture,
    records::{
        CLEAR_WEIGHT, ImageLevel, LEAST_TAP, MAX_IMAGE_TAPS, image_level_count, image_level_size,
        image_levels, linear_from_srgb,
    },
};
use std::sync::OnceLock;

/// A texture that is decoded to linear rgba where it is sampled.
#[derive(Clone, Debug)]
pub struct Image<'a> {
    texture: &'a Texture,
    /// Linear value of each byte of rgb.
    decoded: [f32; 256],
    /// Coarser mip levels, made on demand.
    levels: OnceLock<Vec<ImageLevel>>,
}

/// A sample over a footprint in an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampled {
    /// Linear rgba.
    pub rgba: Vec4,
    /// Mip level of the texels that were read.
    pub level: f32,
}

impl<'a> Image<'a> {
    /// An image whose levels are made when they are first read.
    pub fn new(texture: &'a Texture) -> Self {
        let decoded = std::array::from_fn(|v| linear_from_srgb(v as u8));
        Self { texture, decoded, levels: OnceLock::new() }
    }

    fn size(&self) -> UVec2 {
        UVec2::new(self.texture.width, self.texture.height)
    }

    /// Samples linear rgba; texel `i` has its centre at `(i + 0.5) / size`. `shows_clear`: whether all
    /// colours count alike; else they are weighted by alpha.
    pub fn sample(&self, uv: Vec2, shows_clear: bool) -> Vec4 {
        unweighted(self.sample_level(uv, 0, shows_clear), shows_clear)
    }

    /// Mean of texels whose colours are multiplied by their weight.
    fn sample_level(&self, uv: Vec2, level: u32, shows_clear: bool) -> Vec4 {
        let size = image_level_size(self.size(), level).as_ivec2();
        let rgba = match level {
            0 => &self.texture.rgba,
            _ => {
                let levels = self.levels.get_or_init(|| image_levels(self.texture));
                &levels[level as usize - 1].rgba
            }
        };
        let (texels, _) = rgba.as_chunks();
        let at = (uv - uv.floor()) * size.as_vec2() - 0.5;
        let low = at.floor();
        let part = at - low;
        let (x, y) = (low.x as i32, low.y as i32);
        let texel = |x: i32, y: i32| {
            let (x, y) = (x.rem_euclid(size.x), y.rem_euclid(size.y));
            let [r, g, b, a] = texels[(y * size.x + x) as usize];
            let [r, g, b] = [r, g, b].map(|channel: u8| self.decoded[usize::from(channel)]);
            let alpha = f32::from(a) / 255.0;
            (Vec3::new(r, g, b) * color_weight(alpha, shows_clear)).extend(alpha)
        };
        let top = texel(x, y).lerp(texel(x + 1, y), part.x);
        let bottom = texel(x, y + 1).lerp(texel(x + 1, y + 1), part.x);
        top.lerp(bottom, part.y)
    }

    /// Mean over the footprint of a sample: a parallelogram of the sides `right` and `down` \[uv\] around
    /// `uv`, by taps along the longer side, each from the mip level whose texels have the size of the shorter
    /// one, or of a tap's share of the longer one if that is more ("Feline", 1999). The last tap has what is
    /// left of the side.
    pub fn sample_area(&self, uv: Vec2, right: Vec2, down: Vec2, shows_clear: bool) -> Sampled {
        let size = self.size().as_vec2();
        let lengths = [(right * size).length(), (down * size).length()];
        let is_right = lengths[0] >= lengths[1];
        let long = lengths[0].max(lengths[1]);
        let short = lengths[0].min(lengths[1]);
        let along = if is_right { right } else { down };
        let ratio = (long / short.max(1.0)).clamp(1.0, MAX_IMAGE_TAPS as f32);
        let last = (image_level_count(self.size()) - 1) as f32;
        let level = (long / ratio).log2().clamp(0.0, last);
        let (low, part) = (level as u32, level.fract());
        let mut rgba = Vec4::ZERO;
        let (end, of_tap, mut left) = (uv + 0.5 * along, 1.0 / ratio, 1.0_f32);
        while left > LEAST_TAP {
            let weight = left.min(of_tap);
            let at = end - along * (left - 0.5 * weight);
            let mut texel = self.sample_level(at, low, shows_clear);
            if part > 0.0 {
                texel = texel.lerp(self.sample_level(at, low + 1, shows_clear), part);
            }
            rgba += weight * texel;
            left -= of_tap;
        }
        Sampled { rgba: unweighted(rgba, shows_clear), level }
    }
}

fn color_weight(alpha: f32, shows_clear: bool) -> f32 {
    if shows_clear { 1.0 } else { alpha + CLEAR_WEIGHT }
}

fn unweighted(mean: Vec4, shows_clear: bool) -> Vec4 {
    (mean.truncate() / color_weight(mean.w, shows_clear)).extend(mean.w)
}
