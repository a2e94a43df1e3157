// Unit vectors packed in two snorm16 (Cigolle et al. 2014, section 3). Rust: src/records/pack.rs.

fn octahedral(v: vec3<f32>) -> u32 {
    let n = v / max(abs(v.x) + abs(v.y) + abs(v.z), 1e-20);
    let sides = select(vec2(-1.0), vec2(1.0), n.xy >= vec2(0.0));
    return pack2x16snorm(select(n.xy, (1.0 - abs(n.yx)) * sides, n.z < 0.0));
}

fn from_octahedral(bits: u32) -> vec3<f32> {
    let e = unpack2x16snorm(bits);
    let z = 1.0 - abs(e.x) - abs(e.y);
    let sides = select(vec2(-1.0), vec2(1.0), e >= vec2(0.0));
    return normalize(vec3(select(e, (1.0 - abs(e.yx)) * sides, z < 0.0), z));
}
