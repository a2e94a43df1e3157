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
    let a = hit_texel(view, place, look, 0u);
    let b = hit_texel(view, place, look, 1u);
    let c = hit_texel(view, place, look, 2u);
    let d = hit_texel(view, place, look, 3u);
    let light = Light4(
        vec4(a.light.r, b.light.r, c.light.r, d.light.r),
        vec4(a.light.g, b.light.g, c.light.g, d.light.g),
        vec4(a.light.b, b.light.b, c.light.b, d.light.b),
    );
    let depth = vec4(a.depth, b.depth, c.depth, d.depth);
    return must_flush(meet(light, depth, vec4(a.opacity, b.opacity, c.opacity, d.opacity)));
}
