//! CPU reference of `crates/gobo-picture/wgsl/shade/tone.wgsl`: tone curve from linear light to the screen.
use glam::Vec3;
use gobo::model::Tone;

fn tone_mapped(light: Vec3, tone: Tone) -> Vec3 {
    match tone {
        Tone::Neutral => neutral(light),
        Tone::Linear => light,
        Tone::Filmic => filmic(light),
    }
}

/// Filmic curve (Narkowicz 2015, "ACES Filmic Tone Mapping Curve"), with the exposure of the original.
fn filmic(light: Vec3) -> Vec3 {
    let x = (light * 0.6).min(Vec3::splat(FILM_WHITE));
    (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)
}

/// Light beyond which film is white, so that squares stay finite.
pub const FILM_WHITE: f32 = 1e6;

/// Khronos PBR Neutral (2024): hue and saturation stay, only highlights are compressed.
fn neutral(light: Vec3) -> Vec3 {
    const START: f32 = 0.76;
    /// Far below the original's, so that fire stays orange.
    const DESATURATION: f32 = 0.01;
    let least = light.min_element();
    let toe = if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let color = light - toe;
    let peak = color.max_element();
    if peak < START {
        return color;
    }
    let rest = 1.0 - START;
    let new_peak = 1.0 - rest * rest / (peak + rest - START);
    let share = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    (color * (new_peak / peak)).lerp(Vec3::splat(new_peak), share)
}

/// Light after the tone curve, 0..=1, linear.
pub fn shown(light: Vec3, tone: Tone) -> Vec3 {
    tone_mapped(light, tone).clamp(Vec3::ZERO, Vec3::ONE)
}

/// Light on the screen, by the default curve.
pub fn to_screen(light: Vec3) -> [u8; 3] {
    to_srgb(neutral(light))
}

/// sRGB encoding (IEC 61966-2-1) of linear light.
pub fn to_srgb(linear: Vec3) -> [u8; 3] {
    linear.to_array().map(|v| {
        let v = v.clamp(0.0, 1.0);
        let v = if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
        (v * 255.0 + 0.5).floor() as u8
    })
}
