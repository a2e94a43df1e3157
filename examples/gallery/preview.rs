//! Previews: small pictures, maps, and the contact sheet.
use crate::{Fallible, Plate};
use gobo_picture::{Picture, ViewMaps};
use image::{
    Rgb, RgbImage,
    imageops::{self, FilterType},
};

/// Width of a picture on the contact sheet [pixels].
const THUMB: u32 = 480;
const COLUMNS: u32 = 3;
const GAP: u32 = 8;
/// An inset's share of the picture's width.
const INSET: u32 = 4;
/// Edge of a map's preview [pixels].
const MAP: u32 = 160;

pub(super) fn image(picture: &Picture) -> Fallible<RgbImage> {
    let bytes = picture.rgb.as_flattened().to_vec();
    let image = RgbImage::from_raw(picture.size.x, picture.size.y, bytes);
    image.ok_or_else(|| "a picture without all its pixels".into())
}

/// All pictures, rows from the top, on black.
pub(super) fn contact_sheet(plates: &[Plate]) -> RgbImage {
    let thumbs = plates.iter().map(|plate| thumb(&plate.image, THUMB)).collect::<Vec<RgbImage>>();
    let height = thumbs.iter().map(RgbImage::height).max().unwrap_or(1);
    let rows = (thumbs.len() as u32).div_ceil(COLUMNS);
    let mut sheet = RgbImage::new(COLUMNS * (THUMB + GAP) + GAP, rows * (height + GAP) + GAP);
    for (i, thumb) in (0..).zip(&thumbs) {
        let (column, row) = (i % COLUMNS, i / COLUMNS);
        let place = (GAP + column * (THUMB + GAP), GAP + row * (height + GAP));
        imageops::replace(&mut sheet, thumb, i64::from(place.0), i64::from(place.1));
    }
    sheet
}

/// Puts the first mask, at the left of the debug picture, into the picture's lower left corner.
pub(super) fn inset(image: &mut RgbImage, masks: &RgbImage) {
    let (width, height) = image.dimensions();
    let mask = imageops::crop_imm(masks, 0, 0, width, height).to_image();
    let small = thumb(&mask, width / INSET);
    let mut framed = RgbImage::from_pixel(small.width() + 4, small.height() + 4, Rgb([20; 3]));
    imageops::replace(&mut framed, &small, 2, 2);
    let top = height - framed.height() - 2 * GAP;
    imageops::replace(image, &framed, (2 * GAP).into(), top.into());
}

pub(super) fn thumb(image: &RgbImage, width: u32) -> RgbImage {
    let height = (image.height() * width).div_ceil(image.width());
    imageops::resize(image, width, height, FilterType::Triangle)
}

/// The filter map `F` as light on white, small.
pub(super) fn filter(maps: &ViewMaps) -> RgbImage {
    let [width, height] = maps.view.size.to_array();
    let image = RgbImage::from_fn(width, height, |x, y| {
        Rgb(maps.filter[(y * width + x) as usize].map(srgb))
    });
    thumb(&image, MAP)
}

/// The nearest translucent depth, dark where it is near, small.
pub(super) fn nearest(maps: &ViewMaps) -> RgbImage {
    let [width, height] = maps.view.size.to_array();
    let seen = maps.nearest.iter().copied().filter(|&depth| depth < 1.0);
    let (low, high) =
        seen.fold((1.0_f32, 0.0_f32), |(low, high), depth| (low.min(depth), high.max(depth)));
    let grey = |depth: f32| match depth {
        1.0.. => 255,
        _ => ((depth - low) / (high - low).max(f32::MIN_POSITIVE) * 204.0) as u8,
    };
    let image = RgbImage::from_fn(width, height, |x, y| {
        Rgb([grey(maps.nearest[(y * width + x) as usize]); 3])
    });
    thumb(&image, MAP)
}

fn srgb(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded =
        if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}
