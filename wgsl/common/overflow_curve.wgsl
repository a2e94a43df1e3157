// Casters whose pairs did not fit, as one hit behind what did: pairs are given room front to back.
// Leaves the sums zero. CPU twin: src/cpu/curve/tile.rs. Needs common/sums_*.wgsl, curve_list.wgsl.
struct Overflowed {
    light: Light4,
    depth: vec4<f32>, // of the nearest that is seen, 1 for none
}

fn overflowed(sum: u32) -> Overflowed {
    let a = overflowed_row(sum);
    let b = overflowed_row(sum + TILE_SIZE);
    let c = overflowed_row(sum + 2u * TILE_SIZE);
    let d = overflowed_row(sum + 3u * TILE_SIZE);
    return Overflowed(
        Light4(vec4(a.r, b.r, c.r, d.r), vec4(a.g, b.g, c.g, d.g), vec4(a.b, b.b, c.b, d.b)),
        vec4(a.a, b.a, c.a, d.a),
    );
}

fn overflowed_row(sum: u32) -> vec4<f32> {
    let row = vec4(light(load_sums(sum)), nearness_to_depth(load_nearness(sum)));
    clear_sums(sum);
    return row;
}

// Whether casters change the light at all.
fn is_light(light: Light4) -> vec4<bool> {
    return (light.red != vec4(1.0)) | (light.green != vec4(1.0)) | (light.blue != vec4(1.0));
}
