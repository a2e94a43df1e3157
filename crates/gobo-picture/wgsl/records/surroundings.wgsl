// A pixel's opaque surface and the ambient light that it sends to the eye: texels of `ambients`.

import package::records::octahedral::{from_octahedral, octahedral};

struct Surroundings {
    depth: f32,         // light depth; 1 without a surface
    normal: vec3<f32>,  // unit, world space; zero for a surface that faces the eye
    light: vec3<f32>,   // ambient light that reaches the eye
}

fn pack_surroundings(surroundings: Surroundings) -> vec4<u32> {
    let faces = select(0.0, 1.0, all(surroundings.normal == vec3(0.0)));
    // At most the largest half.
    let light = min(surroundings.light, vec3(65504.0));
    return vec4(
        bitcast<u32>(surroundings.depth),
        octahedral(surroundings.normal),
        pack2x16float(light.rg),
        pack2x16float(vec2(light.b, faces)),
    );
}

fn unpack_surroundings(bits: vec4<u32>) -> Surroundings {
    let last = unpack2x16float(bits.w);
    let normal = select(from_octahedral(bits.y), vec3(0.0), last.y > 0.0);
    return Surroundings(bitcast<f32>(bits.x), normal, vec3(unpack2x16float(bits.z), last.x));
}
