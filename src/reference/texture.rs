//! CPU reference of `wgsl/hit/texture.wgsl`: bilinear, repeating, row 0 at v = 0.
use crate::model::Texture;
use glam::{Vec2, Vec4};

/// A texture that is decoded to linear rgba where it is sampled.
#[derive(Clone, Debug)]
pub struct Image<'a> {
    /// Width [texels].
    width: i32,
    height: i32,
    texels: &'a [[u8; 4]],
    /// Linear values of the bytes of rgb.
    decoded: [f32; 256],
}

/// Linear value of an sRGB byte (IEC 61966-2-1).
fn linear_from_srgb(value: u8) -> f32 {
    let v = f32::from(value) / 255.0;
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

impl<'a> Image<'a> {
    pub fn new(texture: &'a Texture) -> Self {
        Self {
            width: texture.width as i32,
            height: texture.height as i32,
            texels: texture.rgba.as_chunks().0,
            decoded: std::array::from_fn(|v| linear_from_srgb(v as u8)),
        }
    }

    /// Samples linear rgba; texel `i` has its centre at `(i + 0.5) / size`.
    pub fn sample(&self, uv: Vec2) -> Vec4 {
        let size = Vec2::new(self.width as f32, self.height as f32);
        let at = (uv - uv.floor()) * size - 0.5;
        let low = at.floor();
        let part = at - low;
        let (x, y) = (low.x as i32, low.y as i32);
        let texel = |x: i32, y: i32| {
            let (x, y) = (x.rem_euclid(self.width), y.rem_euclid(self.height));
            let [r, g, b, a] = self.texels[(y * self.width + x) as usize];
            let [r, g, b] = [r, g, b].map(|channel| self.decoded[usize::from(channel)]);
            Vec4::new(r, g, b, f32::from(a) / 255.0)
        };
        let top = texel(x, y).lerp(texel(x + 1, y), part.x);
        let bottom = texel(x, y + 1).lerp(texel(x + 1, y + 1), part.x);
        top.lerp(bottom, part.y)
    }
}
