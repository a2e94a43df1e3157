// A caster of any kind meets the four texels; every hit goes into its curve at once.
// Needs common/gather_curve.wgsl, caster_hit.wgsl.
fn ordered() -> bool {
    return false;
}

fn blocked() -> bool {
    return true;
}

fn slabbed() -> bool {
    return false;
}

fn hit_texel(view: GpuView, place: vec4<u32>, look: vec4<u32>, i: u32) -> Hit {
    let hit = caster_hit(view, place, look, corner + vec2(0.5, f32(i) + 0.5), opaque_depth[i]);
    if !(hit.depth >= 0.0 && hit.depth < opaque_depth[i]) {
        return MISS;
    }
    return hit;
}

// True where the hits cannot wait.
fn visit(view: GpuView, place: vec4<u32>, look: vec4<u32>) -> bool {
    var met = array(MISS, MISS, MISS, MISS);
    for (var i = 0u; ROLLED && i < 4u; i += 1u) {
        met[i] = hit_texel(view, place, look, i);
    }
    if !ROLLED {
        met[0] = hit_texel(view, place, look, 0u);
        met[1] = hit_texel(view, place, look, 1u);
        met[2] = hit_texel(view, place, look, 2u);
        met[3] = hit_texel(view, place, look, 3u);
    }
    let light = Light4(
        vec4(met[0].light.r, met[1].light.r, met[2].light.r, met[3].light.r),
        vec4(met[0].light.g, met[1].light.g, met[2].light.g, met[3].light.g),
        vec4(met[0].light.b, met[1].light.b, met[2].light.b, met[3].light.b),
    );
    let depth = vec4(met[0].depth, met[1].depth, met[2].depth, met[3].depth);
    let opacity = vec4(met[0].opacity, met[1].opacity, met[2].opacity, met[3].opacity);
    return must_flush(meet(light, depth, opacity));
}
