//! The shadow masks of a picture.
use crate::{error::Error, gpu::Gpu, picture::PreparedPicture, records::Picture};
use glam::UVec2;

/// Masks below each other: their first three channels as red, green and blue, and beside these the fourth. A
/// picture without masks is black. Blocks.
pub(crate) fn masks(
    gpu: &Gpu,
    prepared: &PreparedPicture,
    picture: &Picture,
) -> Result<Picture, Error> {
    let masks = prepared.read_masks(gpu)?;
    let (width, pixels) = (picture.size.x as usize, picture.rgb.len());
    let layers = (masks.len() / pixels.max(1)).max(1);
    let mut rgb = Vec::with_capacity(2 * pixels * layers);
    for row in 0..picture.size.y as usize * layers {
        let row = masks.get(row * width..(row + 1) * width);
        let texels = |i: usize| row.map_or([0; 4], |row| row[i]);
        rgb.extend((0..width).map(texels).map(|[r, g, b, _]| [r, g, b]));
        rgb.extend((0..width).map(texels).map(|[.., a]| [a; 3]));
    }
    let size = picture.size * UVec2::new(2, layers as u32);
    Ok(Picture { size, rgb, light: Vec::new() })
}
