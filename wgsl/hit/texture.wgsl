// Images of materials, a layer each: bilinear, repeating; in the picture trilinear, over the area that a
// sample sees. CPU reference: crates/gobo-reference/src/texture.rs.

// Largest number of taps along the longer side of the area that a sample of the picture sees of an image.
const MAX_IMAGE_TAPS: u32 = 4u;

// Mean of an image over an area.
struct Sampled {
    rgba: vec4<f32>,
    level: f32, // of the texels that were read
}

// Weight of the colour of clear texels: just enough that an image without any opacity has a colour.
const CLEAR_WEIGHT: f32 = 0.0000152587890625; // 1/65536

fn color_weight(alpha: f32, shows_clear: bool) -> f32 {
    return select(alpha + CLEAR_WEIGHT, 1.0, shows_clear);
}

// A mean of `weighted_texel`.
fn unweighted(mean: vec4<f32>, shows_clear: bool) -> vec4<f32> {
    return vec4(mean.rgb / color_weight(mean.a, shows_clear), mean.a);
}

fn weighted_texel(
    images: texture_2d_array<f32>,
    at: vec2<i32>,
    layer: u32,
    level: i32,
    shows_clear: bool,
) -> vec4<f32> {
    let texel = textureLoad(images, at, layer, level);
    return vec4(texel.rgb * color_weight(texel.a, shows_clear), texel.a);
}

// `shows_clear`: whether all colours count alike; else by their alpha.
fn sample_texture(
    images: texture_2d_array<f32>,
    layer: u32,
    size: vec2<f32>,
    uv: vec2<f32>,
    shows_clear: bool,
) -> vec4<f32> {
    return unweighted(sample_level(images, layer, size, uv, 0, shows_clear), shows_clear);
}

// Weighted mean of four texels. `size`: of the level [texels].
fn sample_level(
    images: texture_2d_array<f32>,
    layer: u32,
    size: vec2<f32>,
    uv: vec2<f32>,
    level: i32,
    shows_clear: bool,
) -> vec4<f32> {
    let at = (uv - floor(uv)) * size - 0.5;
    let low = floor(at);
    let part = at - low;
    let a = vec2<i32>(select(low, size - 1.0, low < vec2(0.0)));
    let b = vec2<i32>(select(low + 1.0, vec2(0.0), low + 1.0 >= size));
    let top = mix(
        weighted_texel(images, a, layer, level, shows_clear),
        weighted_texel(images, vec2(b.x, a.y), layer, level, shows_clear),
        part.x,
    );
    let bottom = mix(
        weighted_texel(images, vec2(a.x, b.y), layer, level, shows_clear),
        weighted_texel(images, b, layer, level, shows_clear),
        part.x,
    );
    return mix(top, bottom, part.y);
}

fn level_size(size: vec2<f32>, level: i32) -> vec2<f32> {
    return vec2<f32>(max(vec2<u32>(size) >> vec2(u32(level)), vec2(1u)));
}

// Weight below which the last tap of an area is rounding alone.
const LEAST_TAP: f32 = 1e-5;

// Mean over the area that a sample sees: a parallelogram with the sides `right` and `down` [uv] around `uv`,
// by taps along its longer side, each from the level whose texels are as large as the shorter one, or as a
// tap's share of the longer one if that is more ("Feline", McCormack et al. 1999). The last tap has what is
// left of the side: light has no step where another compiler's ratio needs one tap more.
fn sample_area(
    images: texture_2d_array<f32>,
    layer: u32,
    size: vec2<f32>,
    uv: vec2<f32>,
    right: vec2<f32>,
    down: vec2<f32>,
    shows_clear: bool,
) -> Sampled {
    let lengths = vec2(length(right * size), length(down * size));
    let long = max(lengths.x, lengths.y);
    let short = min(lengths.x, lengths.y);
    let along = select(down, right, lengths.x >= lengths.y);
    let ratio = clamp(long / max(short, 1.0), 1.0, f32(MAX_IMAGE_TAPS));
    let last = f32(firstLeadingBit(u32(max(size.x, size.y))));
    let level = clamp(log2(long / ratio), 0.0, last);
    let of_tap = 1.0 / ratio;
    let low = i32(level);
    let part = level - f32(low);
    // A single call that samples: GPUs cache little code, and a pane has images of two kinds.
    let steps = select(1, 2, part > 0.0);
    var rgba = vec4(0.0);
    let end = uv + 0.5 * along;
    for (var left = 1.0; left > LEAST_TAP; left -= of_tap) {
        let weight = min(left, of_tap);
        let at = end - along * (left - 0.5 * weight);
        for (var step = 0; step < steps; step += 1) {
            let share = weight * select(part, 1.0 - part, step == 0);
            let at_level = level_size(size, low + step);
            rgba += share * sample_level(images, layer, at_level, at, low + step, shows_clear);
        }
    }
    return Sampled(unweighted(rgba, shows_clear), level);
}
