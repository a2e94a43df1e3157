// What `over` adds, and what the faces of volumes do. CPU twin: src/cpu/caster_hit.rs. Needs
// common/caster_hit.wgsl, order.wgsl, volumes.wgsl, sums.wgsl.

// `over` makes light an affine chain: light L behind a hit becomes L * light + added.
fn added_light(hit: Hit) -> vec3<f32> {
    return select(vec3(0.0), hit.color * hit.opacity, materials[hit.material].transfer == TRANSFER_OVER);
}

// The nearest integers, modulo 2^32. Exact: the wraps are powers of two.
fn modular(v: vec3<f32>) -> vec3<i32> {
    let rounded = round(v);
    let rest = rounded - floor(rounded / 4294967296.0) * 4294967296.0;
    return bitcast<vec3<i32>>(vec3<u32>(rest));
}

// What a face of a volume adds to a ray's sums: optical depth from the near plane to the face, in
// fixed point and modulo 2^32, negative where the ray enters; w: 1 where it leaves, -1 where it
// enters. Faces behind the ray's end count as at its end.
fn crossing(view: GpuView, look: vec4<u32>, texel: vec2<f32>, opaque_depth: f32) -> vec4<i32> {
    if !HAS_TRIANGLES || (look.w & TRIANGLE_BIT) == 0u {
        return vec4(0);
    }
    let absorption = materials[setup_texel(look.x, 4u).w].absorption;
    let depth = triangle_weights(look.x, texel).w;
    let is_back = (setup_texel(look.x, 3u).w & BACK_BIT) != 0u;
    let counts = depth >= 0.0 && any(absorption > vec3(0.0));
    let slope = (texel - view.size * 0.5) / view.scale;
    let stretch = select(1.0, sqrt(1.0 + dot(slope, slope)), view.perspective > 0.0);
    let length = min(depth, opaque_depth) * ((view.far - view.near) * stretch);
    let tau = modular(select(0.0, length, counts) * absorption * FIXED_ONE);
    let leaves = select(0, select(-1, 1, is_back), counts);
    return vec4(tau * leaves, leaves);
}
