// Layers of a pixel, as records of `layers`: colour and pairs, transmittance, two panes, and the place where
// the scene behind is seen.

const LAYER_TEXELS: u32 = 5u;

const NOWHERE: f32 = 4.0; // depth of an empty slot

// A pane whose scattered and mirrored light is evaluated.
struct Pane {
    depth: f32,        // NOWHERE for none
    setup: u32,
    passed: vec3<f32>, // transmittance in front of it
}

const NO_PANE: Pane = Pane(NOWHERE, 0u, vec3(0.0));

fn packed_pane(pane: Pane) -> vec4<u32> {
    let red_green = pack2x16float(pane.passed.rg);
    return vec4(bitcast<u32>(pane.depth), pane.setup, red_green, pack2x16float(vec2(pane.passed.b, 0.0)));
}

fn pane_of(bits: vec4<u32>) -> Pane {
    let passed = vec3(unpack2x16float(bits.z), unpack2x16float(bits.w).x);
    return Pane(bitcast<f32>(bits.x), bits.y, passed);
}
