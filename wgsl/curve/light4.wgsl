// Light of four texels, a component each. CPU reference: src/reference/curve/mod.rs.

import package::curve::node::DEPTHS;
import package::features::{HAS_GAIN, HAS_OVER, HAS_VOLUMES};

struct Light4 {
    red: vec4<f32>,
    green: vec4<f32>,
    blue: vec4<f32>,
}

fn encode(v: vec4<f32>) -> vec4<u32> {
    if HAS_GAIN {
        return vec4(
            pack2x16float(vec2(v.x, 0.0)),
            pack2x16float(vec2(v.y, 0.0)),
            pack2x16float(vec2(v.z, 0.0)),
            pack2x16float(vec2(v.w, 0.0)),
        );
    }
    // Only a late hit may brighten what is behind it past white.
    let most = select(3.4e38, 1.0, HAS_OVER || HAS_VOLUMES);
    return vec4<u32>(round(min(v, vec4(most)) * 65535.0));
}

// Like `decode`, in fixed-point steps.
fn level(bits: vec4<u32>) -> vec4<f32> {
    if HAS_GAIN {
        return vec4(
            unpack2x16float(bits.x).x,
            unpack2x16float(bits.y).x,
            unpack2x16float(bits.z).x,
            unpack2x16float(bits.w).x,
        );
    }
    return vec4<f32>(bits);
}

fn decode(bits: vec4<u32>) -> vec4<f32> {
    return level(bits) * select(1.0 / 65535.0, 1.0, HAS_GAIN);
}

fn decode_light(light: vec4<u32>, mean: vec4<u32>) -> Light4 {
    return Light4(
        decode(light & vec4(0xffffu)),
        decode(light >> vec4(16u)),
        decode(mean & vec4(0xffffu)),
    );
}

fn encode_lights(v: Light4) -> vec4<u32> {
    return encode(v.red) | (encode(v.green) << vec4(16u));
}

fn encode_means(v: Light4) -> vec4<u32> {
    return encode(v.blue) | (encode((v.red + v.green + v.blue) * (1.0 / 3.0)) << vec4(16u));
}

fn scaled(a: Light4, b: Light4) -> Light4 {
    return Light4(a.red * b.red, a.green * b.green, a.blue * b.blue);
}

fn fixed(depth: vec4<f32>) -> vec4<u32> {
    return clamp(vec4<u32>(round(depth * DEPTHS)), vec4(1u), vec4(65535u));
}

fn white4() -> Light4 {
    return Light4(vec4(1.0), vec4(1.0), vec4(1.0));
}

fn black4() -> Light4 {
    return Light4(vec4(0.0), vec4(0.0), vec4(0.0));
}

fn light4(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, d: vec3<f32>) -> Light4 {
    return Light4(vec4(a.r, b.r, c.r, d.r), vec4(a.g, b.g, c.g, d.g), vec4(a.b, b.b, c.b, d.b));
}

fn plus(a: Light4, b: Light4) -> Light4 {
    return Light4(a.red + b.red, a.green + b.green, a.blue + b.blue);
}

fn minus(a: Light4, b: Light4) -> Light4 {
    return Light4(a.red - b.red, a.green - b.green, a.blue - b.blue);
}

fn quotient(a: Light4, b: Light4, least: f32) -> Light4 {
    return Light4(
        a.red / max(b.red, vec4(least)),
        a.green / max(b.green, vec4(least)),
        a.blue / max(b.blue, vec4(least)),
    );
}

fn root4(a: Light4) -> Light4 {
    return Light4(sqrt(a.red), sqrt(a.green), sqrt(a.blue));
}

fn selected(a: Light4, b: Light4, is: vec4<bool>) -> Light4 {
    return Light4(select(a.red, b.red, is), select(a.green, b.green, is), select(a.blue, b.blue, is));
}
