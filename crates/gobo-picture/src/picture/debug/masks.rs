//! The shadow masks of a picture.
use crate::picture::PreparedPicture;
use glam::UVec2;
use gobo::{
    Error,
    gpu::Gpu,
    records::{COLORED_BIT, Picture, SLOTS},
};

/// Image of the masks, one below the other: their first three channels as red, green and blue, and the fourth
/// beside them. Channels without a light are black. Blocks.
pub(crate) fn masks(
    gpu: &Gpu,
    prepared: &PreparedPicture,
    picture: &Picture,
) -> Result<Picture, Error> {
    let masks = prepared.read_masks(gpu)?;
    let slots = &prepared.slots().of_lights;
    let is_used = |channel: u32| {
        let is_shown = |slot: u32| match slot & COLORED_BIT {
            0 => slot == channel + 1,
            _ => (slot & !COLORED_BIT) == channel / SLOTS * SLOTS + 1 && channel % SLOTS < 3,
        };
        slots.iter().any(|&slot| is_shown(slot))
    };
    let (width, pixels) = (picture.size.x as usize, picture.rgb.len());
    let layers = (masks.len() / pixels.max(1)).max(1);
    let mut rgb = Vec::with_capacity(2 * pixels * layers);
    for row in 0..picture.size.y as usize * layers {
        let first = (row / picture.size.y as usize) as u32 * SLOTS;
        let used = [0, 1, 2, 3].map(|channel| is_used(first + channel));
        let row = masks.get(row * width..(row + 1) * width);
        let texels = |i: usize| {
            let texel = row.map_or([0; 4], |row| row[i]);
            [0, 1, 2, 3].map(|channel| if used[channel] { texel[channel] } else { 0 })
        };
        rgb.extend((0..width).map(texels).map(|[r, g, b, _]| [r, g, b]));
        rgb.extend((0..width).map(texels).map(|[.., a]| [a; 3]));
    }
    let size = picture.size * UVec2::new(2, layers as u32);
    Ok(Picture { size, rgb, light: Vec::new() })
}
