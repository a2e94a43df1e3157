//! Debug picture of the shadow atlas.
use glam::{UVec2, Vec3};
use gobo::{
    Error,
    gpu::Gpu,
    model::{TILE_SIZE, View, tiles_of},
    records::Picture,
    shadows::Maps,
};
use half::f16;

/// Longest edge of a layer in the picture \[pixels\].
const EDGE: u32 = 1024;
const FREE: [u8; 3] = [24, 24, 30];
const BORDER: [u8; 3] = [255, 120, 40];

/// The layers beside each other: every map's filter, darker the nearer its opaque depth, within a border;
/// free texels are dark. Blocks.
pub(crate) fn atlas(gpu: &Gpu, maps: &Maps, views: &[View]) -> Result<Picture, Error> {
    let filters: Vec<[u16; 4]> = gpu.try_read_texture(&maps.filters)?;
    let opaques: Vec<f32> = gpu.try_read_texture(&maps.opaques)?;
    let layer = maps.filters.size();
    let step = layer.width.max(layer.height).div_ceil(EDGE).max(1);
    let shown = UVec2::new(layer.width, layer.height) / step;
    let layers = layer.depth_or_array_layers;
    let columns = (1..=layers).find(|columns| columns * columns >= layers).unwrap_or(1);
    let size = shown * UVec2::new(columns, layers.div_ceil(columns));
    let rgb = vec![FREE; size.element_product() as usize];
    let mut image = Picture { size, rgb, light: Vec::new() };
    for (view, slot) in views.iter().zip(&maps.slots) {
        let corner = shown * UVec2::new(slot.layer % columns, slot.layer / columns);
        let rectangle = tiles_of(view.size) * TILE_SIZE;
        let (first, last) = (slot.origin / step, (slot.origin + rectangle) / step);
        for y in first.y..last.y.min(shown.y) {
            for x in first.x..last.x.min(shown.x) {
                let at = UVec2::new(x, y);
                let edge = at.cmpeq(first).any() || (at + 1).cmpeq(last).any();
                let texel = (at * step).min(slot.origin + view.size - 1);
                let index =
                    ((slot.layer * layer.height + texel.y) * layer.width + texel.x) as usize;
                let pixel = corner + at;
                image.rgb[(pixel.y * size.x + pixel.x) as usize] =
                    if edge { BORDER } else { color(filters[index], opaques[index]) };
            }
        }
    }
    Ok(image)
}

fn color(filter: [u16; 4], opaque: f32) -> [u8; 3] {
    let [r, g, b, _] = filter.map(|bits| f16::from_bits(bits).to_f32());
    let light = Vec3::new(r, g, b).clamp(Vec3::ZERO, Vec3::ONE) * (0.25 + 0.75 * opaque);
    (light.powf(1.0 / 2.2) * 255.0).round().to_array().map(|v| v as u8)
}
