// Linear light to the screen: the tone curves of crates/gobo-picture/wgsl/shade/tone.wgsl.

struct Tone {
    exposure: f32,
    curve: u32,
}

@group(0) @binding(0) var<uniform> tone: Tone;
@group(0) @binding(1) var light: texture_2d<f32>;

@vertex
fn tone_corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4(vec2(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

fn filmic(light: vec3<f32>) -> vec3<f32> {
    let x = min(light * 0.6, vec3(1e6));
    return (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
}

// Khronos PBR Neutral (2024), hardly desaturated.
fn neutral(light: vec3<f32>) -> vec3<f32> {
    const START: f32 = 0.76;
    const DESATURATION: f32 = 0.01;
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

@fragment
fn tone_pixel(@builtin(position) clip: vec4<f32>) -> @location(0) vec4<f32> {
    let exposed = max(textureLoad(light, vec2<i32>(clip.xy), 0).rgb, vec3(0.0)) * tone.exposure;
    var mapped = neutral(exposed);
    if tone.curve == 1u {
        mapped = exposed;
    } else if tone.curve == 2u {
        mapped = filmic(exposed);
    }
    let c = clamp(mapped, vec3(0.0), vec3(1.0));
    let curve = 1.055 * pow(max(c, vec3(1e-6)), vec3(1.0 / 2.4)) - 0.055;
    return vec4(select(curve, c * 12.92, c <= vec3(0.0031308)), 1.0);
}
