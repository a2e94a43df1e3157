// Keeps the light behind glass apart for `refraction`, which finds where it is seen.

import package::bind::sampled::layers;
import package::bind::stored::{behinds, bends};
import package::records::bend::{Bend, pack_bend};
import package::records::record::record_texel;

const REFRACTS: bool = true;

// Light of the opaque surface.
fn keep_behind(pixel: vec2<u32>, depth: f32, light: vec3<f32>) {
    // At most the largest half.
    textureStore(behinds, pixel, vec4(min(light, vec3(65504.0)), depth));
}

// Whether the scene behind the layers is seen displaced. `first`: texel of the pixel's layers; `pane`: light
// depth of the nearest pane; `passed`: share of the surface's light that reaches the eye.
fn keep_bend(pixel: vec2<u32>, first: u32, pane: f32, passed: vec3<f32>) -> bool {
    let bits = textureLoad(layers, record_texel(first + 4u), 0).xyz;
    let bend = Bend(bitcast<vec2<f32>>(bits.xy), bitcast<f32>(bits.z), pane, passed);
    let is_bent = any(bits != vec3(0u));
    textureStore(bends, pixel, select(vec4(0u), pack_bend(bend), is_bent));
    return is_bent;
}

// No layer is in front of the surface.
fn keep_straight(pixel: vec2<u32>) {
    textureStore(bends, pixel, vec4(0u));
}
