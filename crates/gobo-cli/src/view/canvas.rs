//! The pictures in the window.
use super::{
    pick::place,
    request::{Shown, receiver_name},
};
use eframe::egui::{Color32, FontId, Painter, Pos2, Rect, TextureHandle, pos2, vec2};
use gobo::glam::Vec2;

/// Paints the pictures, their names if there are two, and the picked point.
pub(super) fn paint(
    painter: &Painter,
    rect: Rect,
    textures: &[TextureHandle],
    shown: &Shown,
    marked: Option<Vec2>,
) {
    let all = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    let count = textures.len();
    for (index, texture) in textures.iter().enumerate() {
        let part = part(rect, index, count);
        painter.image(texture.id(), part, all, Color32::WHITE);
        if let Some(at) = marked {
            let center = part.min + part.size() * vec2(at.x, at.y);
            painter.circle_stroke(center, 6.0, (3.0, Color32::BLACK));
            painter.circle_stroke(center, 6.0, (1.5, Color32::WHITE));
        }
        if let (2.., Some((receiver, _))) = (count, shown.pictures.get(index)) {
            let text = receiver_name(*receiver);
            let font = FontId::proportional(15.0);
            let layout = painter.layout_no_wrap(text.to_owned(), font, Color32::WHITE);
            let corner: Pos2 = part.left_top() + vec2(10.0, 8.0);
            let back = Rect::from_min_size(corner, layout.size()).expand(4.0);
            painter.rect_filled(back, 3.0, Color32::from_black_alpha(170));
            painter.galley(corner, layout, Color32::WHITE);
        }
    }
    if count > 1 {
        let color = Color32::from_gray(90);
        painter.vline(rect.center().x, rect.y_range(), (1.0, color));
    }
}

/// Position of the picked point in the picture, right and down, 0..1.
pub(super) fn marked(shown: &Shown) -> Option<Vec2> {
    let [at, _] = shown.picked.as_ref()?.surface?;
    place(&shown.camera, at)
}

/// Rectangle of one of several pictures side by side.
pub(super) fn part(rect: Rect, index: usize, count: usize) -> Rect {
    let width = rect.width() / count as f32;
    let min = rect.min + vec2(width * index as f32, 0.0);
    Rect::from_min_size(min, vec2(width, rect.height()))
}
