// Place where a pixel sees the scene behind its panes: texels of `bends`, zero where it is seen straight.

struct Bend {
    aside: vec2<f32>,  // from the pixel [pixels]
    blur: f32,         // radius [pixels]
    pane: f32,         // light depth of the nearest pane
    passed: vec3<f32>, // share of the light behind that reaches the eye
}

fn pack_bend(bend: Bend) -> vec4<u32> {
    return vec4(
        pack2x16float(bend.aside),
        pack2x16float(bend.passed.rg),
        pack2x16float(vec2(bend.passed.b, bend.blur)),
        bitcast<u32>(bend.pane),
    );
}

fn unpack_bend(bits: vec4<u32>) -> Bend {
    let last = unpack2x16float(bits.z);
    return Bend(unpack2x16float(bits.x), last.y, bitcast<f32>(bits.w), vec3(unpack2x16float(bits.y), last.x));
}
