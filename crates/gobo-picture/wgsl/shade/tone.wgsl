// Tone curve from linear light to the screen. CPU reference: crates/gobo-reference/src/shading/tone.rs.

import package::bind::uniform::picture_params;

const TONE_LINEAR: u32 = 1u;
const TONE_FILMIC: u32 = 2u;
// Light beyond which film is white: squares stay finite.
const FILM_WHITE: f32 = 1e6;

// Evaluates all curves: llvmpipe would recompile kernels for a branch by a uniform.
fn tone_mapped(light: vec3<f32>) -> vec3<f32> {
    let tone = picture_params.tone;
    return select(select(neutral(light), light, tone == TONE_LINEAR), filmic(light), tone == TONE_FILMIC);
}

// The curve of a film (Narkowicz 2015, "ACES Filmic Tone Mapping Curve"), with the exposure of the original.
fn filmic(light: vec3<f32>) -> vec3<f32> {
    let x = min(light * 0.6, vec3(FILM_WHITE));
    return (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
}

// Khronos PBR Neutral (2024): hue and saturation stay, only highlights are compressed.
fn neutral(light: vec3<f32>) -> vec3<f32> {
    const START: f32 = 0.76;
    const DESATURATION: f32 = 0.01; // far less than the original: fire stays orange
    let least = min(light.r, min(light.g, light.b));
    let toe = select(0.04, least - 6.25 * least * least, least < 0.08);
    let color = light - toe;
    let peak = max(color.r, max(color.g, color.b));
    let rest = 1.0 - START;
    let new_peak = 1.0 - rest * rest / (max(peak, START) + rest - START);
    let share = 1.0 - 1.0 / (DESATURATION * (max(peak, START) - new_peak) + 1.0);
    let bright = mix(color * (new_peak / max(peak, START)), vec3(new_peak), share);
    return select(color, bright, peak >= START);
}

// Light on the screen, packed.
fn on_screen(light: vec3<f32>) -> u32 {
    return pack4x8unorm(vec4(to_srgb(tone_mapped(light * picture_params.exposure)), 1.0));
}

// sRGB (IEC 61966-2-1) of linear light.
fn to_srgb(linear: vec3<f32>) -> vec3<f32> {
    let c = clamp(linear, vec3(0.0), vec3(1.0));
    let curve = 1.055 * pow(max(c, vec3(1e-6)), vec3(1.0 / 2.4)) - 0.055;
    return select(curve, c * 12.92, c <= vec3(0.0031308));
}
