// Light of an opaque surface that a picture takes over from those through the first two samples of the
// pixels, where both say that light is even around the pixel. Each sample sees its own surface, as in
// multisampling, and has its own light where that changes. Rust:
// crates/gobo-picture/src/picture/first_light.rs.

import package::bind::picture_in::first_surfaces;
import package::bind::uniform::picture_params;
import package::records::point::Point;

// Largest distance of even light from a plane over 3 x 3 pixels, on a scale of square roots, which is about
// the screen's: some 1.2 steps of 8 bits.
const UNEVEN: f32 = 0.01;

const MOST_KEPT: f32 = 65504.0; // the largest half

const WHOLE_PICTURES: u32 = 2u;

const DEPTH_ROUNDING: f32 = 1e-6; // share of a depth

// `depth`: its bits.
fn packed_surface(light: vec3<f32>, tag: u32, depth: u32) -> vec4<u32> {
    let kept = min(light, vec3(MOST_KEPT));
    return vec4(pack2x16float(kept.rg), pack2x16float(vec2(kept.b, 0.0)) | (tag << 16u), depth, 0u);
}

fn surface_at(pixel: vec2<i32>, sample: u32) -> vec4<u32> {
    let last = vec2<i32>(textureDimensions(first_surfaces)) - 1;
    return textureLoad(first_surfaces, clamp(pixel, vec2(0), last), sample, 0);
}

fn light_of_surface(surface: vec4<u32>) -> vec3<f32> {
    return vec3(unpack2x16float(surface.x), unpack2x16float(surface.y & 0xffffu).x);
}

// Light that is taken over, if `is_even`.
struct Taken {
    light: vec3<f32>,
    is_even: bool,
}

// `depth`: of the sample's surface.
fn taken_light(pixel: vec2<u32>, point: Point, depth: f32) -> Taken {
    let middle = vec2<i32>(pixel);
    // A plane through the first sample's light of the pixels around, by least squares.
    var mean = vec3(0.0);
    var across = vec3(0.0);
    var down = vec3(0.0);
    var nearest = 2.0;
    var farthest = -1.0;
    for (var y = -1; y <= 1; y += 1) {
        for (var x = -1; x <= 1; x += 1) {
            let surface = surface_at(middle + vec2(x, y), 0u);
            let light = light_of_surface(surface);
            mean += light / 9.0;
            across += light * f32(x) / 6.0;
            down += light * f32(y) / 6.0;
            nearest = min(nearest, bitcast<f32>(surface.z));
            farthest = max(farthest, bitcast<f32>(surface.z));
        }
    }
    var apart = vec3(0.0);
    for (var sample = 0u; sample < WHOLE_PICTURES; sample += 1u) {
        let offset = f32(sample) * picture_params.second_from_first;
        for (var y = -1; y <= 1; y += 1) {
            for (var x = -1; x <= 1; x += 1) {
                let at = vec2(f32(x), f32(y)) + offset;
                let light = light_of_surface(surface_at(middle + vec2(x, y), sample));
                apart = max(apart, abs(light - mean - across * at.x - down * at.y));
            }
        }
    }
    let white = 1.0 / max(picture_params.exposure, 1e-20);
    let is_flat = all(apart <= UNEVEN * sqrt(mean * white)) & all(mean < vec3(0.5 * MOST_KEPT));
    let is_same = (surface_at(middle, 0u).y >> 16u) == point.tag;
    let rounding = DEPTH_ROUNDING * depth;
    let is_there = (depth >= nearest - rounding) & (depth <= farthest + rounding);
    let offset = picture_params.from_first;
    let light = max(mean + across * offset.x + down * offset.y, vec3(0.0));
    return Taken(light, is_flat & is_same & is_there);
}
