//! A heat map over a picture's luminance, with a legend.
use super::letters;
use glam::{UVec2, Vec3};
use gobo::records::Picture;

/// Value of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Heat {
    /// No value: grey.
    None,
    Value(u32),
    /// A value past a capacity: magenta.
    Overflow(u32),
}

/// sRGB from cold to hot: dark at both ends would hide the picture below.
const RAMP: [[u8; 3]; 6] =
    [[38, 44, 120], [30, 130, 200], [50, 190, 110], [235, 215, 60], [235, 90, 35], [190, 20, 40]];
const OVERFLOW: [u8; 3] = [255, 0, 255];
const WHITE: [u8; 3] = [255; 3];

/// Colour of the ramp at 0 to 1.
fn ramp(share: f32) -> [u8; 3] {
    let position = share.clamp(0.0, 1.0) * (RAMP.len() - 1) as f32;
    let i = (position as usize).min(RAMP.len() - 2);
    let [from, to] = [RAMP[i], RAMP[i + 1]].map(|c| Vec3::from(c.map(f32::from)));
    from.lerp(to, position - i as f32).to_array().map(|v| v.round() as u8)
}

/// Rounds up to 1, 2 or 5 times a power of ten, at least 10.
fn round_up(value: u32) -> u32 {
    let decades = (1..9).map(|power| 10_u32.pow(power));
    let mut ends = decades.flat_map(|decade| [decade, 2 * decade, 5 * decade]);
    ends.find(|&end| end >= value).unwrap_or(value)
}

/// Draws `values` over `picture`, with a legend below.
pub(super) fn draw(picture: &Picture, values: &[Heat], title: &str) -> Picture {
    let most = values.iter().map(|value| match value {
        Heat::Value(value) => *value,
        Heat::None | Heat::Overflow(_) => 0,
    });
    let end = round_up(most.max().unwrap_or(0));
    let overflow = values.iter().find_map(|value| match value {
        Heat::Overflow(value) => Some(*value),
        Heat::None | Heat::Value(_) => None,
    });
    let pixels = picture.rgb.iter().zip(values).map(|(&rgb, value)| {
        let [r, g, b] = rgb.map(f32::from);
        let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let color = match *value {
            Heat::None => return [(0.5 * luminance) as u8; 3],
            Heat::Value(value) => ramp(value as f32 / end as f32),
            Heat::Overflow(_) => OVERFLOW,
        };
        // Half of the colour shows, however dark the picture.
        color.map(|c| (f32::from(c) * (0.5 + 0.5 * luminance / 255.0)) as u8)
    });
    let mut image = Picture { size: picture.size, rgb: pixels.collect(), light: Vec::new() };
    legend(&mut image, title, end, overflow);
    image
}

fn legend(image: &mut Picture, title: &str, end: u32, overflow: Option<u32>) {
    // Pixels of a letter's dot.
    let dot = if image.size.x >= 480 { 2 } else { 1 };
    let advance = (letters::SIZE[0] + 1) * dot;
    let line = (letters::SIZE[1] + 2) * dot;
    let bar = UVec2::new(80 * dot, 6 * dot);
    let margin = 4 * dot;
    let rows = 2 + u32::from(overflow.is_some());
    let width = bar.x.max(title.len() as u32 * advance) + 2 * margin;
    let height = rows * line + bar.y + 2 * margin;
    let corner = UVec2::new(margin, image.size.y.saturating_sub(height + margin));
    fill(image, corner, UVec2::new(width, height), |_| [16, 16, 20]);
    let mut at = corner + margin;
    text(image, at, dot, title, WHITE);
    at.y += line;
    fill(image, at, bar, |x| ramp(x as f32 / (bar.x - 1) as f32));
    at.y += bar.y + dot;
    for (part, value) in [(0, 0), (1, end / 2), (2, end)] {
        let label = value.to_string();
        let back = label.len() as u32 * advance * part / 2;
        text(image, at + UVec2::new(bar.x * part / 2 - back, 0), dot, &label, WHITE);
    }
    if let Some(all) = overflow {
        at.y += line;
        text(image, at, dot, &format!("NO ROOM: ALL {all}"), OVERFLOW);
    }
}

/// Fills a box with colours by column, clipped to the image.
fn fill(image: &mut Picture, corner: UVec2, size: UVec2, color: impl Fn(u32) -> [u8; 3]) {
    let end = (corner + size).min(image.size);
    for y in corner.y..end.y {
        for x in corner.x..end.x {
            image.rgb[(y * image.size.x + x) as usize] = color(x - corner.x);
        }
    }
}

fn text(image: &mut Picture, corner: UVec2, dot: u32, text: &str, color: [u8; 3]) {
    for (i, letter) in (0..).zip(text.chars()) {
        let left = corner + UVec2::new(i * (letters::SIZE[0] + 1) * dot, 0);
        for y in 0..letters::SIZE[1] {
            for x in 0..letters::SIZE[0] {
                if letters::has_dot(letter, x, y) {
                    fill(image, left + UVec2::new(x, y) * dot, UVec2::splat(dot), |_| color);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(size: UVec2) -> Picture {
        let rgb = vec![[255; 3]; size.element_product() as usize];
        Picture { size, rgb, light: Vec::new() }
    }

    #[test]
    fn values_are_on_the_ramp() {
        let mut values = vec![Heat::Value(0); 600 * 200];
        values[..3].copy_from_slice(&[Heat::Value(10), Heat::None, Heat::Overflow(300)]);
        let image = draw(&grey(UVec2::new(600, 200)), &values, "TITLE");
        assert_eq!(image.rgb[..4], [RAMP[5], [127; 3], OVERFLOW, RAMP[0]]);
        // The legend has white letters, and says that something did not fit.
        let legend = &image.rgb[600 * 100..];
        assert!(legend.contains(&WHITE) && legend.contains(&OVERFLOW));
    }

    #[test]
    fn ends_are_round() {
        let ends = [0, 10, 11, 21, 50, 51, 999, 65535, u32::MAX].map(round_up);
        assert_eq!(ends, [10, 10, 20, 50, 50, 100, 1000, 100_000, u32::MAX]);
    }

    #[test]
    fn small_pictures_are_drawn() {
        for size in [UVec2::ONE, UVec2::new(1, 300), UVec2::new(300, 1)] {
            let values = vec![Heat::Value(7); size.element_product() as usize];
            assert_eq!(draw(&grey(size), &values, "TITLE").size, size);
        }
    }
}
